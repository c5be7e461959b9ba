"""How cost grows: scenes that grow in one thing alone, and a chart of all of it."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from methods.scenes import cornell
from PIL import Image

from engine.brdf.published import BRUSHED
from engine.errors import InputError
from engine.measure import growth_chart
from engine.measure.growth import SCENES, growth, with_balls, with_vertices
from engine.measure.growth_chart import growth_power
from engine.measure.machine import this_machine
from engine.measure.probes import many_lights
from engine.measure.stage import ball, stage
from engine.reference import render
from engine.store import Store


@pytest.mark.parametrize("triangles", SCENES["direct_to_indirect"]["triangles"])
def test_balls_bring_a_scene_to_its_triangles(triangles: float) -> None:
    """To within a tenth, by balls of which all are the same."""
    box = cornell(16)
    crowded = with_balls(box, int(triangles))
    count = len(crowded.geometry.triangles)
    assert count == pytest.approx(triangles, rel=0.1)
    balls = len(crowded.object_names) - len(box.object_names)
    assert 100 <= balls <= 125
    assert (count - len(box.geometry.triangles)) % balls == 0
    assert crowded.geometry.object.max() == len(crowded.object_names) - 1
    assert crowded.geometry.triangles.dtype == crowded.geometry.object.dtype == np.int32
    # What was there is there still, and rays meet what was added.
    assert (
        crowded.geometry.positions[: len(box.geometry.positions)] == box.geometry.positions
    ).all()
    assert crowded.transport_digest != box.transport_digest


def test_finer_balls_look_the_same() -> None:
    """So that what grows is the count of triangles, and not what there is to see."""
    coarse, fine = (
        render(with_balls(cornell(24), triangles), samples=64).image
        for triangles in (40_000, 640_000)
    )
    plain = render(cornell(24), samples=64).image
    below = slice(8, None)  # without the lamp
    assert np.linalg.norm((coarse - fine)[below]) < 0.12 * np.linalg.norm(fine[below])
    assert np.linalg.norm((coarse - plain)[below]) > 0.25 * np.linalg.norm(plain[below])


def test_many_lights_are_in_all_as_bright_as_one() -> None:
    box = cornell(16)
    (one,), many = many_lights(box, 1, 3), many_lights(box, 50, 3)
    assert len({light.id for light in many}) == 50
    assert sum(light.intensity[0] for light in many) == pytest.approx(one.intensity[0])
    # Drawn one after another, the first is the same however many there are.
    assert many[0].position == one.position


@pytest.mark.sweep
def test_growth_on_a_small_box(tmp_path: Path) -> None:
    axes = {
        "view_samples": (0.25, 1.0),
        "gather_samples": (256, 1024),
        "coefficients": (10, 80),
        "triangles": (10_000, 40_000),
        "lights": (1, 8),
    }
    box = cornell(24)
    grown = growth(
        box,
        fixed={"gather_samples": 1024, "view_rays": 55, "bounce_rays": 55},
        axes=axes,
        edits=1,
        reference_error=0.3,
        store=Store(tmp_path / "store"),
    )
    assert [g.point.knob for g in grown] == [name for name in axes for _ in range(2)]
    assert [g.size for g in grown if g.point.knob == "view_samples"] == [144, 576]
    assert [g.size for g in grown if g.point.knob == "gather_samples"] == [256, 1024]
    assert [g.size for g in grown if g.point.knob == "lights"] == [1, 8]
    for g in grown:
        assert g.point.frame.median > 0
        assert g.point.precompute > 0
        assert 0 <= g.point.error["relative_l2"] < 1
        assert 0 < g.floor < 1
    size = {name: [g.point.bytes for g in grown if g.point.knob == name] for name in axes}
    for name in ("view_samples", "gather_samples", "coefficients"):
        assert size[name][0] < size[name][1]
    # Lights are no part of what is precomputed.
    assert size["lights"][0] == size["lights"][1]

    paths = growth_chart.write(box, grown, this_machine(), tmp_path / "out")
    assert [path.name for path in paths] == ["growth.svg", "growth.png", "growth.json"]
    texts = "".join(ElementTree.parse(paths[0]).getroot().itertext())
    for words in (*axes, "frame (ms)", "precompute (s)", "transport (MB)", "error (%)"):
        assert words.replace("_", " ") in texts
    with Image.open(paths[1]) as image:
        pixels = np.asarray(image.convert("RGB"))
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00), (0xE6, 0x9F, 0x00)):
        assert (pixels == colour).all(axis=2).sum() > 200
    document = json.loads(paths[2].read_text())
    assert [p["size"] for p in document["points"]] == [g.size for g in grown]


@pytest.mark.sweep
def test_growth_of_glossy_prt(tmp_path: Path) -> None:
    """Without references: the light update and the picture of a new view, as in its figure 12."""
    scene = stage(ball(8), BRUSHED, (24, 24), cuts=8)
    fixed = {"light_texels": 16, "visibility_texels": 16, "gather_texels": 8, "brdf_texels": 16}
    axes = {"vertices": (200, 1500), "terms": (1, 8), "coefficients": (16, 200)}
    grown = growth(scene, method="glossy_prt", fixed=fixed, axes=axes, edits=1)
    assert [g.point.knob for g in grown] == [name for name in axes for _ in range(2)]
    sizes = {name: [g.size for g in grown if g.point.knob == name] for name in axes}
    assert sizes["vertices"] == pytest.approx([200 + 81, 1500 + 81], rel=0.05)
    assert sizes["terms"] == [1, 8]
    for g in grown:
        assert g.floor == 0
        assert g.point.error == {}
        parts = g.point.parts
        assert 0 < parts["transport"] < g.point.frame.p95
        assert 0 < parts["new view"] < 1
    for name in axes:
        small, large = (g.point.bytes for g in grown if g.point.knob == name)
        assert large > 1.3 * small
    paths = growth_chart.write(scene, grown, this_machine(), tmp_path)
    texts = "".join(ElementTree.parse(paths[0]).getroot().itertext())
    for words in ("glossy_prt on ball on a floor", "light update", "picture of a new view", *axes):
        assert words in texts
    assert "error" not in texts


def test_levels_leave_the_rest_of_a_scene_alone() -> None:
    scene = stage(ball(20), BRUSHED, (24, 24), cuts=8)
    coarse = with_vertices(scene, 120)
    own, floor = (coarse.geometry.object == index for index in (0, 1))
    assert np.unique(coarse.geometry.triangles[own]).size == pytest.approx(120, rel=0.1)
    assert (coarse.geometry.material[own] == 0).all()
    assert (coarse.geometry.material[floor] == 1).all()
    was = scene.geometry.positions[scene.geometry.triangles[scene.geometry.object == 1]]
    assert np.array_equal(coarse.geometry.positions[coarse.geometry.triangles[floor]], was)
    assert coarse.transport_digest != scene.transport_digest
    assert coarse.object_names == scene.object_names


def test_powers() -> None:
    assert growth_power([1, 10, 100], [3, 30, 300]) == pytest.approx(1)
    assert growth_power([1, 4], [8, 4]) == pytest.approx(-0.5)
    assert growth_power([5], [1]) is None


def test_what_does_not_grow_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"bounces is nothing that grows.*triangles"):
        growth(cornell(8), axes={"bounces": (1, 2)}, store=Store(tmp_path))
