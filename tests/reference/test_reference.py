"""What the reference promises whatever the scene: same bytes, right error bars, no NaN."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import engine.reference
from engine.errors import Cancelled, InputError
from engine.reference import render, render_direct
from engine.reference.limits import Limits
from engine.reference.result import relative_error
from engine.scene.build import build
from engine.scene.camera import Camera
from engine.scene.edits import edited_camera
from engine.scene.open import describe, open_scene
from engine.scene.scene import Scene

POINT = {"id": "point", "type": "point", "position": [0.3, 0.7, 0.2], "intensity": [1, 2, 3]}
LAMP = {
    "id": "lamp",
    "type": "area",
    "position": [0, 0.98, 0],
    "target": [0, 0, 0],
    "up": [0, 0, 1],
    "width": 0.5,
    "height": 0.5,
    "intensity": [8, 7, 6],
}


def room(lights: list, size: int = 16, **document: object) -> Scene:
    """A box around the camera with a glossy ball in it."""
    return build(
        describe(
            {
                "camera": {
                    "position": [0.2, 0.1, 0.9],
                    "target": [0, -0.2, 0],
                    "fov_y_degrees": 70,
                    "width": size,
                    "height": size,
                },
                "lights": lights,
                "materials": {
                    "wall": {"type": "diffuse", "diffuse": [0.7, 0.6, 0.5]},
                    "ball": {"type": "ggx", "specular": [0.5, 0.5, 0.5], "roughness": 0.4},
                    "glow": {"type": "diffuse", "emission": [1, 0.5, 0.2]},
                },
                "objects": [
                    {
                        "name": "box",
                        "mesh": {"shape": "box", "size": [2, 2, 2]},
                        "material": "wall",
                    },
                    {
                        "name": "ball",
                        "mesh": {"shape": "sphere", "radius": 0.4, "rings": 16},
                        "material": "ball",
                        "transform": {"translate": [-0.3, -0.5, -0.2]},
                    },
                    {
                        "name": "glow",
                        "mesh": {"shape": "sphere", "radius": 0.15, "rings": 8},
                        "material": "glow",
                        "transform": {"translate": [0.6, -0.6, -0.3]},
                    },
                ],
                **document,
            }
        ),
        Path(),
    )


def bytes_of(result: engine.reference.Reference) -> bytes:
    pictures = (result.image, result.variance, result.direct, result.indirect)
    return b"".join(p.tobytes() for p in pictures)


def assert_same(a, va, b, vb) -> None:
    """Blocks of 4 x 4 pixels agree within both variances, corrected for their number."""

    def blocks(p: np.ndarray) -> np.ndarray:
        h, w = p.shape[0] // 4, p.shape[1] // 4
        return p.astype(np.float64).reshape(h, 4, w, 4, 3).sum(axis=(1, 3))

    z = np.abs(blocks(a) - blocks(b)) / np.sqrt(blocks(va) + blocks(vb))
    limit = stats.norm.isf((1 - (1 - 1e-4) ** (1 / z.size)) / 2)
    assert z.max() < limit, f"{z.max():.1f} standard errors apart, {limit:.1f} allowed"


def test_public_names():
    assert engine.reference.__all__ == ["Reference", "render", "render_direct"]


def test_same_bytes_whatever_the_threads(monkeypatch):
    scene = room([POINT, LAMP])
    made = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("RELIGHT_THREADS", threads)
        made.append(bytes_of(render(scene, samples=128, seed=7)))
    assert made[0] == made[1] == made[2]
    assert made[0] != bytes_of(render(scene, samples=128, seed=8))


def test_weighed_samples_agree_with_brute_force():
    """Multiple importance sampling against one sample for each light, weighed against nothing."""
    scene = room([POINT, LAMP], environment={"map": [1, 1, 1]})
    fast = render(scene, samples=1024, seed=1, max_bounces=1)
    plain = render_direct(scene, samples=2048, seed=2)
    assert_same(fast.image, fast.variance, plain.image, plain.variance)
    assert not plain.indirect.any()
    assert not fast.indirect.any()


def test_light_adds_up():
    """The picture of two lights is the sum of their pictures; so is that of one twice as strong."""
    both, one, other = (
        render(room(lights), samples=256, seed=k)
        for k, lights in enumerate(([POINT, LAMP], [POINT], [LAMP]))
    )
    glow = render(room([]), samples=256, seed=9)
    assert_same(
        both.image + glow.image,
        both.variance + glow.variance,
        one.image + other.image,
        one.variance + other.variance,
    )
    twice = render(room([{**POINT, "intensity": [2, 4, 6]}]), samples=64, seed=1)
    once = render(room([POINT]), samples=64, seed=1)
    dark = render(room([]), samples=64, seed=1)
    assert twice.image.mean() - once.image.mean() == pytest.approx(
        once.image.mean() - dark.image.mean(), rel=0.05
    )


def test_parts_make_the_whole_and_deeper_light_adds():
    scene = room([POINT, LAMP])
    whole = render(scene, samples=256, seed=1)
    np.testing.assert_allclose(whole.direct + whole.indirect, whole.image, rtol=1e-5, atol=1e-6)
    means = [render(scene, samples=256, seed=1, max_bounces=k).image.mean() for k in range(4)]
    assert means[0] < means[1] < means[2] < means[3] < whole.image.mean()
    direct = render(scene, samples=256, seed=1, max_bounces=1)
    assert_same(direct.image, direct.variance, whole.direct, whole.variance)


def test_error_bars_are_right():
    """Independent pictures scatter as their own variance says, indirect light too."""
    scene = room([POINT, LAMP], size=12)
    made = [render(scene, samples=64, seed=k) for k in range(24)]
    for picture, variance in (("image", "variance"), ("indirect", "indirect_variance")):
        seen = np.var([getattr(r, picture) for r in made], axis=0, ddof=1).mean()
        said = np.mean([getattr(r, variance) for r in made])
        assert said == pytest.approx(seen, rel=0.15)
    mean = np.mean([r.image for r in made], axis=0)
    off = [np.linalg.norm(r.image - mean) / np.linalg.norm(mean) for r in made]
    assert np.mean([r.error for r in made]) == pytest.approx(np.mean(off), rel=0.1)


def test_stops_at_the_requested_error():
    scene = room([POINT], size=12)
    rough, fine = render(scene, error=0.1), render(scene, error=0.03)
    assert 0.5 * 0.03 < fine.error <= 0.03
    assert rough.error <= 0.1
    assert rough.samples < fine.samples
    assert bytes_of(fine) == bytes_of(render(scene, error=0.03))


def test_the_error_is_that_of_the_pixels_that_are_meant():
    scene = open_scene("cornell-box")
    scene = scene.with_camera(edited_camera(scene.camera, {"width": 24, "height": 24}))
    meant = np.zeros((24, 24), bool)
    meant[16:] = True
    every, some = (render(scene, samples=16, counted=counted) for counted in (None, meant))
    assert some.image.tobytes() == every.image.tobytes()
    assert some.error == relative_error(some.image[meant], some.variance[meant])
    # The lamp is above: its light is known, and most of the picture's.
    assert some.error > 1.5 * every.error
    error = 0.5 * some.error
    tight = render(scene, error=error, counted=meant)
    assert tight.error <= error
    assert tight.samples > render(scene, error=error).samples


def test_stops_in_time():
    result = render(room([POINT, LAMP], size=32), max_seconds=0.5)
    assert result.samples >= 1
    assert result.seconds < 5


def test_progress_can_cancel():
    said = []

    def progress(phase: str, done: float, total: float) -> None:
        said.append((phase, done, total))
        if len(said) == 3:
            raise Cancelled("enough")

    with pytest.raises(Cancelled):
        render(room([POINT]), samples=100_000, progress=progress)
    assert all(phase == "reference" and 0 < done <= total for phase, done, total in said)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"samples": 0}, "samples"),
        ({"error": 0.0}, "error"),
        ({"error": float("nan")}, "error"),
        ({"max_seconds": -1.0}, "max_seconds"),
        ({"max_bounces": -1}, "max_bounces"),
        ({"seed": -1}, "seed"),
    ],
)
def test_refuses_what_cannot_be(arguments, field):
    with pytest.raises(InputError, match=field):
        render(room([POINT]), **arguments)


def test_limits_reach_what_they_ask():
    limits = Limits(samples=100, error=None, max_seconds=None)
    done = 0
    while more := limits.next_pass(done, 1.0, 0.0):
        done += more
    assert done == 100
    # An error that falls as theory says is met without much overshoot.
    limits, done = Limits(samples=None, error=0.01, max_seconds=None), 0
    while more := limits.next_pass(done, done**-0.5 if done else np.inf, 0.0):
        done += more
    assert 10_000 <= done <= 12_000


AWKWARD = {
    "no lights": lambda: room(
        [],
        materials={
            "wall": {"type": "diffuse"},
            "ball": {"type": "diffuse"},
            "glow": {"type": "diffuse"},
        },
    ),
    "light on a surface": lambda: room([{**POINT, "position": [0, -1, 0]}]),
    "light in a corner": lambda: room([{**POINT, "position": [1, 1, 1]}]),
    "lamp in the ceiling": lambda: room([{**LAMP, "position": [0, 1, 0]}]),
    "light at the camera": lambda: room([{**POINT, "position": [0.2, 0.1, 0.9]}]),
    "camera in the wall": lambda: room([POINT, LAMP]).with_camera(
        Camera(position=(0, 0, 1), target=(0, 0, 0), width=16, height=16)
    ),
    "camera in the ball": lambda: room([POINT, LAMP]).with_camera(
        Camera(position=(-0.3, -0.5, -0.2), target=(0, 0, 0.3), width=16, height=16)
    ),
    "one pixel": lambda: room([POINT, LAMP], size=1),
    "a thousand lights": lambda: room(
        [
            {
                **POINT,
                "id": f"p{k}",
                "position": [-0.9 + 0.0018 * k, 0.8, 0],
                "intensity": [1e-3] * 3,
            }
            for k in range(1000)
        ],
        size=4,
    ),
}

# A camera exactly in the plane of a wall sees the wall from behind.
DARK = ("no lights", "camera in the wall", "camera in the ball")


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_scenes_stay_finite(name):
    scene = AWKWARD[name]()
    for result in (render(scene, samples=32), render_direct(scene, samples=8)):
        for picture in (result.image, result.variance, result.direct, result.indirect):
            assert np.isfinite(picture).all()
            assert picture.min() >= 0 or picture is result.direct
        assert np.isfinite(result.error)
        assert (result.image.max() > 0) == (name not in DARK)


def test_lamp_in_the_ceiling_is_the_lamp_below_it():
    """A lamp that lies in a surface is not hidden by it."""
    inside = render(room([{**LAMP, "position": [0, 1, 0]}]), samples=512, seed=1, max_bounces=1)
    below = render(room([{**LAMP, "position": [0, 0.9995, 0]}]), samples=512, seed=2, max_bounces=1)
    a, b = inside.direct[8:], below.direct[8:]  # the lower half does not see the lamp itself
    assert_same(a, inside.variance[8:], b, below.variance[8:])
    assert a.mean() > 0.05


def test_cornell_box_is_red_on_the_left():
    scene = open_scene("cornell-box")
    scene = scene.with_camera(edited_camera(scene.camera, {"width": 24, "height": 24}))
    result = render(scene, samples=64)
    left, right = result.image[8:16, :3].mean((0, 1)), result.image[8:16, -3:].mean((0, 1))
    assert left[0] > 3 * left[1]
    assert right[1] > 2 * right[0]
