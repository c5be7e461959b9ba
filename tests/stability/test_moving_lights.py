"""Lights that move by a pixel a frame, are many, or are off: nothing pops, nothing is lost."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from methods.scenes import POINT, cornell

from engine.methods.direct_to_indirect import Transfer
from engine.scene.edits import Edits

SIZE, FRAMES = 40, 14
Make = Callable[..., Transfer]
OFF = {"id": "ceiling", "enabled": False}


def path(kind: str) -> list[Edits]:
    """A light that crosses the box, at each frame moved by what a pixel shows of the back wall."""
    step = 0.55 / SIZE
    spot = {"type": "spot", "cone_degrees": 14.0, "penumbra_degrees": 2.0, "target": None}
    edits = []
    for k in range(FRAMES):
        x = 0.12 + step * k
        light = {**POINT, "id": "key", "type": "point", "position": [x, 0.45, 0.15]}
        if kind == "spot":
            light |= {**spot, "target": [x + 0.05, 0.45, 0.56]}
        edits.append(Edits(lights=[OFF, light]))
    return edits


def norm(image: np.ndarray) -> float:
    return float(np.linalg.norm(image))


@pytest.mark.parametrize("kind", ["point", "spot"])
def test_nothing_pops_while_a_light_moves(make: Make, kind: str) -> None:
    """What culling and quantisation take changes from frame to frame by less than it is.

    Judged against the same cloud with all coefficients kept: the error of a frame may be some
    per cent, its change in a frame that moves the light by a pixel must be far less, and no pixel
    may flicker.
    """
    box = cornell(SIZE)
    few = make(box, gather_samples=16384)
    all_kept = make(box, gather_samples=16384, coefficients=1024, bounce_coefficients=1024)
    frames = np.array([few.indirect(e) for e in path(kind)])
    whole = np.array([all_kept.indirect(e) for e in path(kind)])
    size = np.mean([norm(w) for w in whole])
    errors = frames - whole
    error = np.mean([norm(e) for e in errors]) / size
    change = [norm(b - a) / size for a, b in itertools.pairwise(errors)]
    moved = [norm(b - a) / size for a, b in itertools.pairwise(whole)]
    # A pop is a frame that its neighbours do not lead to.
    jolt = np.abs(frames[2:] - 2 * frames[1:-1] + frames[:-2]).max(axis=(1, 2, 3))
    jolt_whole = np.abs(whole[2:] - 2 * whole[1:-1] + whole[:-2]).max(axis=(1, 2, 3))
    # Of a point 1.4 % is off and 0.14 % changes, of a spot 3.5 % and 1.5 %, while the light itself
    # changes the picture by 3.5 and 12.7 %.
    assert error < (0.02 if kind == "point" else 0.05)
    assert max(change) < (0.07 if kind == "point" else 0.2) * max(moved)
    assert jolt.max() < 1.1 * jolt_whole.max()


def test_all_lights_off_is_black_and_says_nothing(make: Make) -> None:
    box = cornell(24)
    off = [{"id": light.id, "enabled": False} for light in box.lights]
    product = make(box, gather_samples=1024)
    for scale in (1, 2):
        frame = product.relight(Edits(lights=off), scale)
        assert not frame.image.any()
        assert frame.warnings == ()
    dark = [{"id": light.id, "intensity": [0, 0, 0]} for light in box.lights]
    frame = product.relight(Edits(lights=dark))
    assert not frame.image.any()
    assert frame.warnings == ()
