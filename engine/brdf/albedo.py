"""How much of the light a BRDF reflects, for every model alike.

The directional-hemispherical reflectance a(wo) = ∫ f(wi, wo) cos θ_i dwi is estimated at the fixed
points of a three-dimensional lattice sent through the model's own sampler. So it resolves any lobe
that the sampler follows, costs the same for all, and is the same on every call.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from engine.brdf import table
from engine.brdf.arrays import broadcast
from engine.brdf.base import GRAIN
from engine.diagnosis import Diagnosis
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

POINTS = 4096
TOLERANCE = 5e-3  # of an albedo: what the quadrature may be off, and what no eye sees
ANGLES_DEGREES = (0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 75.0, 80.0, 85.0, 88.0)

# Fractional parts of i·φ^-1, i·φ^-2, i·φ^-3 with φ⁴ = φ + 1, φ > 1, fill the cube evenly: the
# generalisation of the golden-ratio sequence to three dimensions (Roberts 2018).
_PHI = 1.2207440846057596


def albedo(
    model: ArrayLike, rows: ArrayLike, wo: ArrayLike, points: int = POINTS
) -> NDArray[np.float64]:
    """Directional-hemispherical reflectance (n, 3), linear RGB.

    model () or (n,), rows (ROW,) or (n, ROW), wo (3,) or (n, 3): as for `evaluate`. Its error is
    below TOLERANCE at the default number of `points`.
    """
    models, parameters, directions, _ = broadcast(model, rows, wo, (0.0, 0.0, 0.0))
    out = np.zeros((len(models), 3))
    for_ranges(_albedo, len(models), models, parameters, directions, points, out, grain=4)
    return out


def hemispherical_albedo(
    model: ArrayLike, rows: ArrayLike, points: int = POINTS
) -> NDArray[np.float64]:
    """Bihemispherical reflectance (n, 3): `albedo` under even light, ∫ a(wo) cos θ_o dwo / π.

    It is the albedo that light which comes from everywhere meets.
    """
    models = np.atleast_1d(np.asarray(model, np.int32))
    parameters = np.atleast_2d(np.asarray(rows, np.float32))
    n = np.broadcast_shapes((len(models),), (len(parameters),))[0]
    # With s = sin² θ the cosine weight is even, so Gauss-Legendre points in s do.
    nodes, weights = np.polynomial.legendre.leggauss(12)
    s = 0.5 * (nodes + 1.0)
    # Azimuth matters to anisotropic models alone. Most are even about both axes of their grain, and
    # one quarter tells of all; what was measured may not be, so each angle is of another quarter.
    turns = 4 if parameters[:, GRAIN:].any() else 1
    quarter = np.arange(turns)
    phi = (quarter + 0.5) * np.pi / (2 * turns)
    phi = np.tile(np.where(quarter % 2, -phi, phi) + np.pi * (quarter > 1), len(s))
    s, weights = np.repeat(s, turns), np.repeat(weights / turns, turns)
    wo = np.stack([np.sqrt(s) * np.cos(phi), np.sqrt(s) * np.sin(phi), np.sqrt(1.0 - s)], axis=1)
    k = len(wo)
    each = albedo(
        np.repeat(np.broadcast_to(models, n), k),
        np.repeat(np.broadcast_to(parameters, (n, parameters.shape[1])), k, axis=0),
        np.tile(wo, (n, 1)),
        points,
    )
    return np.einsum("nkc,k->nc", each.reshape(n, k, 3), 0.5 * weights)


def albedo_diagnosis(name: str, model: int, row: NDArray[np.float32]) -> Diagnosis | None:
    """What to say of a material that reflects more than it receives; None where it does not.

    name is the material's, row (16,) its parameters. The BRDF is used as it is all the same: light
    then grows from bounce to bounce, or for ever.
    """
    theta = np.radians(ANGLES_DEGREES)
    wo = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=1)
    each = albedo(model, row, wo)
    angle, channel = np.unravel_index(np.argmax(each), each.shape)
    worst = float(each[angle, channel])
    if worst <= 1.0 + TOLERANCE:
        return None
    return Diagnosis(
        "albedo_above_one",
        f"material {name!r} reflects {worst:.2f} times the {('red', 'green', 'blue')[channel]} "
        f"light it receives, seen {ANGLES_DEGREES[angle]:g} degrees from the normal; "
        "lower its diffuse or specular reflectance, or indirect light will be too bright",
        worst - 1.0,
    )


@njit(cache=True, nogil=True)
def _albedo(start, stop, models, rows, wo, points, out):
    for i in range(start, stop):
        w = vec(wo, i)
        r = g = b = 0.0
        for k in range(points):
            u = (
                (0.5 + k / _PHI) % 1.0,
                (0.5 + k / (_PHI * _PHI)) % 1.0,
                (0.5 + k / (_PHI * _PHI * _PHI)) % 1.0,
            )
            wi = table.sample(models[i], rows[i], w, u)
            density = table.pdf(models[i], rows[i], wi, w)
            if density > 0.0:
                f = table.evaluate(models[i], rows[i], wi, w)
                weight = wi[2] / density
                r += f[0] * weight
                g += f[1] * weight
                b += f[2] * weight
        out[i, 0], out[i, 1], out[i, 2] = r / points, g / points, b / points
