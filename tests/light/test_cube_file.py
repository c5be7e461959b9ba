"""Cube maps from files: which face looks where, energy, a constant, there and back again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.errors import SceneError
from engine.images import encode_exr
from engine.light.cube_file import LAYOUTS, UPRIGHT_CROSS, cube_faces, unfolded
from engine.light.cube_light import CubeLight
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.light.maps import load_environment, read_map
from engine.numerics.cube_map import AHEAD, DOWN, RIGHT, coordinates, directions, solid_angles

N = 8
every_layout = pytest.mark.parametrize("layout", LAYOUTS, ids=["lying", "upright", "row", "column"])


def laid_out(faces: NDArray, layout: tuple[int, int], beside: float = 0.0) -> NDArray[np.float32]:
    """An image of faces (6, n, n, 3), with a value wherever it has none of them."""
    n = faces.shape[1]
    image = np.full((layout[0] * n, layout[1] * n, 3), beside, np.float32)
    for k, (i, j) in enumerate(LAYOUTS[layout]):
        turned = k == 5 and layout == UPRIGHT_CROSS
        image[i * n : i * n + n, j * n : j * n + n] = faces[k, ::-1, ::-1] if turned else faces[k]
    return image


def seen(image: NDArray, d: NDArray) -> NDArray[np.float32]:
    """What every renderer sees of a map in directions (n, 3)."""
    return seen_radiance(Environment(EnvironmentDescription(), image), places_on_map(d))


def flux(image: NDArray) -> NDArray[np.float64]:
    edges = np.cos(np.linspace(0, np.pi, len(image) + 1))
    solid = (edges[:-1] - edges[1:]) * 2 * np.pi / image.shape[1]
    return (image * solid[:, None, None]).sum(axis=(0, 1), dtype=np.float64)


def on_faces(solid: NDArray, n: int) -> NDArray[np.float64]:
    """(6, n, n) row by row of what is in quad-tree order."""
    x, y = coordinates(n)
    out = np.zeros((6, n, n))
    out[:, y, x] = solid.reshape(6, -1)
    return out


def noise(n: int) -> NDArray[np.float32]:
    return np.random.default_rng(1).uniform(0, 1, (6, n, n, 3)).astype(np.float32)


@every_layout
def test_faces_are_found_where_they_lie(layout: tuple[int, int]) -> None:
    """Whatever a cross has beside them, be it no numbers at all."""
    faces = noise(N)
    found = cube_faces(laid_out(faces, layout, beside=np.nan))
    assert found is not None
    np.testing.assert_array_equal(found, faces)


@pytest.mark.parametrize("n", [7, N, 33])
def test_every_face_looks_its_way_and_stands_upright(n: int) -> None:
    """Its middle, and the middles of its quarters, as OpenGL has them."""
    faces = np.zeros((6, n, n, 3), np.float32)
    faces[..., 0] = np.arange(1, 7)[:, None, None]
    faces[:, :, n // 2 :, 1] = 1  # right
    faces[:, n // 2 :, :, 2] = 1  # down
    image = unfolded(faces)
    for k in range(6):
        assert seen(image, AHEAD[k : k + 1])[0, 0] == k + 1
        for a, b in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
            d = AHEAD[k] + 0.5 * a * RIGHT[k] + 0.5 * b * DOWN[k]
            expected = [k + 1, a > 0, b > 0]
            found = seen(image, d[None] / np.linalg.norm(d))[0]
            np.testing.assert_allclose(found, expected, atol=1e-6)


def test_neighbouring_faces_meet_in_the_crosses() -> None:
    """A smooth map has no jump where cells of a cross touch, -Z on its head included."""
    ramp = 2 + directions(32) @ np.array([0.5, 0.3, -0.7])
    faces = np.repeat(on_faces(ramp, 32)[..., None], 3, axis=3)
    lying, upright = laid_out(faces, (3, 4)), laid_out(faces, (4, 3))
    for image, joints in (
        (lying, [(slice(32, 64), 32), (slice(32, 64), 64), (slice(32, 64), 96)]),
        (upright, [(slice(32, 64), 32), (slice(32, 64), 64)]),
    ):
        for rows, column in joints:
            assert np.abs(image[rows, column] - image[rows, column - 1]).max() < 0.06
    for image, joints in ((lying, [32, 64]), (upright, [32, 64, 96])):
        for row in joints:
            assert np.abs(image[row, 32:64] - image[row - 1, 32:64]).max() < 0.06


@pytest.mark.parametrize("n", [1, 2, 5, 16, 64])
def test_a_constant_stays_one_and_noise_keeps_its_energy(n: int) -> None:
    np.testing.assert_allclose(unfolded(np.ones((6, n, n, 3), np.float32)), 1, rtol=1e-5)
    faces = noise(n)
    solid = on_faces(solid_angles(n), n) if n & (n - 1) == 0 else None
    if solid is not None:
        total = (faces * solid[..., None]).sum(axis=(0, 1, 2))
        np.testing.assert_allclose(flux(unfolded(faces)), total, rtol=1e-4)


def test_every_texel_keeps_its_energy() -> None:
    """To 0.1 %, a single bright one too: three at a time, one in each channel."""
    solid = on_faces(solid_angles(N), N)
    for k in range(6):
        for row in range(N):
            for column in range(0, N - 2, 3):
                faces = np.zeros((6, N, N, 3), np.float32)
                faces[k, row, [column, column + 1, column + 2], [0, 1, 2]] = 1e4
                expected = 1e4 * solid[k, row, column : column + 3]
                np.testing.assert_allclose(flux(unfolded(faces)), expected, rtol=1e-3)


def test_there_and_back_again() -> None:
    """From a map to a cube by the light vectors of `glossy_prt`, and back."""
    theta = (np.arange(64) + 0.5)[:, None] * np.pi / 64
    phi = (np.arange(128) + 0.5)[None] * 2 * np.pi / 128
    wave = 1 + 0.5 * np.sin(theta) ** 2 * np.cos(2 * phi) + 0.3 * np.cos(theta)
    image = np.repeat(wave[..., None], 3, axis=2).astype(np.float32)
    texels = CubeLight(32).radiance(Environment(EnvironmentDescription(), image))
    faces = np.stack([on_faces(texels[:, c], 32) for c in range(3)], axis=-1).astype(np.float32)
    back = unfolded(faces)
    assert back.shape == (64, 128, 3)
    np.testing.assert_allclose(flux(back), flux(image), rtol=1e-4)
    assert np.abs(back - image).max() < 0.06
    assert np.abs(back - image).mean() < 0.01


@every_layout
def test_files_are_known_by_their_shape(tmp_path: Path, layout: tuple[int, int]) -> None:
    faces = noise(4) - 0.1
    (tmp_path / "cube.exr").write_bytes(encode_exr(laid_out(faces, layout)))
    made = load_environment(EnvironmentDescription(map="cube.exr"), tmp_path)
    np.testing.assert_array_equal(made.radiance, unfolded(np.maximum(faces, 0)))


def test_what_is_said_of_bad_ones(tmp_path: Path) -> None:
    faces = noise(4)
    faces[5, 1, 2] = np.inf
    path = tmp_path / "cube.exr"
    path.write_bytes(encode_exr(laid_out(faces, (4, 3))))
    with pytest.raises(
        SceneError, match=r"1 pixels are NaN or .*face -Z, row 1, column 2"
    ) as error:
        read_map(path)
    assert (error.value.field, Path(error.value.file).name) == ("environment.map", "cube.exr")
    path.write_bytes(encode_exr(np.ones((6, 9, 3), np.float32)))
    with pytest.raises(SceneError, match=r"cross of 4 to 3.*this is 9 x 6"):
        read_map(path)
