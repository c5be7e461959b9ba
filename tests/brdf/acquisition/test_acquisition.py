"""The public calls: which file is read how, and models as measurements."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import goniometer_file, pairs

from engine.brdf import evaluate
from engine.brdf.acquisition import Measurement, of_material, read
from engine.brdf.acquisition.csv_table import COLUMNS
from engine.brdf.base import GRAIN
from engine.brdf.ggx import Ggx
from engine.brdf.table import INDEX, MODELS
from engine.errors import InputError

ROWS = [(0.1 * k, 0.0, 0.5, 0.3 * k, 0.1, 0.1, 0.1) for k in range(10)]


def check(measurement: Measurement) -> None:
    """What every measurement is."""
    wi, wo = pairs(500)
    value = measurement.evaluate(wi, wo)
    assert value.shape == (500, 3)
    assert value.dtype == np.float64
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    assert measurement.report.name == measurement.name
    assert measurement.report.isotropic == measurement.isotropic
    assert measurement.report is measurement.report


def test_files_by_their_extension_or_their_start(tmp_path: Path) -> None:
    paint = goniometer_file(tmp_path / "paint.brdf", ROWS)
    table = tmp_path / "table.CSV"
    table.write_text(",".join(COLUMNS) + "\n30,0,45,180,0.1,0.1,0.1\n")
    for path in (paint, table):
        other = Path(shutil.copy(path, path.with_suffix(".dat")))
        for found in (read(path), read(other)):
            assert found.name == path.stem
            check(found)
            np.testing.assert_allclose(found.evaluate(*pairs(9)), 0.1, rtol=1e-9)


def test_what_is_no_measurement(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.brdf: there is no such file"):
        read(tmp_path / "none.brdf")
    with pytest.raises(InputError, match="there is no such file"):
        read(tmp_path)
    for content in (b"", b"hello\n", bytes(range(256))):
        (tmp_path / "other.xyz").write_bytes(content)
        with pytest.raises(InputError, match=r"other\.xyz: .*known are MERL's \.binary"):
            read(tmp_path / "other.xyz")


@pytest.mark.parametrize("kind", list(MODELS), ids=lambda kind: kind.__name__)
def test_every_model_is_a_measurement(kind: type) -> None:
    material = kind()
    measurement = of_material(material)
    check(measurement)
    assert measurement.name == material.model_dump()["type"]
    assert measurement.isotropic == (not material.row()[GRAIN:].any())
    wi, wo = pairs(100)
    expected = evaluate(INDEX[kind], material.row(), wi, wo)
    np.testing.assert_array_equal(measurement.evaluate(wi, wo), expected)


def test_a_model_may_have_a_name() -> None:
    assert of_material(Ggx(), "pot").report.name == "pot"


def test_tables_of_colours_are_not_loaded_before_they_are_needed() -> None:
    """They take a second, and a service starts without them."""
    code = "import sys, engine.brdf.acquisition; print('colour' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert run.stdout == "False\n"
