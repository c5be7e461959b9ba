"""Rivals are judged without the noise of their references, and at their own honest time."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from methods.scenes import cornell

from engine.light.environment import EnvironmentDescription
from engine.light.maps import load_environment
from engine.measure import mitsuba_variant
from engine.measure.halves import Halves
from engine.measure.metrics import psnr, relative_l2
from engine.measure.probes import held_out_edits, held_out_turns
from engine.measure.stage import MATERIALS, ball, stage
from engine.measure.truth import truth
from engine.methods import prepare
from engine.methods.direct_to_indirect import Settings
from engine.scene.edits import Edits, apply
from engine.store import Store


def halves(noise: float, seed: int = 0, size: int = 200) -> tuple[Halves, np.ndarray]:
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0.2, 0.6, (size, size, 3)).astype(np.float32)
    noisy = [
        (truth * (1 + noise * rng.normal(size=truth.shape))).astype(np.float32) for _ in range(2)
    ]
    return Halves(*noisy, np.ones((size, size), np.bool_)), truth


@pytest.mark.parametrize("off", [0.02, 0.05])
def test_halves_see_through_their_noise(off: float) -> None:
    """References up to five times noisier than the picture is wrong tell how wrong it is."""
    judge, truth = halves(0.1)
    rng = np.random.default_rng(9)
    image = (truth * (1 + off * rng.normal(size=truth.shape))).astype(np.float32)
    assert relative_l2(image, judge.first) > 0.09
    assert judge.relative_l2(image) == pytest.approx(relative_l2(image, truth), rel=0.1)
    assert judge.psnr(image) == pytest.approx(psnr(image, truth, exposure=EXPOSURE), abs=0.6)
    assert judge.noise() == pytest.approx(0.1, rel=0.02)


EXPOSURE = -np.log2(0.6)  # what brings the brightest to 1, as `Halves.psnr` takes it, nearly


def test_halves_do_not_tell_what_they_cannot_see() -> None:
    """A perfect picture is not said to be perfect, but no farther off than noise allows."""
    for seed in range(5):
        judge, truth = halves(0.1, seed)
        assert 0 < judge.relative_l2(truth) < 0.012
        assert judge.psnr(truth) < 50
    judge, truth = halves(0.0)
    assert judge.relative_l2(truth) == 0
    assert judge.psnr(truth) == np.inf


def test_pixels_outside_of_the_mask_do_not_count() -> None:
    judge, truth = halves(0.01)
    mask = np.ones_like(judge.mask)
    mask[:100] = False
    image = truth.copy()
    image[:100] = 0
    masked = Halves(judge.first, judge.second, mask)
    assert masked.relative_l2(image) < 0.005
    assert judge.relative_l2(image) > 0.5


def test_a_variant_that_aborts_is_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With no LLVM to be had it is the plain one, whatever the machine has."""
    monkeypatch.setenv(mitsuba_variant.LIBRARY, str(tmp_path / "none.so"))
    assert mitsuba_variant.fastest_variant.__wrapped__() == mitsuba_variant.PLAIN
    assert os.environ[mitsuba_variant.LIBRARY] == str(tmp_path / "none.so")


