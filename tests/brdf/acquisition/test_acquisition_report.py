"""What is said of measurements: coverage, reciprocity, energy, and in which words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import completed, pairs, sampled
from numpy.typing import NDArray

from engine.brdf.acquisition import Report, of_material, read
from engine.brdf.acquisition.completion import complete
from engine.brdf.acquisition.samples import Samples, directions
from engine.brdf.acquisition.survey import energy, unlike_reverses
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx

GLOSS = Ggx(roughness=0.4, diffuse=(0.3, 0.1, 0.02))


def codes(report: Report) -> list[str]:
    return [diagnosis.code for diagnosis in report.diagnoses()]


def test_good_data_need_no_words() -> None:
    report = completed(sampled(GLOSS, *pairs(4000))).report
    assert report.diagnoses() == []
    assert report.samples == 4000
    assert report.coverage > 0.98
    assert report.coverage + report.extrapolated == 1
    assert report.largest_gap_degrees < 25
    assert report.unlike_after == 0
    assert report.energy_after.albedo == pytest.approx(
        of_material(GLOSS).report.energy_after.albedo, rel=0.1
    )


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_energy_is_that_of_the_models_own_sampler(roughness: float) -> None:
    for material in (
        Ggx(roughness=roughness),
        AshikhminShirley(exponent_u=10 / roughness, exponent_v=50 / roughness),
    ):
        model = of_material(material)
        sampler = model.report.energy_after
        grid = energy(model.evaluate, model.isotropic)
        assert grid.albedo == pytest.approx(sampler.albedo, rel=0.02)


def test_energy_of_a_diffuse_surface_is_its_reflectance() -> None:
    found = energy(of_material(Diffuse(diffuse=(0.2, 0.8, 0.1))).evaluate, True)
    assert found.albedo == pytest.approx(0.8, rel=1e-3)
    assert found.channel == 1


def test_data_that_create_energy_are_reported_not_scaled() -> None:
    samples = sampled(GLOSS, *pairs(2000))
    samples = replace(samples, rgb=4 * samples.rgb)
    function = completed(samples)
    value = function.evaluate(samples.wi, samples.wo)
    assert np.median(value / samples.rgb) == pytest.approx(1, abs=0.02)
    assert codes(function.report) == ["albedo_above_one"]
    diagnosis = function.report.diagnoses()[0]
    assert diagnosis.size == pytest.approx(function.report.energy_after.albedo - 1)
    assert "times the red light it receives" in diagnosis.message
    assert "used as it is" in diagnosis.message


def test_values_not_divided_by_the_cosine_are_noticed() -> None:
    """The commonest fault of such files. A sound one of the same pairs is not accused."""
    theta = np.radians(np.arange(5, 81, 5))
    theta_i, theta_o, phi = (
        x.ravel() for x in np.meshgrid(theta, theta, np.radians(np.arange(0, 181, 20)))
    )
    wi, wo = directions(theta_i, np.zeros_like(phi)), directions(theta_o, phi)
    sound = sampled(GLOSS, wi, wo)
    assert completed(sound).report.unlike_reverses < 1e-9
    assert codes(completed(sound).report) == []
    report = completed(replace(sound, rgb=sound.rgb * wi[:, 2:])).report
    # All but those that are their own reverse, of which some have others near.
    assert 2400 <= report.reverse_pairs < len(phi) == 2560
    assert report.unlike_reverses > 0.4
    assert report.reverse_bias > 0.4
    assert report.unlike_after == 0
    assert codes(report) == ["measurement_not_reciprocal"]
    assert "divided by the cosine" in report.diagnoses()[0].message


@pytest.mark.parametrize("isotropic", [True, False])
def test_coverage_of_a_part_of_the_domain(isotropic: bool) -> None:
    """Both directions within 45 degrees: a quarter of all, and a rim of 10 degrees at most."""
    wi, wo = pairs(60000)
    inside = (wi[:, 2] > np.sqrt(0.5)) & (wo[:, 2] > np.sqrt(0.5))
    phi = np.zeros(inside.sum()) if isotropic else np.arctan2(wi[inside, 1], wi[inside, 0])
    first = directions(np.arccos(wi[inside, 2]), phi)
    flat = Samples("part", first, wo[inside], np.full((len(phi), 3), 0.1))
    report = complete(flat, isotropic).report
    assert np.sin(np.radians(45)) ** 4 < report.coverage < np.sin(np.radians(55)) ** 4
    # Where both are on the horizon, both are 45 degrees away.
    assert 60 < report.largest_gap_degrees < 70
    assert codes(report) == ["measurement_has_gaps"]


def test_one_sample_leaves_all_to_guess() -> None:
    up = np.array([[0, 0, 1.0]])
    report = completed(Samples("one", up, up, np.full((1, 3), 0.1))).report
    assert report.coverage < 0.01
    assert report.largest_gap_degrees > 80
    assert report.reverse_pairs == 0
    assert codes(report) == ["measurement_has_gaps"]


def test_counts_are_said() -> None:
    samples = replace(
        sampled(GLOSS, *pairs(4000)), name="tin", dropped=1, clamped=7, out_of_gamut=5
    )
    report = completed(samples).report
    assert codes(report) == ["samples_below_surface", "samples_below_zero", "colours_out_of_gamut"]
    rows, values, colours = (d.message for d in report.diagnoses())
    assert "1 row has a direction below the surface" in rows
    assert "7 values" in values
    assert "5 of 4000 samples" in colours
    assert all("'tin'" in message for message in (rows, values, colours))


class Lopsided:
    """Twice as bright one way as the other."""

    def evaluate(self, wi: NDArray, wo: NDArray) -> NDArray[np.float64]:
        return np.where(wi[:, :1] > wo[:, :1], 0.2, 0.1) * np.ones(3)


def test_a_model_that_is_not_reciprocal_is_named() -> None:
    unlike = unlike_reverses(Lopsided().evaluate)
    assert unlike == pytest.approx(2 / 3)
    report = replace(of_material(GLOSS).report, unlike_after=unlike)
    assert codes(report) == ["material_not_reciprocal"]
    assert "67%" in report.diagnoses()[0].message


@pytest.mark.data
@pytest.mark.parametrize("name", ["garnet_red", "krylon_blue", "mystique"])
def test_real_files(shared_data: Path, name: str) -> None:
    measurement = read(shared_data / "brdfs" / f"{name}.brdf")
    report = measurement.report
    assert measurement.isotropic
    assert report.coverage > 0.95
    assert report.energy_after.albedo < 0.5
    assert report.unlike_after == 0
    assert "colours_out_of_gamut" in codes(report)
