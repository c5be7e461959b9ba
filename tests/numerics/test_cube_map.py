"""Cube maps: orientation as in OpenGL, exact areas, neighbours over the edges."""

from __future__ import annotations

import numpy as np
import pytest

from engine.numerics.cube_map import (
    coordinates,
    directions,
    neighbours,
    solid_angles,
    texel,
    vector_areas,
)

SIZES = [1, 2, 8, 64]


@pytest.mark.parametrize("n", SIZES)
def test_every_direction_falls_on_its_own_texel(n: int) -> None:
    found = [texel(tuple(d), n) for d in directions(n)]
    assert found == list(range(6 * n * n))


def test_faces_lie_as_opengl_has_them() -> None:
    # The texel at the upper left of each face, in the order of the faces.
    corners = np.array(
        [[1, 1, 1], [-1, 1, -1], [-1, 1, -1], [-1, -1, 1], [-1, 1, 1], [1, 1, -1]]
    ) / np.sqrt(3)
    first = directions(64)[:: 64 * 64]
    assert (np.einsum("ij,ij->i", corners, first) > 0.99).all()


def test_four_texels_are_the_parts_of_one() -> None:
    fine, coarse = directions(16).reshape(-1, 4, 3).sum(axis=1), directions(8)
    fine /= np.linalg.norm(fine, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", fine, coarse).min() > 0.9999
    x, y = coordinates(16)
    assert (x.reshape(-1, 4) // 2 == coordinates(8)[0][:, None]).all()
    assert (y.reshape(-1, 4) // 2 == coordinates(8)[1][:, None]).all()


@pytest.mark.parametrize("n", SIZES)
def test_solid_angles_are_those_of_the_sphere(n: int) -> None:
    assert solid_angles(n).sum() == pytest.approx(4 * np.pi, rel=1e-12)
    if n > 1:
        parts = solid_angles(n).reshape(-1, 4).sum(axis=1)
        assert np.allclose(parts, solid_angles(n // 2), rtol=1e-9)


@pytest.mark.parametrize("n", SIZES)
def test_vector_areas(n: int) -> None:
    areas = vector_areas(n)
    assert np.abs(areas.sum(axis=0)).max() < 1e-12
    along = np.einsum("ij,ij->i", areas, directions(n)) / solid_angles(n)
    assert 0.83 < along.min() <= along.max() < 1
    # The upper hemisphere is whole texels: its projected solid angle is π.
    if n > 1:
        assert np.maximum(areas[:, 1], 0).sum() == pytest.approx(np.pi, rel=1e-9)


def test_a_texel_has_eight_neighbours_over_the_edges_too() -> None:
    n = 16
    around = neighbours(n)
    widest = np.cos(2 * np.sqrt(2) * 2 / n)
    near = np.einsum("ijk,ik->ij", directions(n)[around], directions(n))
    assert near.min() > widest
    assert not (around == np.arange(len(around))[:, None]).any()
    # Whoever is a neighbour has one there, but at the corners, where three faces meet.
    back = (around[around] == np.arange(len(around))[:, None, None]).any(axis=2)
    assert back.mean() > 0.99
