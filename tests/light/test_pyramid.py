"""Images in lights: their sizes, their mean, what is between pixels, what is said of bad ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit
from PIL import Image

from engine.errors import SceneError
from engine.images import encode_exr
from engine.light.pyramid import BUILT_IN, MAX_SIDE, STEP, Pyramid, load_image, look_up, pyramid


@njit
def _look_up(texels, first, width, height, u, v, lod, out):
    for i in range(len(u)):
        out[i, 0], out[i, 1], out[i, 2] = look_up(texels, first, width, height, u[i], v[i], lod)


def at(image: Pyramid, u: np.ndarray, v: np.ndarray, lod: float = 0.0) -> np.ndarray:
    """(n, 3); another image stands before it, as in a table of two."""
    texels = np.concatenate([np.full((3 * STEP, 3), 1e6, np.float32), image.texels])
    u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    out = np.zeros((u.size, 3))
    size = np.float32(image.width), np.float32(image.height)
    _look_up(texels, np.float32(3), *size, u.ravel(), v.ravel(), lod, out)
    return out


def noise(height: int, width: int) -> np.ndarray:
    return np.random.default_rng(1).random((height, width, 3)).astype(np.float32)


def grid(n: int) -> tuple[np.ndarray, np.ndarray]:
    u, v = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
    return u.ravel(), v.ravel()


def test_pixels_come_back_at_their_middles() -> None:
    image = noise(5, 7)
    u, v = np.meshgrid((np.arange(7) + 0.5) / 7, (np.arange(5) + 0.5) / 5)
    np.testing.assert_allclose(at(pyramid(image), u, v), image.reshape(-1, 3), rtol=1e-5)


def test_between_pixels_it_is_linear_and_at_the_border_it_goes_on() -> None:
    image = np.zeros((1, 2, 3), np.float32)
    image[0, 1] = (1, 2, 4)
    found = at(pyramid(image), np.array([0, 0.25, 0.5, 0.625, 0.75, 1]), 0.5)
    np.testing.assert_allclose(found[:, 0], [0, 0, 0.5, 0.75, 1, 1], atol=1e-12)
    np.testing.assert_allclose(found[:, 2], 4 * found[:, 0])


@pytest.mark.parametrize("shape", [(8, 8), (7, 13), (1, 9), (64, 3), (1, 1)])
def test_every_level_has_the_mean(shape: tuple[int, int]) -> None:
    """However odd the sizes: a light keeps its power at every distance."""
    image = noise(*shape)
    for lod in (0.0, 0.4, 1.0, 2.5, 30.0):
        mean = at(pyramid(image), *grid(7 * 9 * 13), lod).mean(axis=0)
        np.testing.assert_allclose(mean, image.mean(axis=(0, 1)), rtol=1e-3)


def test_small_levels_show_what_is_there() -> None:
    """The quarter of an image with one bright quadrant has it at the same place."""
    image = np.zeros((16, 16, 3), np.float32)
    image[:8, 8:] = 1
    for lod in (0.0, 1.0, 2.0, 3.0):
        found = at(
            pyramid(image), np.array([0.75, 0.25, 0.25, 0.75]), [0.25, 0.25, 0.75, 0.75], lod
        )
        np.testing.assert_allclose(found[:, 0], [1, 0, 0, 0], atol=1e-6)


def test_level_of_detail_has_no_steps() -> None:
    image = pyramid(noise(32, 32))
    values = np.concatenate([at(image, 0.3, 0.6, lod) for lod in np.linspace(0, 6, 3001)])
    assert np.abs(np.diff(values, axis=0)).max() < 2e-3
    assert np.abs(values[0] - values[-1]).max() > 0.05


def test_large_images_are_made_smaller_and_keep_their_mean() -> None:
    image = noise(100, 3 * MAX_SIDE)
    made = pyramid(image)
    assert (made.width, made.height) == (MAX_SIDE, 33)
    assert len(made.texels) % STEP == 0
    found = made.texels[: made.width * made.height].mean(axis=0)
    np.testing.assert_allclose(found, image.mean(axis=(0, 1)), rtol=1e-3)


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_images(name: str) -> None:
    """In range, neither black nor white all over, and the same object each time."""
    made = load_image(name, Path("nowhere"))
    assert 0 <= made.texels.min() < 0.1
    assert 0.7 < made.texels.max() <= 1
    assert load_image(name, Path()) is made


def test_files_are_linear_and_read_once(tmp_path: Path) -> None:
    Image.fromarray(np.full((4, 4, 3), 188, np.uint8)).save(tmp_path / "grey.png")
    made = load_image("grey.png", tmp_path)
    # IEC 61966-2-1: 188 / 255 is about one half in linear light.
    np.testing.assert_allclose(at(made, 0.5, 0.5), 0.503, atol=1e-3)
    assert load_image("grey.png", tmp_path) is made
    Image.fromarray(np.full((6, 4, 3), 255, np.uint8)).save(tmp_path / "grey.png")
    again = load_image("grey.png", tmp_path)
    assert again.height == 6


def test_bad_files_say_what(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"none\.png.*no such file.*window, leaves, chart"):
        load_image("none.png", tmp_path)
    (tmp_path / "below").mkdir()
    (tmp_path / "secret.png").write_bytes(b"")
    for name in ("../secret.png", str(tmp_path / "secret.png")):
        with pytest.raises(SceneError, match="must lie in the folder of the scene"):
            load_image(name, tmp_path / "below")
    (tmp_path / "text.png").write_text("no image")
    with pytest.raises(SceneError, match=r"text\.png"):
        load_image("text.png", tmp_path)
    image = np.ones((4, 4, 3), np.float32)
    image[1, 2, 0] = np.nan
    (tmp_path / "nan.exr").write_bytes(encode_exr(image))
    with pytest.raises(SceneError, match=r"nan\.exr.*NaN or infinite"):
        load_image("nan.exr", tmp_path)
