"""Error metrics against closed forms and their own laws."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.errors import InputError
from engine.measure import metrics

Image = NDArray[np.float32]


@pytest.fixture
def reference() -> Image:
    rng = np.random.default_rng(3)
    smooth = np.linspace(0.1, 0.8, 24)[None, :, None] * np.array([1.0, 0.8, 0.5])
    return (smooth * rng.uniform(0.9, 1.1, (16, 24, 1))).astype(np.float32)


@pytest.fixture
def mask() -> NDArray[np.bool_]:
    keep = np.zeros((16, 24), np.bool_)
    keep[4:12, 6:18] = True
    return keep


@pytest.mark.parametrize("name", metrics.METRICS)
def test_equal_pictures_have_no_error(name: str, reference: Image, mask: NDArray) -> None:
    perfect = math.inf if name == "psnr" else 0.0
    assert metrics.METRICS[name](reference, reference) == perfect
    assert metrics.METRICS[name](reference, reference, mask) == perfect


@pytest.mark.parametrize("name", metrics.METRICS)
def test_more_noise_is_worse(name: str, reference: Image) -> None:
    noise = np.random.default_rng(5).normal(size=reference.shape).astype(np.float32)
    sign = -1 if name == "psnr" else 1
    found = [sign * metrics.METRICS[name](reference + s * noise, reference) for s in (0.01, 0.05)]
    assert found[0] < found[1]


@pytest.mark.parametrize("name", metrics.METRICS)
def test_the_mask_hides_what_lies_outside(name: str, reference: Image, mask: NDArray) -> None:
    far = reference.copy()
    far[0, 0] += 0.3
    metric = metrics.METRICS[name]
    if name.startswith("flip"):  # it looks at neighbourhoods, so only what is near matters
        assert metric(far, reference, mask) < 0.05 * metric(far, reference, ~mask)
    else:
        assert metric(far, reference, mask) == metric(reference, reference, mask)
    assert metric(far, reference) != metric(reference, reference)


@pytest.mark.parametrize("factor", [0.0, 0.5, 0.9, 1.3, 3.0])
def test_relative_l2_of_a_scaled_picture(factor: float, reference: Image) -> None:
    scaled = np.float32(factor) * reference
    assert metrics.relative_l2(scaled, reference) == pytest.approx(abs(factor - 1), rel=1e-5)


def test_relative_l2_against_black(reference: Image) -> None:
    black = np.zeros_like(reference)
    assert metrics.relative_l2(reference, black) == math.inf
    assert metrics.relative_l2(black, black) == 0.0


def test_rmse_of_a_constant_offset(reference: Image) -> None:
    assert metrics.rmse(reference + np.float32(0.25), reference) == pytest.approx(0.25, rel=1e-5)


def test_psnr_is_taken_from_displayed_values() -> None:
    # sRGB: linear 0.5 shows as 0.735357, 0.25 as 0.537099 (IEC 61966-2-1).
    a, b = (np.full((4, 4, 3), value, np.float32) for value in (0.5, 0.25))
    assert metrics.psnr(a, b) == pytest.approx(-20 * math.log10(0.735357 - 0.537099), abs=1e-3)
    # One stop darker: 0.25 and 0.125 show as 0.537099 and 0.388573.
    assert metrics.psnr(a, b, exposure=-1.0) == pytest.approx(
        -20 * math.log10(0.537099 - 0.388573), abs=1e-3
    )


def test_white_and_black_are_100_apart() -> None:
    white, black = np.ones((4, 4, 3), np.float32), np.zeros((4, 4, 3), np.float32)
    assert metrics.lab_difference(white, black) == pytest.approx(100, abs=0.01)


def test_lab_difference_against_another_library(reference: Image) -> None:
    import colour

    other = reference * np.float32([1.1, 1.0, 0.8])
    lab = [
        colour.XYZ_to_Lab(colour.sRGB_to_XYZ(colour.models.eotf_inverse_sRGB(x)))
        for x in (other, reference)
    ]
    expected = colour.delta_E(*lab, method="CIE 2000").mean()
    assert metrics.lab_difference(other, reference) == pytest.approx(expected, rel=2e-3)


def test_hdr_flip_does_not_depend_on_the_scale(reference: Image) -> None:
    other = np.roll(reference, 3, axis=1)
    expected = metrics.flip_hdr(other, reference)
    assert expected > 0.05
    for scale in (1e-6, 1e4):
        s = np.float32(scale)
        assert metrics.flip_hdr(s * other, s * reference) == pytest.approx(expected, rel=1e-4)


def test_hdr_flip_of_dark_pictures_does_not_end_the_process() -> None:
    # The evaluator exits where it finds no exposure, so this runs in a process of its own.
    program = """
