"""What no K terms show, however they are chosen: radiance then lies in K functions of the view."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from engine.brdf import Material
from engine.brdf.factorisation import brdf_matrix, eigenpairs
from engine.brdf.published import BRUSHED, CLAY
from engine.brdf.table import INDEX
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.light.maps import studio
from engine.numerics.hemisphere_maps import texels

TURNS, GREEN = 48, 1


def left_out(material: Material, terms: int) -> tuple[float, float]:
    """(by the eigenvectors, by the best functions of the view) of an open point in the studio.

    Relative L2 over views that are uniform on the disk and TURNS turns of the point. The best
    functions are the principal components of those very answers.
    """
    grid = texels(32)
    inner = len(grid.weight)
    matrix = brdf_matrix(INDEX[type(material)], material.row(), grid)[GREEN, :inner]
    sky = Environment(EnvironmentDescription(), studio())
    turns = Rotation.random(TURNS, random_state=1).as_matrix()
    light = np.stack(
        [
            seen_radiance(sky, places_on_map(grid.direction[:inner] @ turn.T))[:, GREEN]
            for turn in turns
        ],
        axis=1,
    )
    answers = matrix.astype(np.float64) @ light
    _, vectors = eigenpairs(matrix, grid, terms)

    def off(basis: NDArray[np.float64]) -> float:
        rest = answers - basis @ (basis.T @ answers)
        return float(np.linalg.norm(rest) / np.linalg.norm(answers))

    best = np.linalg.svd(answers, full_matrices=False)[0][:, :terms]
    return off(np.linalg.qr(vectors)[0]), off(best)


@pytest.mark.parametrize(
    ("material", "terms", "least", "most"),
    [(BRUSHED, 4, 0.2, 1.0), (CLAY, 4, 0.0, 0.2), (BRUSHED, 16, 0.0, 0.3)],
    ids=["brushed", "clay", "brushed 16"],
)
def test_the_best_terms(material: Material, terms: int, least: float, most: float) -> None:
    """Brushed metal in hard light is beyond any four terms; clay is not, nor is it beyond 16."""
    eigen, best = left_out(material, terms)
    assert least < best < most
    assert best <= eigen
