"""`wavelet_brdf`: eq. 1 by hand, what may be edited, what a picture keeps to, what is said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.scenes import camera, rectangle
from methods.wavelet_brdf.measured_scenes import (
    GENERAL,
    LAMP,
    ball,
    inner,
    measured,
    off,
    plane,
    table,
    with_general,
)
from numpy.typing import NDArray
from PIL import Image

from engine.brdf import evaluate
from engine.brdf import measured as code
from engine.brdf.acquisition.csv_table import COLUMNS
from engine.brdf.base import ROW, SPECULAR
from engine.brdf.measured import Measured
from engine.brdf.table import INDEX
from engine.brdf.wavelet.encoding import Target
from engine.errors import EditNotSupported, InputError
from engine.methods.wavelet_brdf import Settings, Wavelets
from engine.scene.build import build
from engine.scene.edits import Edits, apply
from engine.scene.open import describe
from engine.scene.scene import Scene

Make = Callable[..., Wavelets]
FILES = ("plastic", "brushed", "threads", GENERAL)
pytestmark = pytest.mark.usefixtures("small_codes")


def wall(file: str, **more: Any) -> Scene:
    made = plane(measured(file), **more)
    return with_general(made) if file == GENERAL else made


def by_hand(scene: Scene, bent: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
    """Eq. 1 at the pixels of a wall at z = 0, by the code of its only material.

    Its normal may be bent, of a material that knows no grain.
    """
    row = np.zeros(ROW, np.float32)
    row[SPECULAR : SPECULAR + 3] = 1
    source = scene.materials[0].measurement()  # type: ignore[attr-defined]
    code.fill(row, code.encoded(source, 3, Target(error=0.01, floor=0.001)))
    looks = scene.camera
    y, x = np.mgrid[: looks.height, : looks.width]
    away = looks.directions(x.ravel() + 0.5, y.ravel() + 0.5).astype(np.float64)
    eye = np.array(looks.position)
    at = eye - away * (eye[2] / away[:, 2:])
    to_lamp = np.array(LAMP["position"]) - at
    distance = np.linalg.norm(to_lamp, axis=1, keepdims=True)
    n = np.array([0.0, 0.0, 1.0]) if bent is None else bent / np.linalg.norm(bent)
    x_axis = np.array([1.0, 0.0, 0.0]) - n[0] * n
    frame = np.stack([x_axis, np.cross(n, x_axis), n])
    frame /= np.linalg.norm(frame, axis=1, keepdims=True)
    wi, wo = to_lamp / distance @ frame.T, -away @ frame.T
    f = evaluate(INDEX[Measured], row, wi, wo)
    return (f * np.array(LAMP["intensity"]) * wi[:, 2:] / distance**2).reshape((*y.shape, 3))


@pytest.mark.parametrize("file", FILES)
def test_a_point_light_on_a_wall_by_hand(make: Make, file: str) -> None:
    """The frame lies as the surface's tangent does, whatever the code's symmetry."""
    scene = wall(file)
    picture = make(scene).relight(Edits()).image
    expected = by_hand(scene)
    assert expected.std() > 0.1 * expected.mean()
    np.testing.assert_allclose(picture, expected, atol=2e-6 * expected.max())


def test_linear_in_the_light(make: Make) -> None:
    product = make(table(measured(), measured("brushed")))
    fill = {"id": "fill", "type": "spot", "position": [-1, 1, 1], "target": [0, 0, 0]}
    off_lamp = {"id": "lamp", "enabled": False}
    lamp, spot, both, thrice = (
        product.relight(Edits(lights=lights)).image
        for lights in (None, [off_lamp, fill], [fill], [{"id": "lamp", "intensity": [12, 9, 6]}])
    )
    assert min(lamp.max(), spot.max()) > 0.01
    assert off(both, lamp + spot) < 1e-6
    assert off(thrice, 3 * lamp) < 1e-6


def test_edits_are_what_a_scene_would_have_had_from_the_start(make: Make) -> None:
    """Camera, lamps and materials, one after the other and back: bit for bit."""
    start = table(measured(), measured("brushed"))
    product = make(start, detail="distance", alpha=8)
    first = product.relight(Edits()).image
    for edits in (
        Edits(camera={"position": [1.5, 0.8, 2], "width": 33, "height": 21}),
        Edits(lights=[{"id": "lamp", "position": [-1, 2, 0]}]),
        Edits(materials={"floor": {"file": "threads", "specular": [0.2, 0.5, 0.9]}}),
        Edits(materials={"ball": {"type": "phong"}, "floor": {"type": "diffuse"}}),
        Edits(materials={"ball": {"file": "threads"}}, lights=[{"id": "lamp", "enabled": False}]),
    ):
        after = product.relight(edits).image
        anew = make(apply(start, edits), detail="distance", alpha=8).relight(Edits()).image
        assert after.tobytes() == anew.tobytes()
        assert after.tobytes() != first.tobytes()
    assert product.relight(Edits()).image.tobytes() == first.tobytes()


def test_a_colour_multiplies_all_of_it(make: Make) -> None:
    product = make(plane(measured()))
    white = product.relight(Edits()).image
    tinted = product.relight(Edits(materials={"wall": {"specular": [0.5, 1, 0]}})).image
    np.testing.assert_allclose(tinted, white * np.array([0.5, 1, 0]), rtol=1e-6)


def test_a_texture_multiplies_and_a_normal_map_bends(make: Make, tmp_path: Path) -> None:
    """Both of one texel; where the normal leans, eq. 1 is that of a wall that leans so."""
    Image.fromarray(np.full((2, 2, 3), (255, 128, 0), np.uint8)).save(tmp_path / "tint.png")
    Image.fromarray(np.full((2, 2, 3), (178, 102, 230), np.uint8)).save(tmp_path / "bent.png")

    def of(**fields: Any) -> Scene:
        document = {
            "camera": camera(24, position=[0.3, 0.2, 2], fov_y_degrees=40),
            "lights": [LAMP],
            "materials": {"wall": measured(**fields)},
            "objects": [{**rectangle("wall", [6, 6], [0, 0, 0]), "material": "wall"}],
        }
        return build(describe(document), tmp_path)

    plain, tinted = (make(scene).relight(Edits()).image for scene in (
        of(), of(specular={"texture": "tint.png", "factor": [0.5, 1, 1]}),
    ))  # fmt: skip
    factor = np.array([0.5, ((128 / 255 + 0.055) / 1.055) ** 2.4, 0])
    assert off(tinted, plain * factor) < 1e-4
    scene = of(normal={"texture": "bent.png"})
    normal = 2 * np.array([178, 102, 230]) / 255 - 1
    bent = make(scene).relight(Edits()).image
    assert off(bent, by_hand(scene, normal)) < 1e-3
    assert off(bent, plain) > 0.05


def test_shadows(make: Make) -> None:
    """By rays, or the floor as if nothing stood on it."""
    scene = table(measured(), measured("brushed"))
    shaded, bare = (make(scene, shadows=on) for on in (True, False))
    pictures = [product.relight(Edits()).image for product in (shaded, bare)]
    floor = inner(bare) & (bare._seen.view.buffer.centre.object == 0).reshape(40, 40)  # type: ignore[union-attr]
    dark = floor & (pictures[0].max(axis=2) == 0)
    assert 20 < dark.sum() < 0.3 * floor.sum()
    assert pictures[1][floor].min() > 0
    lit = floor & ~dark
    assert np.median(np.abs(pictures[0] - pictures[1])[lit]) == 0


@pytest.mark.parametrize("change", [{"intensity": 2}, {"map": "studio"}])
def test_the_environment_cannot_be_edited(make: Make, change: dict[str, Any]) -> None:
    product = make(ball(measured(), environment={"map": [1, 1, 1]}))
    with pytest.raises(EditNotSupported, match="camera, lights, materials only") as caught:
        product.relight(Edits(environment=change))
    assert caught.value.field == "environment"
    assert "glossy_prt" in caught.value.message


def test_an_environment_is_seen_but_does_not_shine(make: Make) -> None:
    scene = ball(measured(), environment={"map": [0.2, 0.4, 0.6]}, lights=[])
    frame = make(scene).relight(Edits())
    assert [w.code for w in frame.warnings] == ["environment_left_out"]
    np.testing.assert_allclose(frame.image[0, 0], (0.2, 0.4, 0.6))
    assert (frame.image[24, 24] == 0).all()
    assert not make(ball(measured())).relight(Edits()).warnings


def test_what_is_drawn_by_its_formula_is_said(make: Make, tmp_path: Path) -> None:
    """A texture reaches into a model, not into a code; a matt material needs no words."""
    Image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "grey.png")
    texture = {"texture": "grey.png"}
    for kind, said in (("phong", ["drawn_by_formula"]), ("diffuse", [])):
        document = {
            "camera": camera(8, position=[0, 0, 2]),
            "lights": [LAMP],
            "materials": {"wall": {"type": kind, "diffuse": texture}, "ball": measured()},
            "objects": [
                {**rectangle("wall", [6, 6], [0, 0, 0]), "material": "wall"},
                {"name": "ball", "mesh": {"shape": "sphere"}, "material": "ball"},
            ],
        }
        product = make(build(describe(document), tmp_path))
        frame = product.relight(Edits())
        assert [w.code for w in frame.warnings] == said
        assert [fit.bytes > 0 for fit in product.fits] == [False, True]
        assert frame.image.max() > 0


def test_what_a_measurement_lacks_is_said_with_the_materials_name(
    make: Make, tmp_path: Path
) -> None:
    rows = ["30,0,45,180,0.1,0.1,0.1", "0,0,95,0,1,1,1", "0,0,60,90,0.1,0.1,-0.1"]
    (tmp_path / "few.csv").write_text("\n".join([",".join(COLUMNS), *rows]) + "\n")
    document = {
        "camera": camera(8),
        "lights": [LAMP],
        "materials": {"paint": measured("few.csv")},
        "objects": [{**rectangle("wall", [6, 6], [0, 0, 0]), "material": "paint"}],
    }
    product = make(build(describe(document), tmp_path))
    frame = product.relight(Edits())
    assert [w.code for w in frame.warnings] == [
        "measurement_has_gaps", "samples_below_surface", "samples_below_zero",
    ]  # fmt: skip
    assert all(w.message.startswith("'paint': ") for w in frame.warnings)
    assert not product.relight(Edits(materials={"paint": {"file": "plastic"}})).warnings


def test_a_code_that_is_too_small_is_said(make: Make) -> None:
    """A twentieth off its samples on average, or with all that many bytes hold."""
    frames = [make(ball(measured()), **fields).relight(Edits()) for fields in (
        {"bytes": 1600}, {"bytes": 1 << 20},
    )]  # fmt: skip
    assert [[w.code for w in frame.warnings] for frame in frames] == [["code_too_small"], []]
    assert frames[0].warnings[0].size > 0.05


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("cells", 12), ("error", 0), ("floor", 2), ("alpha", -1), ("bytes", 10), ("detail", "far"),
        ("show", "depth"),
    ],
)  # fmt: skip
def test_settings_out_of_range(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=str(value)) as caught:
        Settings(**{field: value})
    assert caught.value.field == field