import numpy as np
from engine.measure.metrics import flip_hdr
black, dot = np.zeros((16, 16, 3), np.float32), np.zeros((16, 16, 3), np.float32)
dot[3, 4] = 1e-35
print(flip_hdr(black, black), flip_hdr(dot, black), flip_hdr(dot, dot), flip_hdr(black, dot) > 0)
"""
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["0.0", "1.0", "0.0", "True"]


def test_auto_exposure_brings_bright_pixels_to_white(reference: Image) -> None:
    for scale in (1e-3, 1.0, 50.0):
        stops = metrics.auto_exposure(np.float32(scale) * reference)
        assert np.percentile(2.0**stops * scale * reference.max(axis=2), 99) == pytest.approx(1)
    assert metrics.auto_exposure(np.zeros((2, 2, 3), np.float32)) == 0.0


def test_all_metrics_leave_edges_out_but_for_one(reference: Image, mask: NDArray) -> None:
    far = reference.copy()
    far[0, 0] += 1.0
    found = metrics.all_metrics(far, reference, mask)
    assert found["relative_l2"] == 0.0
    assert found["relative_l2_everywhere"] > 0.0
    assert set(found) == {*metrics.METRICS, "relative_l2_everywhere"}


@pytest.mark.parametrize("name", metrics.METRICS)
def test_what_cannot_be_compared_is_refused(name: str, reference: Image, mask: NDArray) -> None:
    metric = metrics.METRICS[name]
    with pytest.raises(InputError, match="different shapes"):
        metric(reference[:-1], reference)
    with pytest.raises(InputError, match="different shapes"):
        metric(reference, reference, mask[:-1])
    for value in (np.nan, np.inf):
        broken = reference.copy()
        broken[5, 5, 1] = value
        with pytest.raises(InputError, match="NaN or infinity"):
            metric(broken, reference)


def noisy(reference: Image, sigma: float, seed: int) -> Image:
    noise = np.random.default_rng(seed).normal(0, sigma, reference.shape)
    return (reference + noise).astype(np.float32)


@pytest.mark.parametrize("bias", [0.03, 0.1])
def test_the_noise_of_the_reference_is_taken_out(reference: Image, bias: float) -> None:
    truth = np.tile(reference, (8, 8, 1))
    image = np.float32(1 + bias) * truth
    variance = np.full_like(truth, 0.05**2)
    raw, clean = [], []
    for seed in range(8):
        mean = noisy(truth, 0.05, seed)
        raw.append(metrics.relative_l2(image, mean))
        clean.append(metrics.relative_l2(image, mean, variance=variance))
    assert np.sqrt(np.mean(np.square(clean))) == pytest.approx(bias, rel=0.05)
    assert np.mean(raw) > 1.3 * bias


def test_resolution_bounds_what_noise_alone_gives(reference: Image, mask: NDArray) -> None:
    truth = np.tile(reference, (4, 4, 1))
    keep = np.tile(mask, (4, 4))
    variance = np.full_like(truth, 0.05**2)
    found, floors = [], []
    for seed in range(40):
        mean = noisy(truth, 0.05, seed)
        found.append(metrics.relative_l2(truth, mean, keep, variance))
        floors.append(metrics.resolution(mean, variance, keep))
    below = np.mean(np.array(found) <= floors)
    assert below >= 0.95
    assert max(found) > 0.3 * np.mean(floors), "the bound is loose"
    assert np.mean(floors) < metrics.relative_l2(mean, truth, keep) / 2


def test_distances_in_lab_are_those_of_1976() -> None:
    """Of greys that is the difference of L*, and none where clipping makes both white."""
    image, reference = (np.full((1, 2, 3), v, np.float32) for v in (0.5, 0.25))
    image[0, 1] = reference[0, 1] = 3.0
    reference[0, 1, 0] = 5.0
    lightness = [116 * y ** (1 / 3) - 16 for y in (0.5, 0.25)]
    distance = metrics.lab_distance(image, reference)
    assert distance.shape == (1, 2)
    assert distance[0, 0] == pytest.approx(lightness[0] - lightness[1], abs=0.02)
    assert distance[0, 1] == pytest.approx(0, abs=1e-6)


def test_an_error_that_stays_does_not_flicker(reference: Image) -> None:
    """What goes with the truth, or is off by the same, is not counted; what jumps is."""
    truths = [reference, 1.1 * reference, 1.3 * reference]
    assert metrics.flicker(truths, truths) == 0
    assert metrics.flicker([t + np.float32(0.2) for t in truths], truths) == pytest.approx(
        0, abs=1e-6
    )
    jumping = [truths[0], truths[1] + 0.1 * truths[1], truths[2]]
    # Up by a tenth of the second, and down again.
    expected = (0.11 / 1 + 0.11 / 1.1) / 2
    assert metrics.flicker(jumping, truths) == pytest.approx(expected, rel=1e-5)
    # Pictures that do not move lack what moves.
    still = metrics.flicker([0 * t for t in truths], truths)
    assert still == pytest.approx((0.1 + 0.2 / 1.1) / 2, rel=1e-5)


def test_noise_of_references_is_no_flicker(reference: Image) -> None:
    rng = np.random.default_rng(8)
    noise = np.float32(0.05)
    seen = [reference + noise * rng.normal(size=reference.shape).astype(np.float32) for _ in "abc"]
    variances = [np.full_like(reference, noise**2) for _ in seen]
    still = [reference] * 3
    raw = metrics.flicker(still, seen)
    assert raw > 0.1
    assert metrics.flicker(still, seen, None, variances) < 0.3 * raw


def test_flicker_of_masked_pixels(reference: Image, mask: NDArray) -> None:
    frames = [reference.copy(), reference.copy()]
    frames[1][~mask] = 5
    assert metrics.flicker(frames, [reference] * 2, mask) == 0
    assert metrics.flicker(frames, [reference] * 2) > 1
