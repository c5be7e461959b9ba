"""Values for many pairs of directions: those of the kernels, of codes too."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import hemisphere

from engine.backend.gl.brdfs import Evaluation
from engine.backend.gl.context import Device
from engine.brdf import evaluate
from engine.brdf.base import Material
from engine.brdf.built_in import BUILT_IN
from engine.brdf.measured import LEVEL, NEAREST, Measured
from engine.brdf.table import INDEX
from engine.brdf.ward import Ward

pytestmark = pytest.mark.gl


@pytest.mark.parametrize("material", [Ward(), *(Measured(file=f) for f in BUILT_IN)], ids=str)
@pytest.mark.parametrize(("level", "nearest"), [(0.0, False), (1.4, False), (2.0, True)])
def test_many_pairs(gpu: Device, material: Material, level: float, nearest: bool) -> None:
    rng = np.random.default_rng(4)
    wi, wo = (hemisphere(rng, 3000).astype(np.float32) for _ in range(2))
    model, row = INDEX[type(material)], material.row()
    if isinstance(material, Measured):
        row[LEVEL], row[NEAREST] = level, nearest
    run = Evaluation(gpu, model, row, wi, wo)
    run.run()
    found, expected = run.read(), evaluate(model, row, wi, wo)
    assert expected.min() > 0
    off = np.abs(found - expected) / expected
    # A direction between two cells may be rounded to either.
    assert np.quantile(off, 0.998) < 1e-4
    if not nearest:
        assert off.max() < 2e-3