def test_rivals_on_a_small_box(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mitsuba_oidn")
    import mitsuba as mi

    from engine.measure import mitsuba_renderer
    from engine.measure import rivals as module

    # Kernels that are compiled for every number of samples would make this slow.
    monkeypatch.setattr(mitsuba_renderer, "fastest_variant", lambda: "scalar_rgb")
    monkeypatch.setattr(module, "MOST_SAMPLES", 32)
    scene, store = cornell(32), Store(tmp_path)
    product = prepare(scene, "direct_to_indirect", Settings(gather_samples=1024), store=store)
    edits = held_out_edits(scene, 2, seed=1)
    found = module.rivals(
        scene, product, edits, reference_error=0.05, reference_samples=64, store=store
    )
    assert found["variant"] == mi.variant() == "scalar_rgb"
    assert [len(one["edit"]["lights"]) for one in found["edits"]] == [3, 3]
    for one in found["edits"]:
        ours, mitsuba, denoised = one["ours"], one["mitsuba"], one["denoised"]
        assert 0.002 < ours["relative_l2"] < 0.2
        assert 20 < ours["psnr"] < 60
        assert one["mitsuba_over_ours"] == mitsuba["seconds"] / ours["seconds"]
        assert one["denoised_over_ours"] == denoised["seconds"] / ours["seconds"]
        # Noise falls with the root of the samples, time grows as they do.
        worse = mitsuba["measured_relative_l2"] / ours["relative_l2"]
        assert mitsuba["samples"] == pytest.approx(64 * worse**2)
        points = denoised["points"]
        assert [p["samples"] for p in points] == [2**k for k in range(len(points))]
        assert (points[-1]["psnr"] >= ours["psnr"]) == denoised["reached"]
        low, high = (points[0]["seconds"], points[-1]["seconds"])
        assert min(low, high) <= denoised["seconds"] <= max(p["seconds"] for p in points)
    spot = found["edits"][0]
    assert any("penumbra" in known for known in spot["differences"])


@pytest.mark.sweep
def test_rivals_under_an_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`glossy_prt` against Mitsuba, for turns of a map."""
    pytest.importorskip("mitsuba_oidn")

    from engine.measure import mitsuba_renderer
    from engine.measure import rivals as module
    from engine.methods.glossy_prt import Settings as Glossy

    monkeypatch.setattr(mitsuba_renderer, "fastest_variant", lambda: "scalar_rgb")
    monkeypatch.setattr(module, "MOST_SAMPLES", 16)
    studio = load_environment(EnvironmentDescription(map="studio"), Path())
    scene = stage(ball(12), MATERIALS["diffuse"], (24, 24), cuts=16, environment=studio)
    store = Store(tmp_path)
    settings = Glossy(light_texels=32, visibility_texels=32, gather_texels=8)
    product = prepare(scene, "glossy_prt", settings, store=store)
    found = module.rivals(
        scene,
        product,
        held_out_turns(scene, 1, seed=1),
        reference_error=0.05,
        reference_samples=64,
        store=store,
    )
    (one,) = found["edits"]
    assert one["differences"] == []
    assert 0.001 < one["ours"]["relative_l2"] < 0.1
    assert one["mitsuba"]["measured_relative_l2"] < 0.3
    # Where definitions do not differ, Mitsuba's picture is near ours, whichever way it is turned.
    turned = apply(scene, held_out_turns(scene, 1, seed=1)[0])
    theirs = mitsuba_renderer.Mitsuba(turned).picture(256, 1)
    true = truth(turned, Edits(), 0.05, store).image
    inner = np.s_[2:-2, 2:-2]
    assert relative_l2(theirs[inner], true[inner]) < 0.12


def test_what_mitsuba_is_said_to_need_is_what_it_needs(tmp_path: Path) -> None:
    """As many samples as are asked of it for an error do give it, within the noise of noise."""
    pytest.importorskip("mitsuba_oidn")
    import mitsuba as mi

    from engine.measure.mitsuba_renderer import Mitsuba
    from engine.measure.rivals import _plain

    mi.set_variant("scalar_rgb")
    scene = cornell(24)
    theirs, mask = Mitsuba(scene), np.ones((24, 24), np.bool_)
    mask[:8] = False  # without the lamp, which is as bright as all the rest together
    wanted = 0.1
    needed, judge = _plain(theirs, wanted, 128, mask)
    few = max(1, round(needed["samples"]))
    errors = [judge.relative_l2(theirs.picture(few, seed)) for seed in range(20, 28)]
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(wanted, rel=0.25)


def test_the_time_to_a_psnr_lies_between_points() -> None:
    pytest.importorskip("mitsuba_oidn")
    from engine.measure.rivals import _seconds_to

    points = [
        {"samples": 1, "seconds": 1.0, "psnr": 30.0},
        {"samples": 2, "seconds": 4.0, "psnr": 34.0},
    ]
    assert _seconds_to(32.0, points) == pytest.approx(2.0)
    assert _seconds_to(34.0, points) == pytest.approx(4.0)
    assert _seconds_to(25.0, points[:1]) == 1.0
    assert _seconds_to(40.0, points) == 4.0
