"""Every model has a counterpart in Mitsuba; see `reference/test_against_mitsuba` for exact ones."""

from __future__ import annotations

from pathlib import Path

import mitsuba
import pytest

from engine.brdf import Material
from engine.brdf.table import MODELS
from engine.measure.mitsuba_scene import mitsuba_scene
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
