"""A clear sky as an environment map: Preetham, Shirley, Smits 1999, *A Practical Analytic Model for
Daylight*.

Luminance and chromaticity (Y, x, y) of the sky in a direction at angle θ from the zenith and γ from
the sun, whose own angle from the zenith is θs, are (eq. 4)

    Y ∝ F(θ, γ),    F(θ, γ) = (1 + A e^(B / cos θ)) (1 + C e^(D γ) + E cos² γ),

and x = x_z F(θ, γ) / F(0, θs), likewise y, each with five coefficients that are linear in the
turbidity (appendix A.2); x_z, y_z are those of the zenith. How bright it is on the whole the paper
takes from a formula for the zenith that gives 1.6 to 2.2 times the light that is measured. So the
light on the ground is set here, to that of a clear sky by the IES Lighting Handbook, which grows
with the haze as it does in the simulated atmosphere of Hosek and Wilkie 2012:

    E = (0.8 + 15.5 √cos θs) (0.57 + 0.21 T) · 1000 lux

The unit is 1000 cd/m². The sun's disk is not in it: that is a light of its own
(`engine.light.sun`), with the same direction.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import unit
from engine.numerics.description import Description, Point, Reflectance

HEIGHT = 128  # of the map, pixels
PARTS = 64  # of the angles over which a sky's light is summed up

# Rows A to E, columns slope and offset over the turbidity.
_PEREZ = {
    "Y": ((0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771),
          (-0.0670, 0.3703)),
    "x": ((-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989),
          (-0.0033, 0.0452)),
    "y": ((-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537),
          (-0.0109, 0.0529)),
}  # fmt: skip
# Of the zenith: powers 2, 1, 0 of the turbidity by powers 3, 2, 1, 0 of θs.
_ZENITH = {
    "x": ((0.00166, -0.00375, 0.00209, 0.0), (-0.02903, 0.06377, -0.03202, 0.00394),
          (0.11693, -0.21196, 0.06052, 0.25886)),
    "y": ((0.00275, -0.00610, 0.00317, 0.0), (-0.04214, 0.08970, -0.04153, 0.00516),
          (0.15346, -0.26756, 0.06670, 0.26688)),
}  # fmt: skip
# IEC 61966-2-1, to linear sRGB.
_FROM_XYZ = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


class Sky(Description):
    """A clear sky and an even ground below it; radiance in 1000 cd/m²."""

    sun_direction: Annotated[
        Point, Field(description="where the sun's light travels, as of a light of type sun")
    ]
    turbidity: Annotated[
        float, Field(ge=2, le=10, description="2 is very clear air, 10 is hazy")
    ] = 3.0
    ground: Annotated[Reflectance, Field(description="albedo of what lies below the horizon")] = (
        0.2,
        0.2,
        0.2,
    )

    @model_validator(mode="after")
    def _sun_is_up(self) -> Sky:
        if unit(self.sun_direction, "sun_direction is zero")[1] > 0:
            raise ValueError("sun_direction points up: the sun would be below the horizon")
        return self


def sky(description: Sky) -> NDArray[np.float32]:
    """(128, 256, 3) float32 linear radiance, laid out as every environment map."""
    theta = (np.arange(HEIGHT)[:, None] + 0.5) * np.pi / HEIGHT
    phi = (np.arange(2 * HEIGHT)[None] + 0.5) * np.pi / HEIGHT - np.pi
    d = np.stack(np.broadcast_arrays(
        np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)
    ), axis=-1)  # fmt: skip
    image = radiance(description, d[: HEIGHT // 2])
    # The ground reflects what falls on it from the sky, evenly.
    solid = np.sin(theta[: HEIGHT // 2]) * (np.pi / HEIGHT) ** 2
    irradiance = (image * (solid * np.cos(theta[: HEIGHT // 2]))[..., None]).sum(axis=(0, 1))
    below = np.broadcast_to(np.array(description.ground) * irradiance / np.pi, image.shape)
    return np.concatenate([image, below]).astype(np.float32)


def radiance(description: Sky, d: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear radiance (..., 3) from unit directions d (..., 3) above the horizon."""
    turbidity = description.turbidity
    to_sun = -np.array(unit(description.sun_direction))
    sun = math.acos(min(1.0, to_sun[1]))
    cosine, gamma = np.maximum(d[..., 1], 1e-3), np.arccos(np.clip(d @ to_sun, -1, 1))
    zenith = {"Y": _brightness(turbidity, sun)}
    for name, rows in _ZENITH.items():
        powers = np.array([sun**3, sun**2, sun, 1.0])
        zenith[name] = float(np.polyval(np.array(rows) @ powers, turbidity))
    luminance, x, y = (
        zenith[name]
        * _perez(_PEREZ[name], turbidity, cosine, gamma)
        / _perez(_PEREZ[name], turbidity, np.float64(1.0), np.float64(sun))
        for name in "Yxy"
    )
    xyz = np.stack([x / y, np.ones_like(x), (1 - x - y) / y], axis=-1) * luminance[..., None]
    return np.maximum(xyz @ _FROM_XYZ.T, 0)


def illuminance(turbidity: float, sun: float) -> float:
    """Of level ground by the sky alone, in 1000 lux, for a sun at an angle from the zenith."""
    return (0.8 + 15.5 * math.sqrt(max(0.0, math.cos(sun)))) * (0.57 + 0.21 * turbidity)


def _brightness(turbidity: float, sun: float) -> float:
    """Luminance of the zenith with which the sky gives its illuminance."""
    # Equal parts of cos² θ are equal parts of the light on the ground.
    cosine = np.sqrt((np.arange(PARTS)[:, None] + 0.5) / PARTS)
    phi = (np.arange(PARTS)[None] + 0.5) * 2 * math.pi / PARTS
    sine = np.sqrt(1 - cosine**2)
    gamma = np.arccos(np.clip(sine * math.sin(sun) * np.cos(phi) + cosine * math.cos(sun), -1, 1))
    shape = _perez(_PEREZ["Y"], turbidity, cosine, gamma)
    top = _perez(_PEREZ["Y"], turbidity, np.float64(1.0), np.float64(sun))
    return illuminance(turbidity, sun) * float(top) / (math.pi * float(shape.mean()))


def _perez(
    coefficients: tuple[tuple[float, float], ...],
    turbidity: float,
    cosine: NDArray[np.float64] | np.float64,
    gamma: NDArray[np.float64] | np.float64,
) -> NDArray[np.float64]:
    a, b, c, d, e = (slope * turbidity + offset for slope, offset in coefficients)
    return np.asarray(
        (1 + a * np.exp(b / cosine)) * (1 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)
    )
