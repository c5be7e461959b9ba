"""Settings of `glossy_prt`; the defaults are the paper's."""

from __future__ import annotations

from dataclasses import dataclass

from engine.errors import InputError
from engine.methods.base import take_declared_types


@dataclass(frozen=True)
class Settings:
    """What a precompute is made with. Raises InputError for a value out of range."""

    terms: int = 4
    """K, terms of a glossy material's BRDF: 1 to 64 (§3.3.1). A matt one has one."""

    coefficients: int = 128
    """N_l, wavelets that the transport vectors of a vertex keep, the same for all terms: 6 to 4096
    (§4.1.1). Where there are clusters, of the vectors that bounces are gathered from alone."""

    tolerance: float = 0.01
    """Part of a vector's norm that may be left out even where there is room for it: 0 to 1."""

    cluster_error: float = 0.05
    """Part of the norm of the vectors of a cluster of vertices that a basis of its own may leave
    out, and twice that of what bounces: 0 to 0.5. With 0 every vertex has its own wavelets, as
    in the paper."""

    light_texels: int = 64
    """Texels along a face of the light's cube map: 8, 16, 32 or 64 (§4.1)."""

    visibility_texels: int = 128
    """The same of the visibility that is averaged down to it: as many, or twice as many (§4.1)."""

    visibility: str = "rays"
    """What finds it: `rays`, coarsely first, or `gl`, which rasterises all of it as the paper does
    and wants a GPU."""

    occluder_vertices: int = 0
    """About how many vertices each object keeps in the model that visibility is looked for in
    (§4.1, §5.1: 7,600 of the bunny's 36,000): 100 or more. With 0 it keeps all."""

    coarse_texels: int = 16
    """Where visibility starts from: cells of 90 / 16 degrees that agree with the cells around them
    are not looked at more finely. `visibility_texels` asks for all of them."""

    brdf_texels: int = 48
    """Texels along a light map and a view map: 8 to 128 (§4)."""

    bounces: int = 1
    """Most interreflection passes: 0 to 16 (§3.2: one or two are enough for open scenes)."""

    remaining: float = 0.01
    """No further pass is made once what would follow is less than this part of all light."""

    gather_texels: int = 32
    """Texels along a face of the cube map that gathers a bounce: 4, 8, 16, 32 or 64 (§4.2)."""

    bounce_coefficients: int = 64
    """Wavelets that a vector of bounced light keeps, which is smoother: 6 to 4096."""

    def __post_init__(self) -> None:
        take_declared_types(self)
        for name, low, high in (
            ("terms", 1, 64),
            ("coefficients", 6, 4096),
            ("brdf_texels", 8, 128),
            ("bounces", 0, 16),
            ("remaining", 0, 1),
            ("tolerance", 0, 1),
            ("cluster_error", 0, 0.5),
            ("bounce_coefficients", 6, 4096),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{value} is not between {low} and {high}", field=name)
        if self.visibility not in ("rays", "gl"):
            raise InputError(f"{self.visibility!r} is neither rays nor gl", field="visibility")
        if self.occluder_vertices != 0 and self.occluder_vertices < 100:
            raise InputError(
                f"{self.occluder_vertices} is neither 0 nor at least 100", field="occluder_vertices"
            )
        light, fine, coarse = self.light_texels, self.visibility_texels, self.coarse_texels
        if light not in (8, 16, 32, 64):
            raise InputError(f"{light} is none of 8, 16, 32, 64", field="light_texels")
        if self.gather_texels not in (4, 8, 16, 32, 64):
            raise InputError(
                f"{self.gather_texels} is none of 4, 8, 16, 32, 64", field="gather_texels"
            )
        if fine not in (light, 2 * light):
            raise InputError(
                f"{fine} is neither light_texels nor twice as many", field="visibility_texels"
            )
        if not (4 <= coarse <= fine and coarse & (coarse - 1) == 0):
            raise InputError(
                f"{coarse} is no power of two from 4 to visibility_texels", field="coarse_texels"
            )
