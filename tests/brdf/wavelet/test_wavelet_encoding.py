"""What an encoding is asked for it reaches, and its block is what it says."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.wavelet.sources import ASKEW, BRUSHED, ISOTROPIC, MATT, SOURCES, Formula

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.encoding import DEFAULT, Encoded, Target, encode
from engine.brdf.wavelet.layout import block
from engine.brdf.wavelet.tabulate import Source, grid_for, tabulate
from engine.errors import InputError


def encoded(source: Source, target: Target = DEFAULT, bits: int = 4) -> Encoded:
    grid = grid_for(source, bits)
    return encode(tabulate(source, grid), grid, target)


@pytest.mark.parametrize("name", SOURCES)
def test_symmetry_is_found(name: str) -> None:
    grid = grid_for(SOURCES[name], 4)
    assert layout.SYMMETRIES[grid.symmetry] == {"mirrored": "orthotropic"}.get(name, name)
    found = block(encoded(SOURCES[name]).data).header
    assert found[layout.SYMMETRY] == grid.symmetry
    assert (found[layout.ACROSS], found[layout.DOWN]) == (grid.across, grid.down)


@pytest.mark.parametrize("name", SOURCES)
@pytest.mark.parametrize("error", [0.01, 0.05])
def test_error_is_met_with_few_bytes(name: str, error: float) -> None:
    one, all_of_it = (
        encoded(SOURCES[name], Target(error=error)),
        encoded(SOURCES[name], Target(error=None)),
    )
    assert all_of_it.error < 0.006  # what 8 bits leave
    assert 0.9 * error < one.error <= error
    assert one.bytes < 0.8 * all_of_it.bytes


def test_more_bytes_less_error() -> None:
    errors, sizes = [], []
    for size in (30_000, 60_000, 120_000):
        one = encoded(BRUSHED, Target(bytes=size))
        assert one.bytes <= size
        errors.append(one.error)
        sizes.append(one.bytes)
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 2 * errors[2]
    assert sizes[1] > 50_000


def test_too_few_bytes_say_how_many_there_must_be() -> None:
    with pytest.raises(InputError, match=r"the least is \d+ bytes, not 1000"):
        encoded(BRUSHED, Target(bytes=1000))


@pytest.mark.parametrize("floor", [0.0, 2.0, float("nan")])
def test_floor_out_of_range(floor: float) -> None:
    with pytest.raises(InputError, match="floor"):
        encoded(MATT, Target(floor=floor))


def test_a_matt_brdf_has_no_tiles() -> None:
    one = encoded(MATT)
    assert one.error < 1e-6
    assert one.kept == 0
    assert not block(one.data).words[block(one.data).header[layout.MAP] :][: 255 * 2].any()


def test_grey_has_one_channel() -> None:
    """Channels that differ by a factor alone share their tiles."""
    factors = np.array([1.0, 0.5, 0.1])
    grey = Formula(lambda wi, wo: BRUSHED.evaluate(wi, wo)[..., :1] * factors, False)
    one, colour = encoded(grey, Target(error=None)), encoded(BRUSHED, Target(error=None))
    assert block(one.data).header[layout.CHANNELS] == 1
    assert block(colour.data).header[layout.CHANNELS] == 3
    assert one.bytes < 0.45 * colour.bytes


def test_a_black_channel_stays_black() -> None:
    red = Formula(lambda wi, wo: ISOTROPIC.evaluate(wi, wo) * (1.0, 0.0, 0.0), True)
    one = encoded(red)
    assert one.error < 0.01
    assert block(one.data).header[layout.CHANNELS] == 3


def test_all_black() -> None:
    black = Formula(lambda wi, wo: np.zeros_like(wi), True)
    one = encoded(black)
    assert one.error < 1e-12
    assert np.isfinite(block(one.data).floats[layout.HEADER : 100]).all()


def test_same_bytes_every_time() -> None:
    assert (encoded(ASKEW).data == encoded(ASKEW).data).all()


@pytest.mark.parametrize("floor", [1e-9, 1e-5, 1e-3, 0.1])
def test_a_range_of_five_powers_of_ten(floor: float) -> None:
    """A sharp glint over a nearly black base: bounded by the floor and the steps of 8 bits."""
    source = Formula(
        lambda wi, wo: (
            1e-3
            + 100 * np.exp(-30 * np.sum((wi + wo)[..., :2] ** 2, axis=-1))[..., None] * np.ones(3)
        ),
        True,
    )
    one = encoded(source, Target(error=None, floor=floor))
    assert one.error < 0.02
    assert one.worst < 0.1
