"""The accuracy study: what its numbers do when more is kept, and that all of them are told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from engine.errors import InputError
from engine.images import write_image
from engine.measure import accuracy_chart
from engine.measure.accuracy import TRANSPORTS, counted, environments_in, study
from engine.measure.metrics import relative_l2
from engine.measure.stage import MATERIALS, ball, stage
from engine.methods import prepare
from engine.methods.glossy_prt import Settings
from engine.reference import render
from engine.scene.edits import apply
from engine.store import Store

SIZE, CUTS, RINGS = (32, 32), 8, 8
FIXED = {
    "light_texels": 16,
    "visibility_texels": 16,
    "coarse_texels": 16,
    "gather_texels": 8,
    "brdf_texels": 16,
}
KNOBS = {"terms": [1, 4], "coefficients": [8, 400], "light_texels": [8], "gather_texels": [4]}


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(tmp_path_factory.mktemp("store"))


@pytest.fixture(scope="module")
def document(store: Store) -> dict[str, Any]:
    """Two materials in the studio and under a sky, all settings swept."""
    return study(
        ball(RINGS),
        environments_in(None),
        SIZE,
        materials={name: MATERIALS[name] for name in ("diffuse", "red Phong")},
        cuts=CUTS,
        rings=RINGS,
        fixed=FIXED,
        knobs=KNOBS,
        reference_error=0.1,
        store=store,
    )


def errors(
    document: dict[str, Any], material: str, transport: str, knob: str, kind: str = "relative_l2"
) -> dict[Any, float]:
    """Mean error over the environments by the setting's value, the defaults' included."""
    return {
        p["settings"][knob]: float(np.mean([e[kind] for e in p["errors"].values()]))
        for p in document["points"]
        if (p["material"], p["transport"]) == (material, transport) and p["knob"] in ("", knob)
    }


@pytest.mark.sweep
def test_more_is_more_accurate(document: dict[str, Any]) -> None:
    """Terms where there is gloss, wavelets everywhere."""
    by_terms = errors(document, "red Phong", "direct", "terms")
    assert by_terms[4] < 0.8 * by_terms[1]
    for material in ("diffuse", "red Phong"):
        by_wavelets = errors(document, material, "direct", "coefficients")
        assert list(sorted(by_wavelets)) == [8, 128, 400]
        assert by_wavelets[128] < 0.8 * by_wavelets[8]
    # Where nothing is hidden and nothing is glossy there is little to be wrong.
    assert errors(document, "diffuse", "unoccluded", "terms")[4] < 0.04
    assert errors(document, "diffuse", "direct", "terms") == {
        4: errors(document, "diffuse", "direct", "coefficients")[128]
    }, "one term is exact"


@pytest.mark.sweep
def test_more_bounces_come_closer_to_all_light(document: dict[str, Any]) -> None:
    """Against light that bounces as often the error is about the same however often it does."""
    for material in ("diffuse", "red Phong"):
        of_all, same = (
            [
                errors(document, material, transport, "bounces", kind)[bounces]
                for bounces, transport in enumerate(("direct", "1 bounce", "2 bounces"))
            ]
            for kind in ("of_all_bounces", "relative_l2")
        )
        assert of_all[0] > of_all[1] > of_all[2] - 0.003
        assert max(same) < 1.3 * min(same)


@pytest.mark.sweep
def test_a_number_is_what_it_says_it_is(document: dict[str, Any]) -> None:
    """Made again from the parts: a product, a reference of its own noise, and the pixels."""
    scene = stage(ball(RINGS), MATERIALS["diffuse"], SIZE, cuts=CUTS)
    edit = environments_in(None)["studio"]
    (point,) = (
        p
        for p in document["points"]
        if (p["material"], p["transport"], p["knob"]) == ("diffuse", "1 bounce", "")
    )
    assert point["settings"]["bounces"] == 1
    image = prepare(scene, "glossy_prt", Settings(**point["settings"])).relight(edit).image
    found = render(apply(scene, edit), samples=1024, seed=5, max_bounces=2)
    pixels = counted(scene)
    masks = {"relative_l2": pixels.whole, **pixels.parts}
    for kind, mask in masks.items():
        told = point["errors"]["studio"][kind]
        assert told == pytest.approx(
            relative_l2(image, found.image, mask, found.variance), abs=0.02
        )
    assert (pixels.whole == (pixels.parts["object"] | pixels.parts["floor"])).all()


@pytest.mark.sweep
def test_everything_is_told(document: dict[str, Any], tmp_path: Path) -> None:
    assert set(document["vertices"]) == {"ball", "ball on a floor"}
    assert (
        document["vertices"]["ball on a floor"] == (RINGS + 1) * (2 * RINGS + 1) + (CUTS + 1) ** 2
    )
    # Of each material: four transports, and what is swept; terms of the glossy one alone.
    assert len(document["points"]) == 2 * (4 + 2 + 1 + 1) + 1
    # Of each: one to a lone ball, and two for each of the others, the longest the same.
    assert len(document["references"]) == 2 * 2 * (1 + 3 * 2)
    for reference in document["references"]:
        assert 0 < reference["error"] <= 0.1
        assert 0 < reference["floor"] < 0.06

    paths = accuracy_chart.write(document, tmp_path)
    assert [p.name for p in paths] == [f"accuracy.{kind}" for kind in ("svg", "png", "json", "md")]
    assert json.loads(paths[2].read_text()) == json.loads(json.dumps(document))
    drawn = paths[0].read_text()
    for words in ("terms K", "bounces followed", "red Phong", "against all light"):
        assert words in drawn
    with Image.open(paths[1]) as image:
        pixels = np.asarray(image.convert("RGB"))
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):
        assert (pixels == colour).all(axis=2).sum() > 200
    table = paths[3].read_text().splitlines()
    rows = [line for line in table if line.startswith("| red Phong | 1 bounce |")]
    assert len(rows) == 3
    told = [float(cell) for cell in rows[0].strip("| ").split("|")[2:]]
    (point,) = (
        p
        for p in document["points"]
        if (p["material"], p["transport"], p["knob"]) == ("red Phong", "1 bounce", "")
    )
    true = [100 * point["errors"][name]["relative_l2"] for name in ("studio", "sky")]
    assert told == pytest.approx([*true, np.median(true)], abs=0.051)
    assert sum(line.startswith("| diffuse |") for line in table) == 2 * len(TRANSPORTS) + 2


def test_environments_of_a_folder(tmp_path: Path) -> None:
    for name in ("b.exr", "a.exr"):
        write_image(tmp_path / name, np.ones((2, 4, 3), np.float32))
    (tmp_path / "notes.txt").write_text("none")
    found = environments_in(tmp_path)
    assert {name: edit.environment for name, edit in found.items()} == {
        "a": {"map": "a.exr"},
        "b": {"map": "b.exr"},
    }
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no map"):
        environments_in(tmp_path / "empty")


def test_what_is_not_swept_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="brdf_texels is not swept; there are terms"):
        study(ball(4), {}, knobs={"brdf_texels": [8]})
