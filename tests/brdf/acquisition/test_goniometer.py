"""Text files of goniometers: what is read, what is dropped, what is said of bad ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import goniometer_file

from engine.brdf.acquisition import goniometer
from engine.errors import InputError

ROW = (0.5, 0.0, 0.4, 3.0, 0.1, 0.1, 0.1)
OTHER = (0.6, 0.0, 0.4, 3.0, 0.2, 0.2, 0.2)


def test_rows_become_directions_and_colours(tmp_path: Path) -> None:
    samples = goniometer.read(goniometer_file(tmp_path / "paint.brdf", [ROW, OTHER]))
    assert samples.name == "paint"
    np.testing.assert_allclose(samples.wi[0], [np.sin(0.5), 0, np.cos(0.5)], atol=1e-6)
    expected = [np.sin(0.4) * np.cos(3), np.sin(0.4) * np.sin(3), np.cos(0.4)]
    np.testing.assert_allclose(samples.wo, [expected] * 2, atol=1e-6)
    np.testing.assert_allclose(samples.rgb, [[0.1] * 3, [0.2] * 3], rtol=1e-9)
    assert (samples.dropped, samples.clamped, samples.out_of_gamut) == (0, 0, 0)


def test_rows_below_the_surface_are_dropped(tmp_path: Path) -> None:
    """But not those on the horizon, as rounded as they are."""
    below = [(1.7, *ROW[1:]), (0.5, 0.0, 2.0, *ROW[3:])]
    horizon = (1.570797, *ROW[1:])
    path = goniometer_file(tmp_path / "a.brdf", [ROW, *below, horizon])
    samples = goniometer.read(path)
    assert samples.dropped == 2
    assert len(samples.rgb) == 2
    assert (samples.wi[:, 2] >= 0).all()
    with pytest.raises(InputError, match=r"b\.brdf: no row has both of its directions above"):
        goniometer.read(goniometer_file(tmp_path / "b.brdf", below))


def test_negative_values_become_black(tmp_path: Path) -> None:
    """Counted where the row is used."""
    rows = [(*ROW[:4], -0.1, -0.2, -0.3), (*ROW[:4], 0.3, 0.3, 0.3), (2.0, *ROW[1:6], -1.0)]
    samples = goniometer.read(goniometer_file(tmp_path / "a.brdf", rows))
    assert samples.clamped == 3
    np.testing.assert_allclose(samples.rgb, [[0, 0, 0], [0.3] * 3], atol=1e-12)


def test_colours_outside_of_srgb_are_counted(tmp_path: Path) -> None:
    rows = [(*ROW[:4], 0.0, 0.0, 0.0, 1.0, 0.0), (*ROW[:4], *[0.5] * 5)]
    nm = (450.0, 470.0, 490.0, 510.0, 530.0)
    samples = goniometer.read(goniometer_file(tmp_path / "a.brdf", rows, nm))
    assert samples.out_of_gamut == 1
    assert (samples.rgb >= 0).all()


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([ROW, OTHER[:5]], r"line 10: the file is cut short: its last row has 5 of 7 numbers"),
        ([ROW[:5], OTHER], r"line 9: a row has 7 numbers, 4 angles and 3 values; this has 5"),
        ([ROW, (*ROW, 1.0)], r"line 10: a row has 7 numbers.*this has 8"),
        ([(45.0, *ROW[1:])], r"line 9: an angle.*45 is more than π: angles are in radians"),
        ([], r"wavelengths but no rows"),
    ],
)
def test_bad_rows(tmp_path: Path, rows: Sequence[Sequence[float]], message: str) -> None:
    path = goniometer_file(tmp_path / "bad.brdf", rows)
    with pytest.raises(InputError, match=r"bad\.brdf.*" + message) as error:
        goniometer.read(path)
    assert error.value.file == str(path)


@pytest.mark.parametrize("word", ["abc", "nan", "inf", "1,5", "\x00\xff"])
def test_what_is_no_number(tmp_path: Path, word: str) -> None:
    path = goniometer_file(tmp_path / "bad.brdf", [ROW, OTHER])
    path.write_bytes(path.read_bytes().replace(b"0.600000", word.encode("latin-1")))
    with pytest.raises(InputError, match=r"line 10: .* is not a (finite )?number"):
        goniometer.read(path)


@pytest.mark.parametrize(
    ("wavelengths", "count", "message"),
    [
        ((450.0, 650.0, 550.0), None, r"line 6: the wavelengths must ascend"),
        ((450.0, 450.0, 550.0), None, r"line 6: the wavelengths must ascend"),
        ((-5.0, 450.0, 550.0), None, r"line 6: the wavelengths must ascend"),
        ((450.0, 550.0, 650.0), "2.5", r"line 4: the number of wavelengths should.*'2.5'"),
        ((450.0, 550.0, 650.0), "0", r"line 4: the number of wavelengths"),
        ((450.0, 550.0, 650.0), "3 450", r"line 4: the number of wavelengths.*'3 450'"),
        ((450.0, 550.0, 650.0), "1", r"line 5: there are more wavelengths than the 1 announced"),
        ((450.0, 550.0, 650.0), "99", r"the file ends after 10 of 99 wavelengths"),
    ],
)
def test_bad_heads(
    tmp_path: Path, wavelengths: Sequence[float], count: str | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        goniometer.read(goniometer_file(tmp_path / "bad.brdf", [ROW], wavelengths, count))


@pytest.mark.parametrize("text", ["", "\n\n", "# only words\n"])
def test_nothing_at_all(tmp_path: Path, text: str) -> None:
    (tmp_path / "empty.brdf").write_text(text)
    with pytest.raises(InputError, match=r"empty\.brdf: the file holds no numbers"):
        goniometer.read(tmp_path / "empty.brdf")


def test_a_file_cut_short_at_any_byte_is_read_or_refused(tmp_path: Path) -> None:
    """Where the cut leaves whole numbers in the last row, nobody can tell; else it is refused."""
    path = goniometer_file(tmp_path / "cut.brdf", [ROW, OTHER])
    whole = path.read_bytes()
    read = 0
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        try:
            read += len(goniometer.read(path).rgb) > 0
        except InputError:
            continue
    assert 0 < read < 90


@pytest.mark.data
@pytest.mark.parametrize("name", ["garnet_red", "krylon_blue", "mystique"])
def test_real_files(shared_data: Path, name: str) -> None:
    samples = goniometer.read(shared_data / "brdfs" / f"{name}.brdf")
    assert samples.rgb.shape == (1439, 3)
    assert (samples.dropped, samples.clamped) == (0, 0)
    brightest = samples.rgb[np.argsort(samples.rgb.sum(axis=1))[700]].argmax()
    assert brightest == {"garnet_red": 0, "krylon_blue": 2}.get(name, brightest)
