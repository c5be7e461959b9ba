"""Geometry in the world: transforms, made normals, triangles without area."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from engine.errors import SceneError
from engine.scene import shapes
from engine.scene.geometry import Placed, assemble
from engine.scene.normals import with_normals
from engine.scene.part import Part
from engine.scene.scene import Geometry, Scene

EYE = np.eye(4)


def bare(part: Part) -> Part:
    """The part as a file without normals would have it."""
    return Part(part.positions, part.triangles)


def facets(geometry: Geometry) -> np.ndarray:
    c = geometry.positions[geometry.triangles].astype(np.float64)
    flat = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
    return flat / np.linalg.norm(flat, axis=1, keepdims=True)


def soup(part: Part) -> Part:
    """The part with three vertices of its own for each triangle, as STL has it."""
    corners = part.positions[part.triangles].reshape(-1, 3)
    return Part(corners, np.arange(len(corners)).reshape(-1, 3))


def test_arrays_are_as_kernels_want_them() -> None:
    part = shapes.make(shapes.Sphere(shape="sphere", rings=8))
    geometry, diagnoses = assemble([Placed(part, EYE, 3, 0)], ["ball"])
    for array in geometry:
        assert array.flags.c_contiguous
        assert array.dtype in (np.float32, np.int32)
    assert set(geometry.material) == {3}
    assert diagnoses == ()


def test_a_bare_box_gets_flat_faces() -> None:
    box = shapes.make(shapes.Box(shape="box", size=(1, 2, 3)))
    geometry, diagnoses = assemble([Placed(soup(box), EYE, 0, 0)], ["box"])
    assert np.allclose(geometry.normals[geometry.triangles], facets(geometry)[:, None], atol=1e-6)
    # One vertex for each corner of each face, however the file had them.
    assert len(geometry.positions) == 24
    assert [d.code for d in diagnoses] == ["normals_made"]


def test_a_bare_sphere_gets_smooth_normals() -> None:
    sphere = shapes.make(shapes.Sphere(shape="sphere", radius=1, rings=24))
    for part in (bare(sphere), soup(sphere)):
        made = with_normals(part)
        assert made.normals is not None
        error = np.linalg.norm(made.normals - made.positions, axis=1)
        assert error.max() < 0.02
    # The seam and the poles are welded.
    assert len(made.positions) == 23 * 48 + 2


def test_made_normals_do_not_depend_on_how_a_face_is_cut() -> None:
    # A corner of a box, smooth by choice of angles, once with each diagonal of its top.
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [0.5, -0.2, 2], [-1, -0.2, 0.5]])
    rest = [[3, 2, 4], [0, 3, 5]]
    normals = []
    for top in ([[0, 2, 1], [0, 3, 2]], [[0, 3, 1], [1, 3, 2]]):
        made = with_normals(Part(points.astype(float), np.array([*top, *[r[::-1] for r in rest]])))
        at = np.flatnonzero((made.positions == points[3]).all(axis=1))
        assert made.normals is not None
        normals.append(made.normals[at])
    assert np.allclose(normals[0], normals[1])


def test_texture_seams_do_not_crease() -> None:
    sphere = shapes.make(shapes.Sphere(shape="sphere", rings=16))
    made = with_normals(Part(sphere.positions, sphere.triangles, None, sphere.uvs))
    assert made.normals is not None
    assert np.linalg.norm(made.normals - 2 * made.positions, axis=1).max() < 0.03
    assert made.uvs is not None
    assert made.uvs[:, 0].max() == 1


def test_broken_normals_in_a_file_are_made_anew() -> None:
    box = shapes.make(shapes.Box(shape="box"))
    for bad in (0.0, np.nan):
        normals = np.array(box.normals)
        normals[5] = bad
        part = Part(box.positions, box.triangles, normals, box.uvs)
        geometry, diagnoses = assemble([Placed(part, EYE, 0, 0)], ["box"])
        assert np.isfinite(geometry.normals).all()
        assert "normals_made" in [d.code for d in diagnoses]


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (2, 0.5, -3)])
def test_mirrors_and_uneven_scales_keep_the_outside_out(scale: tuple[float, ...]) -> None:
    part = shapes.make(shapes.Sphere(shape="sphere", radius=1, rings=24))
    matrix = np.diag([*scale, 1.0])
    matrix[:3, 3] = [5, 6, 7]
    geometry, _ = assemble([Placed(part, matrix, 0, 0)], ["ball"])
    outward = geometry.positions - matrix[:3, 3]
    # The ellipsoid x² / a² + ... = 1 has its normal along (x / a², ...).
    true = outward / np.square(scale)
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    assert np.allclose(geometry.normals, true, atol=1e-5)
    centres = geometry.positions[geometry.triangles].mean(axis=1) - matrix[:3, 3]
    assert np.sum(facets(geometry) * centres, axis=1).min() > 0


def test_triangles_without_area_are_counted_and_left_out() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [1, 0, 0]], float)
    part = Part(points, np.array([[0, 1, 2], [0, 1, 3], [1, 1, 2], [1, 4, 2]]))
    geometry, diagnoses = assemble([Placed(part, EYE, 0, 0)], ["thing"])
    assert len(geometry.triangles) == 1
    found = {d.code: d for d in diagnoses}["degenerate_triangles"]
    assert found.size == 3
    assert "thing" in found.message


def test_nothing_left_is_an_error() -> None:
    flat = Part(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    with pytest.raises(SceneError, match=r"'dot'.*zero area"):
        assemble([Placed(flat, EYE, 0, 0)], ["dot"])
    none = Part(np.zeros((0, 3)), np.zeros((0, 3), int))
    with pytest.raises(SceneError, match=r"'void'.*no triangles"):
        assemble([Placed(none, EYE, 0, 0)], ["void"])
    far = shapes.make(shapes.Box(shape="box"))
    with pytest.raises(SceneError, match="metres"):
        assemble([Placed(far, np.diag([1e12, 1, 1, 1]), 0, 0)], ["far"])


def test_a_transform_places_an_object(described: Callable[..., Scene]) -> None:
    thing = {
        "name": "box",
        "mesh": {"shape": "box", "size": [2, 4, 6]},
        "transform": {"translate": [10, 0, 0], "rotate_degrees": [0, 90, 0], "scale": 0.5},
    }
    scene = described(objects=[thing])
    low, high = scene.geometry.positions.min(axis=0), scene.geometry.positions.max(axis=0)
    assert np.allclose(high - low, [3, 2, 1], atol=1e-5)
    assert np.allclose((high + low) / 2, [10, 0, 0], atol=1e-5)
