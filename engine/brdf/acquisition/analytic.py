"""A model of the engine as if it had been measured everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from engine.brdf.acquisition.report import Energy, Report
from engine.brdf.acquisition.samples import directions
from engine.brdf.acquisition.survey import AZIMUTHS_DEGREES, unlike_reverses
from engine.brdf.albedo import ANGLES_DEGREES, albedo
from engine.brdf.arrays import evaluate
from engine.brdf.base import GRAIN, Material
from engine.brdf.table import INDEX


@dataclass(frozen=True, eq=False)
class Analytic:
    """A `Measurement` that calls a model.

    name   of the material
    model  its index in MODELS
    row    (ROW,) float32, its parameters
    """

    name: str
    model: int
    row: NDArray[np.float32]

    @property
    def isotropic(self) -> bool:
        """Whether the model has no grain."""
        return not self.row[GRAIN:].any()

    @cached_property
    def report(self) -> Report:
        """Energy and reciprocity; nothing was measured."""
        reflected = self._energy()
        return Report(
            self.name,
            self.isotropic,
            0,
            reflected,
            reflected,
            unlike_after=unlike_reverses(self.evaluate),
        )

    def evaluate(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        """BRDF (q, 3) of pairs (q, 3), (q, 3); see `Measurement`."""
        return evaluate(self.model, self.row, wi, wo)

    def _energy(self) -> Energy:
        """The largest albedo, by the model's own sampler."""
        theta, phi = np.meshgrid(np.radians(ANGLES_DEGREES), np.radians(AZIMUTHS_DEGREES))
        each = albedo(self.model, self.row, directions(theta.ravel(), phi.ravel()))
        place, channel = np.unravel_index(np.argmax(each), each.shape)
        angle = float(np.degrees(theta.ravel()[place]))
        return Energy(float(each[place, channel]), round(angle, 6), int(channel))


def of_material(material: Material, name: str = "") -> Analytic:
    """The `Measurement` of a model with its parameters, named as its model where no name is given.

    It is isotropic unless its row has a grain. Raises InputError where a field does not fit.
    """
    kind = type(material)
    return Analytic(name or str(material.model_dump()["type"]), INDEX[kind], material.row())
