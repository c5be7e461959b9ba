"""Settings of `direct_to_indirect`; the defaults are the paper's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from engine.errors import InputError
from engine.methods.base import take_declared_types
from engine.numerics.haar import levels

MAX_GATHER_SAMPLES = 4**11


@dataclass(frozen=True)
class Settings:
    """What a precompute is made with. Raises InputError for a value out of range."""

    gather_samples: int = 65536
    """Samples of the gather cloud: a power of four from 256 to 4,194,304 (§3.4, §6)."""

    cloud: Literal["uniform", "importance"] = "uniform"
    """Where they lie (§4.1): evenly over all surfaces that light can come from, or the more densely
    the more of what is reflected there ends up in the picture. `importance` is for views that show
    part of a larger scene: a corner of a hall is 2.3 % off in place of 3.0 to 3.2 with 4,096 or
    16,384 samples, and 1.7 to 1.9 with 6 `bounces`, which it wants more of. Where all is in view,
    as in the Cornell box, both are alike. With few samples light far from the view may be worse."""

    coefficients: int = 100
    """Wavelets that a view sample keeps: 1 to 4096 (§3.7, Table 2); see `fixed_view.packing`."""

    bounce_coefficients: int = 40
    """Wavelets that a gather sample keeps: 1 to 4096 (§3.7, Table 2)."""

    bounces: int = 3
    """Bounces between gather samples, before the final gather: 0 to 64 (§4.3, path length)."""

    position_weight: float = 6.0
    """K of eq. 9, the weight of positions against normals, 1 to 1000. The paper takes 20 to 40; in
    rooms 6 loses a fifth less to culling, since clusters then seldom mix walls."""

    gather: Literal["rays", "links"] = "rays"
    """How rows are found: by rays that land on gather samples, or by the paper's links to clusters
    (§4.3). See `fixed_view.gather_rays` and `fixed_view.links`."""

    view_rays: int = 233
    """Rays of a view sample's matt part: 16 to 65,536."""

    gloss_rays: int = 233
    """Rays of a view sample's glossy part: 16 to 65,536."""

    bounce_rays: int = 233
    """Rays of a gather sample: 16 to 65,536."""

    opening_rays: int = 1024
    """Rays of a view sample through windows and other openings to the environment: 0 to 65,536. See
    `fixed_view.openings`."""

    gloss_coefficients: int = 40
    """Wavelets that a view sample keeps for its glossy part: 1 to 4096."""

    link_size: float = 0.05
    """Form factor above which a cluster is opened for a view sample: 0.0005 to 1 (§4.3)."""

    bounce_link_size: float = 0.1
    """The same for a gather sample."""

    patch_size: float = 0.5
    """Diagonal by distance above which the form factor is refined within a link: 0.05 to 2."""

    seed: int = 1
    """Of all random choices: 0 to 2^31."""

    def __post_init__(self) -> None:
        take_declared_types(self)
        for name, low, high in (
            ("gather_samples", 256, MAX_GATHER_SAMPLES),
            ("coefficients", 1, 4096),
            ("bounce_coefficients", 1, 4096),
            ("bounces", 0, 64),
            ("position_weight", 1, 1000),
            ("view_rays", 16, 65536),
            ("gloss_rays", 16, 65536),
            ("bounce_rays", 16, 65536),
            ("opening_rays", 0, 65536),
            ("gloss_coefficients", 1, 4096),
            ("link_size", 0.0005, 1),
            ("bounce_link_size", 0.0005, 1),
            ("patch_size", 0.05, 2),
            ("seed", 0, 2**31),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{value} is not between {low} and {high}", field=name)
        if self.cloud not in ("uniform", "importance"):
            raise InputError(f"{self.cloud!r} is neither uniform nor importance", field="cloud")
        if self.gather not in ("rays", "links"):
            raise InputError(f"{self.gather!r} is neither rays nor links", field="gather")
        try:
            levels(self.gather_samples)
        except ValueError as error:
            raise InputError(f"{error}: 4096, 16384, 65536, ...", field="gather_samples") from None
