"""Environments from files, built in, and constant; what is said of bad ones."""

from __future__ import annotations

from pathlib import Path

import imagecodecs
import numpy as np
import pytest

from engine.errors import SceneError
from engine.images import encode_exr
from engine.light.environment import EnvironmentDescription
from engine.light.maps import BUILT_IN, load_environment


def _load(folder: Path, name: str) -> np.ndarray:
    return load_environment(EnvironmentDescription(map=name), folder).radiance


def test_constant() -> None:
    made = load_environment(EnvironmentDescription(map=(1, 2, 3), intensity=2), Path())
    np.testing.assert_array_equal(made.radiance, [[[1, 2, 3]]])
    np.testing.assert_array_equal(made.table.radiance, [[[2, 4, 6]]])


def test_studio_is_lit_by_soft_boxes() -> None:
    """Most of it is dark, most of its light comes from the boxes, and from above."""
    image = _load(Path(), "studio")
    assert image.shape == (128, 256, 3)
    assert image.dtype == np.float32
    assert np.median(image) < 0.2
    assert image.max() > 5
    solid = np.sin((np.arange(128) + 0.5) * np.pi / 128)[:, None]
    light = image.mean(axis=2) * solid
    assert light[image.mean(axis=2) > 1].sum() > 0.7 * light.sum()
    assert light[:64].sum() > 3 * light[64:].sum()
    assert set(BUILT_IN) == {"studio"}


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_file_is_read_as_it_was_written(tmp_path: Path, suffix: str) -> None:
    image = (10 ** np.random.default_rng(1).uniform(-2, 3, (16, 32, 3))).astype(np.float32)
    data = encode_exr(image) if suffix == ".exr" else imagecodecs.rgbe_encode(image)
    (tmp_path / f"probe{suffix}").write_bytes(data)
    # RGBE shares one exponent among the channels: half an 8-bit step of the brightest.
    step = 0 if suffix == ".exr" else image.max(axis=2, keepdims=True) / 128
    assert (np.abs(_load(tmp_path, f"probe{suffix}") - image) <= step).all()


def test_negative_values_become_black(tmp_path: Path) -> None:
    image = np.ones((4, 8, 3), np.float32)
    image[1, 2] = (-0.5, 2, -1e-6)
    (tmp_path / "probe.exr").write_bytes(encode_exr(image))
    np.testing.assert_array_equal(_load(tmp_path, "probe.exr")[1, 2], (0, 2, 0))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_pixels_that_are_no_numbers_are_refused(tmp_path: Path, value: float) -> None:
    image = np.ones((4, 8, 3), np.float32)
    image[1, 2, 0] = value
    (tmp_path / "probe.exr").write_bytes(encode_exr(image))
    with pytest.raises(SceneError, match=r"probe\.exr.*1 pixels are NaN.*row 1, column 2") as error:
        _load(tmp_path, "probe.exr")
    assert error.value.field == "environment.map"


def test_other_bad_maps_say_what(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"none\.hdr.*no such file.*studio"):
        _load(tmp_path, "none.hdr")
    with pytest.raises(SceneError, match="no such file"):
        _load(tmp_path, ".")
    (tmp_path / "square.exr").write_bytes(encode_exr(np.ones((8, 8, 3), np.float32)))
    with pytest.raises(SceneError, match=r"square\.exr.*twice as wide as high.*this is 8 x 8"):
        _load(tmp_path, "square.exr")
    (tmp_path / "cut.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n\x02")
    with pytest.raises(SceneError, match=r"cut\.hdr.*not a readable Radiance HDR file"):
        _load(tmp_path, "cut.hdr")


@pytest.mark.data
def test_real_maps(shared_data: Path) -> None:
    """Every map of the data folder loads, and its sampling table is sound."""
    paths = sorted((shared_data / "envmaps").glob("*.exr"))
    assert len(paths) >= 8
    for path in paths:
        made = load_environment(EnvironmentDescription(map=path.name), path.parent)
        assert made.radiance.shape == (256, 512, 3)
        assert made.radiance.min() >= 0
        assert made.radiance.max() > 1
        assert (np.diff(made.table.rows) > 0).all()
        assert (np.diff(made.table.columns, axis=1) > 0).all()
