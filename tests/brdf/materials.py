"""Materials to test every model with, made from the fields of its description."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf import Material
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import NODES, WEIGHTS, HalfAngleCurve
from engine.brdf.measured import BUILT_IN, Measured
from engine.brdf.published import PUBLISHED
from engine.brdf.table import INDEX, MODELS

ROUGH_ANGLES = (0.0, 35.0, 70.0)
BLACK = (0.0, 0.0, 0.0)


def colours(description: type[Material]) -> list[str]:
    """Names of the fields that hold a reflectance."""
    return [
        name
        for name, field in description.model_fields.items()
        if name != "emission"
        and isinstance(field.default, tuple)
        and isinstance(field.default[0], float)
        and len(field.default) == 3
    ]


def numbers(description: type[Material]) -> dict[str, tuple[float, float]]:
    """Names of the fields that hold a number, with their lower and upper bound."""
    found = {}
    for name, field in description.model_fields.items():
        if isinstance(field.default, float):
            low = next(m.ge for m in field.metadata if hasattr(m, "ge"))
            high = next(m.le for m in field.metadata if hasattr(m, "le"))
            found[name] = (float(low), float(high))
    return found


def lobes(description: type[Material]) -> list[Material]:
    """The model with all reflectances black but one, for each one, at ordinary sharpness."""
    names = colours(description)
    return [
        description(**{name: BLACK for name in names} | {kept: (0.7, 0.7, 0.7)}) for kept in names
    ]


def extremes(description: type[Material]) -> list[Material]:
    """The default, and the model with each of its numbers at either bound."""
    made: list[dict[str, Any]] = [{}]
    for name, bounds in numbers(description).items():
        made += [{name: bound} for bound in bounds]
    return [description(**fields) for fields in made]


def name_of(material: Material) -> str:
    """A readable test id."""
    published = [name for name, known in PUBLISHED.items() if known is material]
    if published:
        return published[0].replace(" ", "-")
    given = material.model_dump(exclude_defaults=True)
    plain = {k: v[0] if isinstance(v, tuple) else v for k, v in given.items()}
    parts = [v if isinstance(v, str) else f"{k}={v:g}" for k, v in plain.items()]
    return "-".join([material.model_dump()["type"], *parts])


def model_and_row(material: Material) -> tuple[int, NDArray[np.float32]]:
    """What the functions of `engine.brdf` take."""
    return INDEX[type(material)], material.row()


LOBES = [m for description in MODELS for m in lobes(description)]


def spike(node: int, cover: float = 1.0, **fields: Any) -> HalfAngleCurve:
    """Facets about the angle of one node, which cover so much of the surface."""
    curve = [cover / WEIGHTS[k] if k == node else 0 for k in range(NODES)]
    return HalfAngleCurve(**{"curve": curve, **fields})


EXTREMES = [
    *(m for description in MODELS for m in extremes(description)),
    *PUBLISHED.values(),
    # The default is isotropic, these are mirrored along their grain.
    *(Measured(file=name) for name in BUILT_IN[1:]),
    *(spike(node, diffuse=BLACK, specular=(0.9,) * 3) for node in (5, 9, 14)),
    spike(0, cover=0),
    spike(11, cover=0.4),
]
# Models whose reflectance rises to white at grazing angles, whatever their colours.
WITH_FRESNEL = (Ggx, AshikhminShirley, CookTorrance, HalfAngleCurve)


def direction(theta_degrees: float, phi_degrees: float = 20.0) -> NDArray[np.float64]:
    """Unit (3,) at an angle to the normal."""
    theta, phi = np.radians(theta_degrees), np.radians(phi_degrees)
    return np.array(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], np.float64
    )


def hemisphere(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    """(n, 3) directions, uniform over the upper hemisphere."""
    z, phi = rng.random(n), 2 * np.pi * rng.random(n)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
