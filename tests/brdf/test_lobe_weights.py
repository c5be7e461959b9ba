"""What elements take from cells of directions: all of a lobe's light, wherever it is narrow."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.curve_basis import coefficients
from engine.brdf.ggx import Ggx
from engine.brdf.layers import LAYERS
from engine.brdf.lobe_weights import GRID, lobe_weights, nearest_on_disk
from engine.brdf.phong import Phong
from engine.brdf.table import INDEX, evaluate
from engine.methods.brdf_editing.second_tables import second_lattice

VIEWS = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.3, -0.8, np.sqrt(1 - 0.73)]])
BLACK = (0.0, 0.0, 0.0)
MATERIALS = [
    BlinnPhong(diffuse=BLACK, specular=(0.3, 0.2, 0.1), exponent=20.0),
    BlinnPhong(diffuse=BLACK, specular=(0.3, 0.2, 0.1), exponent=2000.0),
    Phong(diffuse=BLACK, specular=(0.3, 0.2, 0.1), exponent=50.0),
    Ggx(diffuse=BLACK, specular=(0.9, 0.6, 0.3), roughness=0.3),
]


@pytest.mark.parametrize("material", MATERIALS, ids=lambda m: f"{m.type} {m.row()[6]:g}")
def test_even_light_comes_back_as_the_albedo(material: BlinnPhong) -> None:
    model, row = INDEX[type(material)], material.row()
    layers = LAYERS[model]
    assert layers is not None
    rays = second_lattice()
    weights = lobe_weights(model, row, 64, "tents", VIEWS, rays)
    _, lobes = coefficients(layers, row, 64, "tents")
    found = np.einsum("vljk,ljc->vc", weights, lobes)
    # Halves of a fine grid in the half vector, of which none is left to chance.
    n = 400
    theta = (np.arange(n) + 0.5) / n * np.pi / 2
    phi = (np.arange(2 * n) + 0.5) / n * np.pi
    # Finer about the pole, where lobes are.
    theta, width = np.pi / 2 * (theta * 2 / np.pi) ** 3, 3 * (theta * 2 / np.pi) ** 2
    t, f = np.meshgrid(theta, phi, indexing="ij")
    h = np.stack([np.sin(t) * np.cos(f), np.sin(t) * np.sin(f), np.cos(t)], axis=-1).reshape(-1, 3)
    area = (np.sin(t) * width[:, None]).ravel() * (np.pi / 2 / n) * (np.pi / n)
    for v, wo in enumerate(VIEWS):
        cosine = h @ wo
        wi = 2 * cosine[:, None] * h - wo
        good = (cosine > 0) & (wi[:, 2] > 0)
        values = np.array([evaluate(model, row, tuple(w), tuple(wo)) for w in wi[good]])
        due = (values * (wi[good, 2] * 4 * cosine[good] * area[good])[:, None]).sum(axis=0)
        np.testing.assert_allclose(found[v], due, rtol=0.02)


def test_a_narrow_lobe_takes_the_ray_that_it_mirrors() -> None:
    material = MATERIALS[1]
    model = INDEX[type(material)]
    rays = second_lattice()
    weights = lobe_weights(model, material.row(), 8, "tents", VIEWS[1:2], rays)
    narrow = weights[0, 0, 0]
    heaviest = rays[narrow.argmax()]
    assert heaviest @ (-0.6, 0, 0.8) > np.cos(np.radians(8))
    assert (narrow > 0.01 * narrow.max()).sum() < 30


def test_nearest_direction() -> None:
    rays = second_lattice()
    nearest = nearest_on_disk(rays)
    x, y = ((rays[:, :2] + 1) / 2 * GRID).astype(int).T
    # A ray's own place on the disk is its cell's, but where two share a square of the grid.
    assert (nearest[y, x] == np.arange(len(rays))).mean() > 0.9
