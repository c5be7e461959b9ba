"""Settings of `wavelet_brdf`; the defaults are the paper's, but for the error."""

from __future__ import annotations

from dataclasses import dataclass

from engine.brdf.wavelet.encoding import Target
from engine.errors import InputError
from engine.methods.base import take_declared_types

DETAILS = ("distance", "footprint", "finest")
FILTERS = ("bilinear", "nearest")
SHOWN = ("radiance", "levels")
RUN_TIME = frozenset({"detail", "alpha", "shadows", "show"})  # the codes do not depend on them


@dataclass(frozen=True)
class Settings:
    """What a precompute is made with. Raises InputError for a value out of range."""

    cells: int = 32
    """Cells of directions along either angle of a hemisphere: 8, 16, 32 or 64 (§6.2). An isotropic
    BRDF has twice as many, in less memory."""

    error: float = 0.01
    """Mean relative error of a code over its samples: 0.0001 to 1 (§6.2, table 1)."""

    bytes: int = 0
    """With more than 0, a code has at most so many instead, whatever its error."""

    floor: float = 0.001
    """ε, part of the mean of a BRDF below which its values blur: 1e-9 to 1 (§5.1)."""

    detail: str = "distance"
    """What picks the level of detail: `distance`, as the paper does; `footprint`, how far the
    directions turn from a pixel to the next; or `finest` everywhere (§5.4.1)."""

    alpha: float = 0.15
    """α: the finest level is shown up to 1/α diagonals of the scene, and twice as far the next one:
    0 to 1000 (§5.4.1)."""

    level: float = 0.0
    """No finer level than this one is shown: 0, the finest, to 5 (table 2)."""

    filter: str = "bilinear"
    """Between directions values are `bilinear`, or that of the `nearest` (§5.4.2)."""

    shadows: bool = True
    """Whether what stands before a light hides it, found by a ray for every pixel and light."""

    show: str = "radiance"
    """`radiance`, or the `levels` of detail in false colours (figure 10)."""

    def __post_init__(self) -> None:
        take_declared_types(self)
        if self.cells not in (8, 16, 32, 64):
            raise InputError(f"{self.cells} is none of 8, 16, 32, 64", field="cells")
        for name, low, high in (
            ("error", 1e-4, 1),
            ("floor", 1e-9, 1),
            ("alpha", 0, 1000),
            ("level", 0, 5),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{value} is not between {low} and {high}", field=name)
        if self.bytes != 0 and not 1000 <= self.bytes <= 1 << 28:
            raise InputError(f"{self.bytes} is neither 0 nor from 1000 to {1 << 28}", field="bytes")
        for name, known in (("detail", DETAILS), ("filter", FILTERS), ("show", SHOWN)):
            if getattr(self, name) not in known:
                words = ", ".join(known)
                raise InputError(f"{getattr(self, name)!r} is none of {words}", field=name)

    @property
    def bits(self) -> int:
        """log2 of `cells`."""
        return self.cells.bit_length() - 1

    @property
    def target(self) -> Target:
        """What an encoding is to reach."""
        return Target(self.bytes or None, self.error, self.floor)
