"""Lights that move by a pixel a frame, are many, or are off: nothing pops, nothing is lost."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from methods.errors import error_and_noise
from methods.scenes import POINT, cornell

from engine.measure.probes import many_lights
from engine.methods.direct_to_indirect import Transfer
from engine.reference import render
from engine.scene.edits import Edits, apply

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


def test_a_small_bright_patch_is_grainy(make: Make) -> None:
    """A spot on the block's top alone: few of a pixel's 233 rays meet it, so neighbours differ.

    Eleven times the rays make it smooth.
    """
    light = {
        **POINT,
        "id": "key",
        "type": "spot",
        "cone_degrees": 14.0,
        "position": [0.32, 0.45, 0.2],
        "target": [0.37, 0.33, 0.35],
    }
    edit = Edits(lights=[OFF, light])
    box = cornell(24)
    truth = render(apply(box, edit), samples=2048, seed=9)
    error, bias = {}, {}
    for rays in (233, 2584):
        product = make(box, gather_samples=16384, view_rays=rays)
        inside = np.ones((24, 24), bool)
        inside.ravel()[product.view.buffer.edge] = False
        image, true = product.indirect(edit)[inside], truth.indirect[inside]
        error[rays], noise = error_and_noise(image, true, truth.indirect_variance[inside])
        bias[rays] = float(image.mean() / true.mean() - 1)
    # 12 and 6 %, both 5 % too dark by the paper's few coefficients.
    assert noise < 0.2
    assert error[233] < 0.18
    assert error[2584] < 0.75 * error[233]
    assert max(-b for b in bias.values()) < 0.09


def test_hundreds_of_lights_against_the_reference(make: Make) -> None:
    """Two hundred points, each a two-hundredth as bright as one."""
    box = cornell(24)
    box = box.with_lights(many_lights(box, 200, seed=3))
    truth = render(box, samples=320, seed=8)
    product = make(box, gather_samples=4096)
    inside = np.ones((24, 24), bool)
    inside.ravel()[product.view.buffer.edge] = False
    error, noise = error_and_noise(
        product.indirect(Edits())[inside],
        truth.indirect[inside],
        truth.indirect_variance[inside],
    )
    assert noise < 0.1
    assert error < 0.06
    # One of them moved is one of them moved.
    first = box.lights[0].id
    frame = product.relight(Edits(lights=[{"id": first, "position": [0.3, 0.2, 0.1]}]))
    assert np.isfinite(frame.image).all()
    change = norm(frame.image - product.relight(Edits()).image) / norm(frame.image)
    assert 0 < change < 0.1


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
