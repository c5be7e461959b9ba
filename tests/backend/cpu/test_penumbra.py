"""A soft shadow from a few rays in each pixel is that from many."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.backend.cpu.penumbra import DOWN, RIGHT, alike_neighbours, smooth_penumbrae
from engine.light.area import AreaLight
from engine.methods.fixed_view import direct
from engine.methods.fixed_view.direct import (
    light_on_buffer,
    light_on_pixels,
    light_on_points,
    light_samples,
    probes,
)
from engine.methods.fixed_view.frame_buffer import pixel_phase
from engine.methods.fixed_view.view import View
from engine.reference import render_direct
from engine.scene.build import build
from engine.scene.edits import Edits, apply
from engine.scene.open import describe

LAMP = AreaLight(
    id="lamp", position=(0.4, 2, 0), target=(0, 0, 0), width=0.8, height=0.5, intensity=(9, 6, 3)
)


def thing(name: str, size: Any, place: Any) -> dict[str, Any]:
    return {
        "name": name,
        "mesh": {"shape": "box", "size": size},
        "material": "grey",
        "transform": {"translate": place},
    }


def view(tmp_path: Any, **material: Any) -> View:
    """A slab in the air over a floor, seen from above at a slant."""
    document = {
        "camera": {"position": (0, 3, 2.5), "target": (0, 0, 0), "width": 96, "height": 96},
        "materials": {"grey": {"type": "diffuse", "diffuse": (0.6, 0.5, 0.4), **material}},
        "objects": [
            thing("floor", (4, 0.02, 4), (0, -0.01, 0)),
            thing("slab", (0.7, 0.02, 0.7), (0, 0.6, 0)),
        ],
    }
    return View(build(describe(document), tmp_path))


def test_as_close_to_the_truth_as_all_samples_in_every_pixel(tmp_path: Any) -> None:
    """For a quarter of the rays at most: smoothing takes away the banding and adds little blur."""
    seen = view(tmp_path)
    off = [{"id": light.id, "enabled": False} for light in seen.scene.lights]
    scene = apply(seen.scene, Edits(lights=[*off, LAMP.model_dump()]))
    truth = render_direct(scene, samples=128).image.reshape(-1, 3)
    quick = light_on_buffer(seen.scene.rays, seen.buffer, LAMP)
    full = quick.copy()
    inside = np.ones(len(full), np.bool_)
    inside[seen.buffer.edge] = False
    every = light_samples(LAMP, 64)
    full[inside] = direct._light(seen.scene.rays, seen.buffer.centre, LAMP, every)[0][inside]

    # There is a penumbra to speak of.
    lit = truth.max(axis=1)
    assert ((lit > 0.1 * lit.max()) & (lit < 0.7 * lit.max())).mean() > 0.1
    error = np.linalg.norm(quick - truth) / np.linalg.norm(truth)
    assert error < 0.035
    assert error < 1.1 * np.linalg.norm(full - truth) / np.linalg.norm(truth)
    assert quick.sum() == pytest.approx(full.sum(), rel=2e-3)


def test_the_faint_end_of_a_penumbra_is_lit(tmp_path: Any) -> None:
    """Where less than a tenth of the lamp is seen, and that is at its rim."""
    seen = view(tmp_path)
    # Aslant, so that the slab hides it corner by corner, and its shadow leaves the slab.
    lamp = LAMP.model_copy(update={"position": (1.2, 1.5, 0), "up": (0.5, 0, 1), "width": 0.4})
    rays, points = seen.scene.rays, seen.buffer.centre
    every = light_samples(lamp, 64)
    plain = direct._light(rays, points, lamp, every, shadows=False)[0].max(axis=1)
    truth = direct._light(rays, points, lamp, every)[0].max(axis=1)
    inside = np.ones(len(points), np.bool_)
    inside[seen.buffer.edge] = False
    faint = inside & (truth > 0) & (truth < 0.1 * plain)
    assert faint.sum() > 100
    # Smoothing takes light there from where more of the lamp is seen: in the truth too, then.
    row, alike = points.row, seen.buffer.alike
    expected = smooth_penumbrae(direct._light(rays, points, lamp, every)[0], row, alike, 96)
    found = light_on_buffer(rays, seen.buffer, lamp)
    assert found[faint].sum() == pytest.approx(expected[faint].sum(), rel=0.15)
    assert (found[faint].max(axis=1) > 0).mean() > 0.95
    # Half as many pixels, four points of the lamp in each.
    grid = np.arange(96 * 96).reshape(96, 96)[::2, ::2].ravel()
    coarse = light_on_pixels(rays, seen.points(2), seen.coarse_alike, 48, lamp)
    truth = direct._light(rays, seen.points(2), lamp, every)[0]
    expected = smooth_penumbrae(truth, row[grid], seen.coarse_alike, 48)
    few = faint[grid]
    assert coarse[few].sum() == pytest.approx(expected[few].sum(), rel=0.3)


def test_every_block_looks_at_the_whole_lamp() -> None:
    points = probes()[:, 0]
    assert {(x, y) for x in (0, 1) for y in (0, 1)} <= set(map(tuple, points))
    assert len(set(map(tuple, np.round(points * 3)))) == 16
    # Of four neighbours one looks at a corner, two at sides, one within.
    phase = pixel_phase(8, 8).reshape(8, 8)
    for y, x in np.ndindex(7, 7):
        ends = (points[phase[y : y + 2, x : x + 2].ravel()] % 1 == 0).sum(axis=1)
        assert sorted(ends) == [0, 1, 1, 2]
    for y, x in np.ndindex(4, 4):
        assert len(set(phase[y : y + 5, x : x + 5].ravel())) == 16


def test_one_sample_in_each_point_of_a_cloud_adds_up(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = view(tmp_path)
    points = seen.buffer.centre
    points.phase[:] = np.arange(len(points)) % 16
    one = light_on_points(seen.scene.rays, points, LAMP)
    every = [light_samples(LAMP, 1)[k : k + 1] for k in range(16)]
    total = np.zeros_like(one)
    for sample in every:
        monkeypatch.setattr(direct, "light_samples", lambda *_, s=sample: s)
        total += light_on_points(seen.scene.rays, points, LAMP) / 16
    assert one.sum() == pytest.approx(total.sum(), rel=2e-3)
    # Runs of 16 points that lie together stand for the light as a whole.
    runs, truth = (a[: len(a) // 16 * 16].reshape(-1, 16, 3).mean(axis=1) for a in (one, total))
    assert np.linalg.norm(runs - truth) < 0.05 * np.linalg.norm(truth)


def test_samples_cover_the_light_evenly() -> None:
    def cells(samples: np.ndarray, side: int) -> int:
        return len({tuple(cell) for cell in np.floor(samples.reshape(-1, 2) * side).astype(int)})

    for per_point in (1, 2, 4, 16, 64):
        samples = light_samples(LAMP, per_point)
        assert samples.shape == (64 // per_point, per_point, 2)
        assert cells(samples, 8) == 64
    # A pixel has one of every quarter, of every sixteenth in a penumbra; so has a block of four.
    assert all(cells(group, 2) == 4 for group in light_samples(LAMP, 4))
    assert all(cells(group, 4) == 16 for group in light_samples(LAMP, 16))
    assert cells(light_samples(LAMP, 4)[:4], 4) == 16
    for per_point in (2, 4, 16):
        np.testing.assert_allclose(light_samples(LAMP, per_point)[:4].mean(axis=(0, 1)), 0.5)
    # What a block of four has is as wide as the light each way, and leans to neither diagonal.
    for few in (light_samples(LAMP, 2)[:4], light_samples(LAMP, 4)[:4]):
        x, y = np.floor(few.reshape(-1, 2) * 8).T
        assert set(x) == set(y) == set(range(8))
        assert np.mean((x - 3.5) * (y - 3.5)) == pytest.approx(0)


def flat(width: int, height: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    y, x = np.divmod(np.arange(width * height), width)
    position = np.column_stack([x, y, np.zeros(len(x))]).astype(np.float32)
    normal = np.tile(np.float32([0, 0, 1]), (len(x), 1))
    return position, normal, np.zeros(len(x), np.int32)


def test_a_pattern_of_blocks_becomes_flat_up_to_every_border() -> None:
    """What differs between the pixels of a block of 2 x 2 alone is gone, on both objects."""
    width, height = 9, 7
    position, normal, obj = flat(width, height)
    obj[position[:, 0] >= 4] = 1
    matt = np.ones(len(obj), np.bool_)
    alike = alike_neighbours(position, normal, obj, matt, width)
    x, y = position[:, 0].astype(int), position[:, 1].astype(int)
    row = np.zeros((len(obj), 16), np.float32)
    row[:, :3] = np.random.default_rng(1).uniform(0.2, 0.8, (len(obj), 3))  # a texture
    light = np.where(obj == 1, 5.0, 1.0) * (1 + 0.3 * (x % 2) - 0.2 * (y % 2))
    smooth = smooth_penumbrae((row[:, :3] * light[:, None]).astype(np.float32), row, alike, width)
    expected = np.where(obj == 1, 5.0, 1.0) * (1 + 0.15 - 0.1)
    np.testing.assert_allclose(smooth / row[:, :3], np.tile(expected[:, None], 3), rtol=1e-5)


def test_neighbours_across_edges_are_not_alike() -> None:
    width, height = 6, 5
    position, normal, obj = flat(width, height)
    matt = np.ones(30, np.bool_)
    plain = alike_neighbours(position, normal, obj, matt, width).reshape(height, width)
    assert (plain[:-1, :-1] == RIGHT | DOWN).all()
    assert (plain[:-1, -1] == DOWN).all()
    assert (plain[-1, :-1] == RIGHT).all()
    assert plain[-1, -1] == 0

    nothing = np.where(np.arange(30) == 8, -1, obj).astype(np.int32)
    step = position.copy()
    step[position[:, 0] >= 3, 2] = 1
    bent = normal.copy()
    bent[position[:, 0] >= 3] = [0.6, 0, 0.8]
    gloss = np.where(position[:, 0] >= 3, False, True)
    for arrays in (
        (step, normal, obj, matt),
        (position, bent, obj, matt),
        (position, normal, obj, gloss),
    ):
        found = alike_neighbours(*arrays, width).reshape(height, width)
        assert not (found[:, 2] & RIGHT).any()
        assert (found[:-1, 2] & DOWN).all()
    found = alike_neighbours(position, normal, nothing, matt, width).reshape(height, width)
    assert found[1, 2] == 0
    assert not found[1, 1] & RIGHT
    assert not found[0, 2] & DOWN
