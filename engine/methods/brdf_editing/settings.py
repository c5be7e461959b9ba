"""Settings of `brdf_editing`; the defaults are the paper's where it has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from engine.errors import InputError
from engine.methods.base import take_declared_types
from engine.numerics.haar import levels

MOST_SAMPLES = 65536  # so that sixteen bits name one


@dataclass(frozen=True)
class Settings:
    """What a precompute is made with. Raises InputError for a value out of range."""

    bands: int = 64
    """J, elements that a lobe is a sum of as it is seen: 4 to 1024 (§3.1, Table II)."""

    second_bands: int = 1
    """The same for the bounce behind it: 4 to 64, or 1 for a matt one. Caustics need 16, mirrors
    that show something glossy 8 (§4.3)."""

    basis: Literal["tents", "boxes"] = "tents"
    """What they are; the paper's are boxes. See `engine.brdf.curve_basis`."""

    bounces: int = 3
    """Matt bounces after the one that is seen: 0 to 8. The paper's series (64, 1, 1, 1) has three
    (§4.2)."""

    view_rays: int = 256
    """Rays of a view sample: 16 to 4096."""

    lobe_rays: float = 0.3
    """Part of them that follow a Blinn-Phong lobe, the others the cosine: 0 to 0.9 (§5.1)."""

    lobe_exponent: int = 200
    """Of that lobe: 1 to 100,000 (§5.1)."""

    gather_samples: int = 65536
    """Samples of the gather cloud, which later bounces are found on: 256, 1024, ... 65,536."""

    bounce_rays: int = 233
    """Rays of a gather sample: 16 to 65,536."""

    bounce_coefficients: int = 40
    """Wavelets that a gather sample keeps: 1 to 4096."""

    position_weight: float = 6.0
    """Weight of positions against normals in the order of the cloud: 1 to 1000."""

    seed: int = 1
    """Of all random choices: 0 to 2^31."""

    def __post_init__(self) -> None:
        take_declared_types(self)
        for name, low, high in (
            ("bands", 4, 1024),
            ("second_bands", 1, 64),
            ("bounces", 0, 8),
            ("view_rays", 16, 4096),
            ("lobe_rays", 0, 0.9),
            ("lobe_exponent", 1, 100_000),
            ("gather_samples", 256, MOST_SAMPLES),
            ("bounce_rays", 16, 65536),
            ("bounce_coefficients", 1, 4096),
            ("position_weight", 1, 1000),
            ("seed", 0, 2**31),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{value} is not between {low} and {high}", field=name)
        if 1 < self.second_bands < 4:
            raise InputError(
                f"{self.second_bands} is neither 1 nor 4 or more", field="second_bands"
            )
        if self.basis not in ("tents", "boxes"):
            raise InputError(f"{self.basis!r} is neither tents nor boxes", field="basis")
        try:
            levels(self.gather_samples)
        except ValueError as error:
            raise InputError(f"{error}: 4096, 16384, 65536", field="gather_samples") from None

    @property
    def cosine_count(self) -> int:
        """Rays of a view sample that follow the cosine."""
        return self.view_rays - round(self.lobe_rays * self.view_rays)
