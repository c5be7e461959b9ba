"""Tables of the MERL format, written from a model and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import pairs, relative, turned
from numpy.typing import NDArray

from engine.brdf import Material
from engine.brdf.acquisition import merl, of_material, read
from engine.brdf.acquisition.merl import SCALES, SHAPE, Merl
from engine.brdf.acquisition.samples import directions
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.errors import InputError

GLOSS = Ggx(roughness=0.4, diffuse=(0.3, 0.1, 0.02))


def table(material: Material) -> NDArray[np.float64]:
    """Planes (3, 90, 90, 180) of a model as a file holds them; below the surface are holes."""
    wi, wo = merl.centres()
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    value = of_material(material).evaluate(wi, wo) / SCALES
    return np.where(above, value.T, -1.0).reshape(3, *SHAPE)


def write(path: Path, planes: NDArray[np.float64], shape: tuple[int, ...] = SHAPE) -> Path:
    path.write_bytes(np.array(shape, "<i4").tobytes() + planes.astype("<f8").tobytes())
    return path


@pytest.fixture(scope="module")
def gloss() -> NDArray[np.float64]:
    return table(GLOSS)


@pytest.fixture(scope="module")
def measured(gloss: NDArray, tmp_path_factory: pytest.TempPathFactory) -> Merl:
    path = write(tmp_path_factory.mktemp("merl") / "gloss.binary", gloss)
    found = read(path)
    assert isinstance(found, Merl)
    return found


def test_the_model_comes_back(measured: Merl) -> None:
    assert measured.name == "gloss"
    assert measured.filled == 0
    wi, wo = pairs(20000)
    error = relative(measured.evaluate(wi, wo), of_material(GLOSS).evaluate(wi, wo))
    assert np.median(error) < 2e-3
    # Cells are a degree wide, and the last of them lie half below the horizon.
    inside = np.minimum(wi[:, 2], wo[:, 2]) > 0.1
    assert error[inside].max() < 0.05


def test_a_number_stands_for_the_middle_of_its_cell(measured: Merl, gloss: NDArray) -> None:
    wi, wo = merl.centres()
    chosen = np.flatnonzero((wi[:, 2] > 0.02) & (wo[:, 2] > 0.02))[::997]
    stored = gloss.reshape(3, -1).T[chosen] * SCALES
    np.testing.assert_allclose(measured.evaluate(wi[chosen], wo[chosen]), stored, rtol=1e-6)


def test_reciprocal_and_isotropic(measured: Merl) -> None:
    assert measured.isotropic
    wi, wo = pairs(3000)
    value = measured.evaluate(wi, wo)
    np.testing.assert_allclose(measured.evaluate(wo, wi), value, rtol=1e-9)
    np.testing.assert_allclose(measured.evaluate(turned(wi, 2), turned(wo, 2)), value, rtol=1e-6)


def test_nothing_steps(measured: Merl) -> None:
    """As the nearest cell would: changes shrink with the way."""
    changes = []
    for n in (2000, 16000):
        theta = np.linspace(0, 1.5, n)
        wo, wi = directions(theta, 2 * theta), np.tile(directions([0.7], [0.2]), (n, 1))
        changes.append(np.abs(np.diff(measured.evaluate(wi, wo), axis=0)).max())
    assert changes[1] < 0.2 * changes[0]


def test_black_below_the_surface_and_finite_on_the_horizon(measured: Merl) -> None:
    flat, down = np.array([[1.0, 0, 0]]), np.array([[0.6, 0, -0.8]])
    assert (measured.evaluate(flat, down) == 0).all()
    for wi, wo in ((flat, -flat), (flat, flat), (flat, np.array([[0, 0, 1.0]]))):
        value = measured.evaluate(wi, wo)
        assert np.isfinite(value).all()
        assert (value > 0).all()


def test_holes_are_filled_from_their_neighbours(gloss: NDArray, tmp_path: Path) -> None:
    """Wherever they are, one channel is enough to make one."""
    planes = gloss.copy()
    planes[1, 30:33, 20:23, 40:43] = -0.5
    planes[:, 30, 20, :3] = -1.0
    found = merl.read(write(tmp_path / "holes.binary", planes))
    assert found.filled == 30
    wi, wo = pairs(20000)
    value, true = found.evaluate(wi, wo), of_material(GLOSS).evaluate(wi, wo)
    assert relative(value, true)[np.minimum(wi[:, 2], wo[:, 2]) > 0.1].max() < 0.3
    report = found.report
    assert report.filled == 30
    assert 0 < report.extrapolated < 1e-3
    assert [d.code for d in report.diagnoses()] == ["measurement_has_holes"]


def test_what_stands_below_the_surface_does_not_show(tmp_path: Path) -> None:
    """Some files hold 0 there. A constant stays one up to the horizon all the same."""
    planes = table(Diffuse(diffuse=(0.5, 0.5, 0.5)))
    found = merl.read(write(tmp_path / "a.binary", np.maximum(planes, 0)))
    value = found.evaluate(*pairs(20000))
    np.testing.assert_allclose(value, 0.5 / np.pi, rtol=1e-6)


def test_report_of_a_table(measured: Merl) -> None:
    report = measured.report
    assert report.coverage == 1
    assert report.unlike_after < 1e-9
    assert report.diagnoses() == []
    assert report.energy_after.albedo == pytest.approx(
        of_material(GLOSS).report.energy_after.albedo, rel=0.05
    )


def test_bad_files(gloss: NDArray, tmp_path: Path) -> None:
    bad = tmp_path / "bad.binary"
    write(bad, gloss[:, :2], (90, 2, 180))
    with pytest.raises(InputError, match=r"bad\.binary: .* 90 x 90 x 180, this with 90 x 2 x 180"):
        read(bad)
    bad.write_bytes(b"\x5a\0\0")
    with pytest.raises(InputError, match="this with fewer than three numbers"):
        read(bad)
    write(bad, gloss[:2])
    with pytest.raises(InputError, match=r"cut short: 23,328,012 bytes .* has 34,992,012"):
        read(bad)
    with bad.open("ab") as file:
        file.write(gloss[2].tobytes() + b"\0")
    with pytest.raises(InputError, match=r"goes on after its end: 34,992,013 bytes"):
        read(bad)
    gloss = gloss.copy()
    gloss[1, 2, 3, 4] = np.nan
    with pytest.raises(InputError, match="1 values are NaN or infinite"):
        read(write(bad, gloss))
    with pytest.raises(InputError, match="all values are below 0"):
        read(write(bad, np.full_like(gloss, -1.0)))
