"""The contract of a measured material: a value for any pair of directions, and a report."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.brdf.acquisition.report import Report


class Measurement(Protocol):
    """A BRDF known for every pair of directions above the surface."""

    @property
    def name(self) -> str:
        """The material's name."""

    @property
    def isotropic(self) -> bool:
        """Whether the value depends on θ_i, θ_o and the difference of azimuths alone."""

    @property
    def report(self) -> Report:
        """What the data hold and what had to be done to them; made when first asked for."""

    def evaluate(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        """BRDF (q, 3) in sr⁻¹ without the cosine, linear sRGB, finite and ≥ 0.

        wi, wo (q, 3), unit, local (z the normal), leaving the surface; 0 where one lies below it.
        """
