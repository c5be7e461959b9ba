"""The table of lights: a new light is one new file and one line in LIGHTS."""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from engine.light import area, distant, point, spot
from engine.light.area import AreaLight
from engine.light.base import ROW, Light
from engine.light.distant import DistantLight
from engine.light.point import PointLight
from engine.light.spot import SpotLight
from engine.numerics.dispatch import by_index

LIGHTS: dict[type[Light], ModuleType] = {
    PointLight: point,
    SpotLight: spot,
    AreaLight: area,
    DistantLight: distant,
}

AnyLight = Annotated[PointLight | SpotLight | AreaLight | DistantLight, Field(discriminator="type")]

INDEX = {description: index for index, description in enumerate(LIGHTS)}

illuminate = by_index([m.illuminate for m in LIGHTS.values()], 4)
pdf = by_index([m.pdf for m in LIGHTS.values()], 3)
emitted = by_index([m.emitted for m in LIGHTS.values()], 3)


class LightTable(NamedTuple):
    """The lights that are on, as kernels want them.

    kind    (l,) int32           index into LIGHTS
    row     (l, ROW) float32     parameters
    extent  (l,) bool            whether a ray can hit it
    """

    kind: NDArray[np.int32]
    row: NDArray[np.float32]
    extent: NDArray[np.bool_]


def light_table(lights: Iterable[Light]) -> LightTable:
    """Pack the enabled lights."""
    on = [light for light in lights if light.enabled]
    return LightTable(
        np.array([INDEX[type(light)] for light in on], np.int32),
        np.array([light.row() for light in on], np.float32).reshape(len(on), ROW),
        np.array([light.has_extent for light in on], np.bool_),
    )
