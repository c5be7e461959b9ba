"""Rays through openings: what a window gives to a point, by closed form, on any kind of surface."""

from __future__ import annotations

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import job, square, unpacked
from methods.fixed_view.test_links import parallel
from methods.scenes import camera, rectangle, scene

from engine.brdf import evaluate
from engine.brdf.ggx import Ggx
from engine.brdf.table import INDEX
from engine.light.environment_samples import DEPTH
from engine.methods.fixed_view.gather import ENVIRONMENT, Lobes, cosine_lobes, gather_chunk
from engine.methods.fixed_view.openings import LEVEL, open_cells
from engine.methods.fixed_view.rows import PackedRows
from engine.numerics import haar
from engine.numerics.octahedron import centres

HALF, HEIGHT = 0.3, 1.0  # of a square window in a wide ceiling


def ceiling():
    """A window of side 2 HALF at HEIGHT above the origin, in a ceiling of 400 m."""
    b, h = 200.0, HALF
    panes = [
        ([2 * b, b - h], [0, HEIGHT, (b + h) / 2]),
        ([2 * b, b - h], [0, HEIGHT, -(b + h) / 2]),
        ([b - h, 2 * h], [(b + h) / 2, HEIGHT, 0]),
        ([b - h, 2 * h], [-(b + h) / 2, HEIGHT, 0]),
    ]
    return scene(
        camera=camera(8),
        objects=[
            rectangle(f"pane {k}", size, at, [90, 0, 0]) for k, (size, at) in enumerate(panes)
        ],
    )


def escaping(lobes: Lobes, opening_rays: int, count: int = 233) -> np.ndarray:
    """(64, n_e): what each of 64 points at the origin gets from each environment sample."""
    where = ceiling()
    samples = square(16, (0, 1, 0), (1, 0, 0), (0, 0, 1), (0, -1, 0))
    points, up = np.zeros((64, 3), np.float32), np.tile(np.float32([0, 1, 0]), (64, 1))
    fields = {"positions": where.geometry.positions, "triangles": where.geometry.triangles}
    made = gather_chunk(
        job(
            samples, points, up, where.rays, count=count, lobes=lobes, opening_rays=opening_rays,
            **fields,
        ),
        0,
    )  # fmt: skip
    rows = PackedRows(*(made[ENVIRONMENT + f] for f in PackedRows._fields))
    return haar.inverse(np.ascontiguousarray(unpacked(rows, 4**DEPTH).T, np.float32)).T


UP = np.tile(np.float32([0, 1, 0]), (64, 1))


def test_a_window_gives_its_form_factor_with_little_noise():
    exact = np.pi * 4 * parallel(HALF, HALF, HEIGHT)
    with_rays, without = (escaping(cosine_lobes(UP), n).sum(axis=1) for n in (1024, 0))
    noise = with_rays.std() / exact
    assert with_rays.mean() == pytest.approx(exact, rel=0.01)
    assert noise < 0.04
    assert without.std() / exact > 2 * noise
    assert without.mean() == pytest.approx(exact, rel=0.02)


def test_light_comes_from_where_the_window_is():
    row = escaping(cosine_lobes(UP), 1024).mean(axis=0)
    d = centres(DEPTH)
    on_ceiling = d / np.maximum(d[:, 1:2], 1e-3) * HEIGHT
    inside = (np.abs(on_ceiling[:, [0, 2]]).max(axis=1) < HALF) & (d[:, 1] > 0)
    outside = (np.abs(on_ceiling[:, [0, 2]]).max(axis=1) > HALF + 0.1) | (d[:, 1] <= 0)
    np.testing.assert_allclose(
        row[inside].sum(), np.pi * 4 * parallel(HALF, HALF, HEIGHT), rtol=0.08
    )
    assert np.abs(row[outside]).sum() < 0.05 * row.sum()


@pytest.mark.parametrize("roughness", [0.2, 0.6])
def test_gloss_reflects_a_window_as_its_lobe_says(roughness: float):
    material = Ggx(diffuse=(0, 0, 0), specular=(0.7, 0.7, 0.7), roughness=roughness)
    tilt = np.radians(20.0)
    wo = np.tile(np.float32([np.sin(tilt), np.cos(tilt), 0]), (64, 1))
    lobes = Lobes(wo, np.full(64, INDEX[Ggx], np.int32), np.tile(material.row(), (64, 1)))
    found = escaping(lobes, 1024).sum(axis=1)
    # By brute force in the frame whose z is up: the share of the lobe that is in the window.
    rng = np.random.default_rng(2)
    wi = rng.normal(size=(2_000_000, 3))
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    wi[:, 2] = np.abs(wi[:, 2])
    local = np.array([np.sin(tilt), 0, np.cos(tilt)])
    f = evaluate(INDEX[Ggx], material.row(), wi, local)[:, 0] * wi[:, 2]
    seen = np.abs(wi[:, :2]).max(axis=1) < HALF / HEIGHT * wi[:, 2]
    exact = np.pi * (f * seen).sum() / f.sum()
    assert found.mean() == pytest.approx(exact, rel=0.03)
    assert found.std() < 0.1 * exact


def test_open_cells_are_found_and_what_is_beside_them():
    d = np.float32([[0, 1, 0], [0, -1, 0]])
    one = open_cells(np.array([True, False]), d)
    away = np.degrees(np.arccos(centres(LEVEL)[one][:, 1]))
    assert 9 <= one.sum() <= 16
    assert away.max() < 20
    below = open_cells(np.array([False, True]), d)
    # The corners of the square meet there.
    assert below.sum() >= 4
    assert np.degrees(np.arccos(-centres(LEVEL)[below][:, 1])).max() < 20
    assert not open_cells(np.array([False, False]), d).any()
