"""Lewis's plausible Phong: the formula of `phong`, published a year before.

Lewis 1993, *Making Shaders More Physically Plausible*: Phong's shader, read as a BRDF, divides by
cos θ_i and so is not reciprocal. Without that, and with a factor that lets the lobe reflect ρ_s at
normal incidence,

    f = ρ_d / π + ρ_s (n + 2) / 2π · cosⁿ α

is plausible where ρ_d + ρ_s is at most 1. This is what Lafortune and Willems 1994 sample, so the
description is that of `Phong` but for its name; its kernels and shader compute it.
"""

from __future__ import annotations

from typing import Literal

from engine.brdf.phong import Phong


class Lewis(Phong):
    """A matt or glossy plastic, as published in 1993."""

    type: Literal["lewis"] = "lewis"  # type: ignore[assignment]
