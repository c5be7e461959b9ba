"""Meshes of fewer vertices are meshes still."""

from __future__ import annotations

import numpy as np
import pytest

from engine.measure.stage import knot
from engine.scene.simplify import clustered


def test_clusters_leave_no_triangle_without_area() -> None:
    part = knot(64, 8).part
    positions, triangles, size = clustered(part.positions, part.triangles, 150)
    assert 0.01 < size < 0.5
    assert len(positions) == pytest.approx(150, rel=0.1)
    a, b, c = np.sort(triangles, axis=1).T
    assert (a < b).all()
    assert (b < c).all()
    assert len(np.unique(np.sort(triangles, axis=1), axis=0)) == len(triangles)
