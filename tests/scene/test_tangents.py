"""Tangents follow the texture, and brushed materials follow the tangents."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from engine.brdf import evaluate
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import GRAIN
from engine.brdf.table import INDEX
from engine.numerics.frames import tangents, to_local
from engine.scene import shapes
from engine.scene.scene import Scene
from engine.scene.tangents import grain, vertex_tangents

BRUSHED = {"type": "ashikhmin_shirley", "exponent_u": 3, "exponent_v": 300}


def of_shape(**shape: Any) -> tuple[shapes.Part, np.ndarray]:
    part = shapes.make(TypeAdapter(shapes.AnyShape).validate_python(shape))
    assert part.normals is not None
    assert part.uvs is not None
    return part, vertex_tangents(part.positions, part.triangles, part.normals, part.uvs)


@pytest.mark.parametrize(
    "shape", ["rectangle", "box", "sphere", "disk", "cylinder", "torus_knot", "teapot"]
)
def test_unit_and_perpendicular(shape: str) -> None:
    part, found = of_shape(shape=shape)
    used = np.unique(part.triangles)
    np.testing.assert_allclose(np.linalg.norm(found[used], axis=1), 1, atol=1e-6)
    assert part.normals is not None
    np.testing.assert_allclose(np.einsum("ij,ij->i", found, part.normals), 0, atol=1e-6)


def test_along_the_first_coordinate() -> None:
    _, flat = of_shape(shape="rectangle", size=[3, 1])
    np.testing.assert_allclose(np.abs(flat), np.tile([1, 0, 0], (4, 1)), atol=1e-6)
    # Round a sphere, along its parallels; at the poles any will do.
    part, round_ = of_shape(shape="sphere", rings=64)
    between = np.abs(part.positions[:, 1]) < 0.49
    assert np.abs(round_[between, 1]).max() < 0.03


def test_mirrored_coordinates_do_not_cancel() -> None:
    """A leaf unfolded over a mirrored texture has one grain, the middle of it too."""
    x, y = np.meshgrid([-1.0, 0.0, 1.0], [0.0, 1.0])
    positions = np.stack([x.ravel(), y.ravel(), np.zeros(6)], axis=1)
    triangles = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    uvs = np.stack([np.abs(x.ravel()), y.ravel()], axis=1)
    normals = np.tile([0.0, 0, 1], (6, 1))
    found = vertex_tangents(positions, triangles, normals, uvs)
    np.testing.assert_allclose(np.abs(found), np.tile([1, 0, 0], (6, 1)), atol=1e-6)


@pytest.mark.parametrize("uvs", ["same", "line"])
def test_none_where_the_texture_does_not_say(uvs: str) -> None:
    part, _ = of_shape(shape="rectangle")
    assert part.normals is not None
    flat = np.zeros((4, 2))
    if uvs == "line":
        flat[:] = np.arange(4)[:, None]
    found = vertex_tangents(part.positions, part.triangles, part.normals, flat)
    assert (found == 0).all()


def test_grain_at_a_point(described: Callable[..., Scene], look: Callable[..., Any]) -> None:
    """The row says how the grain lies in the frame of the point, from both sides of the surface."""
    scene = described(
        objects=[
            {
                "name": "plate",
                "mesh": {"shape": "rectangle"},
                "material": "steel",
                "transform": {"rotate_degrees": [-90, 30, 0]},
            }
        ],
        materials={"steel": BRUSHED},
    )
    u = np.array([np.cos(np.radians(30)), 0, -np.sin(np.radians(30))])  # x turned about y
    for side in (1.0, -1.0):
        row = look(scene, [0.1, side, 0.2], [0.0, -side, 0.0]).row
        s, t = tangents((0.0, side, 0.0))
        along = row[GRAIN] * np.array(s) + row[GRAIN + 1] * np.array(t)
        assert abs(along @ u) == pytest.approx(1, abs=1e-6)


def test_no_frame_no_trouble_at_the_singular_normal(described: Callable[..., Scene]) -> None:
    """The local frame spins about (0, -1, 0), §3.3.2; what a brushed surface reflects does not."""
    scene = described(
        objects=[
            {
                "name": "ceiling",
                "mesh": {"shape": "rectangle"},
                "material": "steel",
                "transform": {"rotate_degrees": [90, 0, 0]},
            }
        ],
        materials={"steel": BRUSHED},
    )
    row = AshikhminShirley(exponent_u=3, exponent_v=300).row()
    view, light = np.array([0.5, -0.7, 0.2]), np.array([-0.4, -0.8, 0.1])
    view, light = view / np.linalg.norm(view), light / np.linalg.norm(light)
    values, frames = [], []
    for angle in np.linspace(0, 2 * np.pi, 16, endpoint=False):
        n = np.array([1e-4 * np.cos(angle), -1.0, 1e-4 * np.sin(angle)])
        n = tuple(n / np.linalg.norm(n))
        s, t = tangents(n)
        frames.append(s)
        row[GRAIN:] = grain(scene.geometry, 0, 0.2, 0.3, s, t)
        wi, wo = (to_local(tuple(w), s, t, n) for w in (light, view))
        values.append(evaluate(INDEX[AshikhminShirley], row, wi, wo)[0])
    assert np.min(frames, axis=0)[0] < -0.9  # it does spin
    np.testing.assert_allclose(values, np.tile(np.mean(values, axis=0), (16, 1)), rtol=0.01)


def test_brushed_without_coordinates_is_told_of(
    described: Callable[..., Scene], tmp_path: Any
) -> None:
    (tmp_path / "bare.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = described(
        objects=[{"name": "plate", "mesh": "bare.obj", "material": "steel"}],
        materials={"steel": BRUSHED},
    )
    told = [d.message for d in scene.diagnoses if d.code == "no_tangents"]
    assert len(told) == 1
    assert "'steel'" in told[0]
    box = described(
        objects=[{"name": "box", "mesh": {"shape": "box"}, "material": "steel"}],
        materials={"steel": BRUSHED},
    )
    assert "no_tangents" not in {d.code for d in box.diagnoses}
