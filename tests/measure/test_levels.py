"""Levels of detail: as many vertices as asked, the same shape, smooth normals."""

from __future__ import annotations

import numpy as np
import pytest

from engine.measure.levels import smooth, subdivided, with_vertices
from engine.measure.stage import ball
from engine.scene.part import Part


def area(part: Part) -> float:
    a, b, c = (part.positions[part.triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def edge_counts(part: Part) -> np.ndarray:
    """How many triangles have each edge: two everywhere on a closed surface."""
    sides = np.sort(part.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(sides, axis=0, return_counts=True)[1]


@pytest.mark.parametrize("count", [300, 1_000, 4_000, 30_000])
def test_about_as_many_vertices_as_asked(count: int) -> None:
    """Both ways: a ball of 2,000 vertices made coarser and finer, closed and of the same size."""
    made = with_vertices(ball(32).part, count)
    assert len(made.positions) == pytest.approx(count, rel=0.03)
    assert np.unique(made.triangles).size == len(made.positions)
    assert area(made) == pytest.approx(np.pi, rel=0.03)
    assert made.normals is not None
    outward = made.positions / np.linalg.norm(made.positions, axis=1, keepdims=True)
    assert (np.sum(made.normals * outward, axis=1) > 0.95).mean() > 0.99
    assert (edge_counts(made) == 2).mean() > 0.97


def test_cutting_in_four_keeps_the_surface() -> None:
    """Vertices and edges become vertices; the area stays, and closed stays closed."""
    coarse = with_vertices(ball(8).part, 100)
    edges = edge_counts(coarse)
    finer = Part(*subdivided(coarse.positions, coarse.triangles))
    assert len(finer.positions) == len(coarse.positions) + len(edges)
    assert len(finer.triangles) == 4 * len(coarse.triangles)
    assert area(finer) == pytest.approx(area(coarse), rel=1e-12)
    assert (edges == 2).all()
    assert (edge_counts(finer) == 2).all()


def test_normals_are_the_same_on_both_sides_of_a_seam() -> None:
    """Vertices that the file keeps apart, for their texture coordinates, meet without a crease."""
    seam = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 2]], float)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0.5, 0], [0.5, 1], [0, 1]])
    made = smooth(Part(seam, np.array([[0, 1, 2], [3, 4, 5]]), uvs=uvs))
    assert made.normals is not None
    assert len(made.positions) == 6
    places, count = np.unique(made.positions, axis=0, return_counts=True)
    assert (count == 2).sum() == 2
    for place in places:
        here = made.normals[(made.positions == place).all(axis=1)]
        assert here == pytest.approx(np.tile(here[0], (len(here), 1)))
    assert len(np.unique(made.normals.round(6), axis=0)) == 3
