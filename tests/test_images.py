"""Image files: what is written is what is read, and what is said of bad ones."""

from __future__ import annotations

from pathlib import Path

import imagecodecs
import numpy as np
import pytest
from PIL import Image

from engine.errors import InputError, SceneError
from engine.images import encode, encode_exr, read_image, write_image
from engine.numerics.display import linear_from_srgb, to_srgb8


def _picture(height: int = 24, width: int = 40) -> np.ndarray:
    """Smooth, in colour, within what a screen shows."""
    y, x = np.mgrid[0:height, 0:width]
    return np.stack(
        [0.2 + 0.7 * x / width, 0.9 - 0.7 * y / height, 0.5 + 0.3 * np.sin(x / 9)], axis=2
    ).astype(np.float32)


@pytest.mark.parametrize("half", [False, True])
def test_exr_keeps_radiance(tmp_path: Path, half: bool) -> None:
    """Far outside what a screen shows, negative and not a number included."""
    image = _picture() * 1e4 - 10
    image[3, 4] = (np.nan, -1e6, 1e6) if not half else (np.nan, -6e4, 6e4)
    write_image(tmp_path / "a.exr", image, exposure=3, half=half)
    read = read_image(tmp_path / "a.exr")
    assert read.dtype == np.float32
    np.testing.assert_allclose(read, image, rtol=5e-4 if half else 0)


def test_half_ends_at_its_largest_number(tmp_path: Path) -> None:
    write_image(tmp_path / "a.exr", np.full((2, 2, 3), 1e6, np.float32), half=True)
    assert (read_image(tmp_path / "a.exr") == 65504).all()


@pytest.mark.parametrize(("suffix", "step"), [(".png", 0.51), (".jpg", 8), (".webp", 12)])
def test_others_hold_what_a_screen_shows(tmp_path: Path, suffix: str, step: float) -> None:
    """At an exposure of -1 stop, half the light; top row first, red first."""
    image = _picture()
    write_image(tmp_path / f"a{suffix}", 2 * image, exposure=-1)
    signal = np.asarray(Image.open(tmp_path / f"a{suffix}"), float)
    assert signal.shape == image.shape
    low, high = image - 0.004, image + 0.004
    assert (np.abs(signal - to_srgb8(image)) <= step + 0.5).all()
    read = read_image(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(read, linear_from_srgb(signal / 255), atol=1e-6)
    if suffix == ".png":
        assert ((read >= low) & (read <= high)).all()


def test_radiance_hdr_is_linear(tmp_path: Path) -> None:
    image = _picture() * 300
    (tmp_path / "a.hdr").write_bytes(imagecodecs.rgbe_encode(image))
    step = image.max(axis=2, keepdims=True) / 128
    assert (np.abs(read_image(tmp_path / "a.hdr") - image) <= step).all()


def test_grey_and_alpha_become_colour(tmp_path: Path) -> None:
    Image.fromarray(np.full((3, 5), 128, np.uint8)).save(tmp_path / "grey.png")
    Image.fromarray(np.full((3, 5, 4), 128, np.uint8)).save(tmp_path / "alpha.png")
    for name in ("grey.png", "alpha.png"):
        read = read_image(tmp_path / name)
        assert read.shape == (3, 5, 3)
        np.testing.assert_allclose(read, 0.21586, atol=1e-5)


def test_deep_grey_keeps_its_range(tmp_path: Path) -> None:
    """16 bits of grey are brightness, floating point is light."""
    Image.fromarray(np.full((3, 5), 32896, np.uint16)).save(tmp_path / "deep.png")
    np.testing.assert_allclose(read_image(tmp_path / "deep.png"), 0.21586, atol=1e-5)
    Image.fromarray(np.full((3, 5), 2.5, np.float32)).save(tmp_path / "light.tiff")
    assert (read_image(tmp_path / "light.tiff") == 2.5).all()


@pytest.mark.parametrize("format", ["png", "jpeg", "webp"])
def test_encode_is_deterministic(format: str) -> None:
    image = to_srgb8(_picture())
    assert encode(image, format) == encode(image.copy(), format)
    assert encode(image[::2, ::2], format)  # not contiguous


def test_quality_decides_size() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    for format in ("jpeg", "webp"):
        assert len(encode(noise, format, 30)) < 0.7 * len(encode(noise, format, 95))
    with pytest.raises(ValueError, match="'tiff' is none of"):
        encode(noise, "tiff")


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("none.png", None, "no such image file"),
        ("bad.png", b"hello", "not a readable image file"),
        ("cut.png", encode(to_srgb8(_picture()), "png")[:-200], "not a readable image file"),
        ("bad.jpg", encode(to_srgb8(_picture()), "jpeg")[:40], "not a readable image file"),
        ("bad.exr", b"hello", "not a readable EXR file"),
        ("cut.exr", encode_exr(_picture())[:-200], "not a readable EXR file"),
        ("bad.hdr", b"hello", "not a readable Radiance HDR file"),
        ("xyz.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", "XYZE"),
        ("empty.exr", b"", "not a readable EXR file"),
    ],
)
def test_bad_file_is_named(tmp_path: Path, name: str, data: bytes | None, words: str) -> None:
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(SceneError, match=words) as error:
        read_image(tmp_path / name)
    assert name in error.value.file


def test_bad_target_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.gif.*must end in one of \.exr"):
        write_image(tmp_path / "a.gif", _picture())
    with pytest.raises(InputError, match=r"a\.png.*there is no such folder"):
        write_image(tmp_path / "nowhere" / "a.png", _picture())
