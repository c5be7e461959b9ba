"""Every model has a counterpart in Mitsuba; see `reference/test_against_mitsuba` for exact ones."""

from __future__ import annotations

from pathlib import Path

import mitsuba
import pytest

from engine.brdf import Material, hemispherical_albedo
from engine.brdf.measured import Measured
from engine.brdf.table import INDEX, MODELS
from engine.measure.mitsuba_bsdf import mitsuba_bsdf
from engine.measure.mitsuba_scene import differences, mitsuba_scene
from engine.scene.build import build
from engine.scene.open import describe


@pytest.mark.parametrize("specular", [0.04, 0.8], ids=["clear coat", "metal"])
@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.__name__)
def test_every_model_has_a_counterpart(
    model: type[Material], specular: float, tmp_path: Path
) -> None:
    fields = {"specular": [specular] * 3} if "specular" in model.model_fields else {}
    scene = build(
        describe(
            {
                "environment": {"map": [1, 1, 1]},
                "lights": [],
                "materials": {"m": {"type": model.model_fields["type"].default, **fields}},
                "objects": [{"name": "ball", "mesh": {"shape": "sphere"}, "material": "m"}],
            }
        ),
        Path(),
    )
    mitsuba.set_variant("scalar_rgb")
    assert len(mitsuba_scene(scene, tmp_path).shapes()) == 1


def test_what_was_measured_is_matt_there() -> None:
    """Of the albedo that it has under even light; said so."""
    scene = build(
        describe(
            {
                "lights": [],
                "materials": {"cloth": {"type": "measured", "specular": [0.5, 1, 1]}},
                "objects": [{"name": "a", "mesh": {"shape": "box"}, "material": "cloth"}],
            }
        ),
        Path(),
    )
    matt = mitsuba_bsdf(scene, 0, scene.materials[0])["bsdf"]
    reflected = hemispherical_albedo(INDEX[Measured], scene.materials[0].row())[0]
    assert matt["type"] == "diffuse"
    assert matt["reflectance"]["value"] == pytest.approx(reflected)
    assert 0.1 < reflected[0] < 0.5
    (said,) = differences(scene)
    for word in ("'cloth'", "measured", "matt", "same albedo"):
        assert word in said
