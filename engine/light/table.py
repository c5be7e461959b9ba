"""The table of lights: a new light is one new file and one line in LIGHTS."""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType
from typing import Annotated, NamedTuple, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from engine.light import area, disk, distant, point, projector, sphere, spot, sun, uberlight
from engine.light.base import IMAGE, ROW, Light
from engine.light.pyramid import STEP, Pyramid
from engine.numerics.dispatch import by_index

LIGHTS: dict[type[Light], ModuleType] = {
    point.PointLight: point,
    spot.SpotLight: spot,
    area.AreaLight: area,
    disk.DiskLight: disk,
    sphere.SphereLight: sphere,
    distant.DistantLight: distant,
    sun.SunLight: sun,
    projector.ProjectorLight: projector,
    uberlight.UberLight: uberlight,
}

AnyLight: TypeAlias = Annotated[Union[tuple(LIGHTS)], Field(discriminator="type")]  # type: ignore[valid-type]  # noqa: UP007

INDEX = {description: index for index, description in enumerate(LIGHTS)}

illuminate = by_index([m.illuminate for m in LIGHTS.values()], 6)
pdf = by_index([m.pdf for m in LIGHTS.values()], 3)
emitted = by_index([m.emitted for m in LIGHTS.values()], 3)
irradiance = by_index([m.irradiance for m in LIGHTS.values()], 4)
glance = by_index([m.glance for m in LIGHTS.values()], 6)


class LightTable(NamedTuple):
    """The lights that are on, as kernels want them.

    kind    (l,) int32           index into LIGHTS
    row     (l, ROW) float32     parameters
    extent  (l,) bool            whether a ray can hit it
    texels  (k, 3) float32       the images of those that have one, each image once
    """

    kind: NDArray[np.int32]
    row: NDArray[np.float32]
    extent: NDArray[np.bool_]
    texels: NDArray[np.float32]


def light_table(lights: Iterable[Light]) -> LightTable:
    """Pack the enabled lights."""
    on = [light for light in lights if light.enabled]
    row = np.array([light.row() for light in on], np.float32).reshape(len(on), ROW)
    images: dict[Pyramid, int] = {}
    count = 0
    for light, parameters in zip(on, row, strict=True):
        image = light.pyramid()
        if image is None:
            continue
        if image not in images:
            images[image] = count
            count += len(image.texels)
        parameters[IMAGE : IMAGE + 3] = images[image] // STEP, image.width, image.height
    every = [image.texels for image in images]
    return LightTable(
        np.array([INDEX[type(light)] for light in on], np.int32),
        row,
        np.array([light.has_extent for light in on], np.bool_),
        every[0] if len(every) == 1 else np.concatenate([np.zeros((0, 3), np.float32), *every]),
    )
