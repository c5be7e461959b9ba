"""The BRDF contract.

A model is one file with a `Material` subclass, its description in JSON, and three Numba kernels:

    evaluate(p, wi, wo)  -> (r, g, b)   BRDF in sr⁻¹, without the cosine
    sample(p, wo, u)     -> (x, y, z)   an incident direction; z ≤ 0 means that the light is lost
    pdf(p, wi, wo)       -> float       density of `sample` over solid angle, 0 below the surface

`p` is a row of ROW float32 numbers, made by the description's `row()`; `wi`, `wo` are unit tuples
in the local frame (z the normal), both leaving the surface; `u` is three numbers in [0, 1).
All three must return 0 (or a direction that is lost) where wi or wo lies below the surface, and
never NaN. `albedo` is the same for every model: see `engine.brdf.albedo`.

Rows share their first places, so that textures can replace them without knowing the model. Where
the specular reflectance is black, every model is Lambert's of the diffuse one:
"""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.numerics.description import Description, Radiance
from engine.numerics.dispatch import formula
from engine.numerics.vec import add, length, normalize

ROW = 36
DIFFUSE = 0  # three places: diffuse reflectance, linear RGB
SPECULAR = 3  # three places: specular reflectance or reflectance at normal incidence
ROUGHNESS = 6  # one place: the model's roughness or exponent
EXTRA = 7  # from here on: the model's own
# The last two places, for anisotropic models: cosine and sine of the angle from the local x axis to
# the direction in which the surface is brushed; both 0 for all others. So an integrator need not
# know of it: it takes any frame about the normal, and who fills in the row says how it lies.
GRAIN = ROW - 2


class Material(Description):
    """What every material has, whatever its model."""

    gloss_is_linear: ClassVar[bool] = False
    """Whether the specular reflectance is a factor of all that is not matt."""

    emission: Radiance = Field((0.0, 0.0, 0.0), description="radiance emitted, W·sr⁻¹·m⁻²")

    def located(self, folder: Path) -> Self:
        """The material with the files that it names, which lie in `folder`, read.

        Raises SceneError, with the material's field and the file, where one cannot be read.
        """
        return self

    def row(self) -> NDArray[np.float32]:
        """(ROW,) float32 parameters for the kernels; every kind has its own."""
        raise NotImplementedError

    def _fill(
        self,
        diffuse: tuple[float, float, float],
        specular: tuple[float, float, float] = (0.0, 0.0, 0.0),
        roughness: float = 0.0,
    ) -> NDArray[np.float32]:
        row = np.zeros(ROW, np.float32)
        row[DIFFUSE : DIFFUSE + 3] = diffuse
        row[SPECULAR : SPECULAR + 3] = specular
        row[ROUGHNESS] = roughness
        return row


def without_grain(rows: NDArray[np.float32]) -> NDArray[np.float32]:
    """Rows (n, ROW) as they are where the grain lies along the local x axis.

    For what does not depend on azimuth; rows of one material on a curved surface are equal then.
    """
    out = rows.copy()
    out[:, GRAIN] = rows[:, GRAIN:].any(axis=1)
    out[:, GRAIN + 1] = 0
    return out


@njit
def diffuse_colour(p):
    """Diffuse reflectance of a row."""
    return (float(p[0]), float(p[1]), float(p[2]))


@njit
def specular_colour(p):
    """Specular reflectance of a row."""
    return (float(p[3]), float(p[4]), float(p[5]))


@njit
def is_matt(p):
    """Whether a row reflects the same in all directions."""
    return max(p[3], max(p[4], p[5])) <= 0.0


@njit
def luminance(c):
    """Rec. 709 luminance of a linear RGB triple, used to weigh lobes against each other."""
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]


@njit
def share(a, b):
    """Luminance of a as a part of that of a and b together; 1 where both are black."""
    wa, wb = luminance(a), luminance(b)
    return wa / (wa + wb) if wb > 0.0 else 1.0


@njit
def half(wi, wo):
    """(h, wo·h): the half vector and the cosine of its angle to either direction.

    The cosine is half the length of wi + wo, where near grazing angles the product of the vectors
    would have no digits left.
    """
    both = add(wi, wo)
    return normalize(both), 0.5 * length(both)


@formula
def seen_turned(c, s, w):
    """w in a frame that is turned about z by an angle with cosine c and sine s."""
    return (c * w[0] + s * w[1], c * w[1] - s * w[0], w[2])


@njit
def to_grain(p, w):
    """The local direction w in the frame whose x axis runs along the grain of a row."""
    return seen_turned(float(p[GRAIN]), float(p[GRAIN + 1]), w)


@njit
def from_grain(p, w):
    """The inverse of `to_grain`."""
    return seen_turned(float(p[GRAIN]), -float(p[GRAIN + 1]), w)
