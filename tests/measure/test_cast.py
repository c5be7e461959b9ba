"""The reference of `wavelet_brdf`: a closed form, the method itself, and where a grain runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.diffuse import Diffuse
from engine.brdf.ward import Ward
from engine.errors import InputError
from engine.light.disk import DiskLight
from engine.measure.cast import cast, per_vertex
from engine.measure.code_stage import KEY, away, lit, terrain
from engine.measure.edges import scene_edges
from engine.measure.metrics import relative_l2
from engine.measure.stage import ball, knot
from engine.methods import prepare
from engine.methods.wavelet_brdf import Settings
from engine.scene.edits import Edits
from engine.store import Store

DARK = (0.0, 0.0, 0.0)
MATT = Diffuse(emission=DARK, diffuse=(0.5, 0.25, 0.125))
BRUSHED = Ward(emission=DARK, roughness=0.5, roughness_v=0.2)


def test_a_matt_ball_is_what_the_formula_says() -> None:
    """ρ / π I cos θ / r² at the pixel in the middle, without shadows of its own."""
    scene = lit(ball(96), MATT, (31, 31))
    image = cast(scene)
    eye, middle = np.array(scene.camera.position), np.array([0, 0.51, 0])
    way = (eye - middle) / np.linalg.norm(eye - middle)
    to_light = np.array(KEY.position) - (middle + 0.5 * way)
    distance = np.linalg.norm(to_light)
    expected = np.array(MATT.diffuse) / np.pi * 9 * (way @ to_light) / distance**3
    np.testing.assert_allclose(image[15, 15], expected, rtol=5e-3)
    assert image[0, 0].max() == 0
    # Matt light changes little between vertices.
    off = relative_l2(per_vertex(scene), image, image.max(axis=2) > 0)
    assert off < 0.02


@pytest.mark.parametrize("material", [MATT, BRUSHED], ids=["matt", "brushed"])
def test_the_method_draws_the_same(material: object, tmp_path: Path) -> None:
    """With the grain where it belongs: turned by a right angle it is something else."""
    scene = lit(knot(160, 16), material, (64, 64))  # type: ignore[arg-type]
    settings = Settings(detail="finest")
    product = prepare(scene, "wavelet_brdf", settings, store=Store(tmp_path))
    image, reference = product.relight(Edits()).image, cast(scene)
    mask = (reference.max(axis=2) > 0) & ~scene_edges(scene)
    assert relative_l2(image, reference, mask) < 0.06
    if material is BRUSHED:
        across = Ward(emission=DARK, roughness=0.2, roughness_v=0.5)
        other = cast(lit(knot(160, 16), across, (64, 64)))
        assert relative_l2(image, other, mask) > 0.2


def test_more_rays_are_smoother() -> None:
    scene = away(lit(ball(24), BRUSHED, (16, 16)), 24.0, 9.0)
    one, many = cast(scene), cast(scene, 4)
    assert ((many > 0) & (one == 0)).any()
    assert many.mean() == pytest.approx(one.mean(), rel=0.2)


def test_only_points_are_lights() -> None:
    scene = lit(ball(8), MATT, (8, 8))
    lamp = DiskLight(
        id="lamp", position=(1, 2, 1), target=(0, 0, 0), radius=0.2, intensity=(1, 1, 1)
    )
    with pytest.raises(InputError, match="point lights alone"):
        cast(replace(scene, lights=(lamp,)))


def test_the_terrain_faces_up() -> None:
    part = terrain(20).part
    assert len(part.triangles) == 2 * 20 * 20
    a, b, c = (part.positions[part.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    assert (across[:, 1] > 0).all()
    assert part.normals is not None
    facing = np.einsum("ij,ij->i", across, part.normals[part.triangles[:, 0]])
    assert (facing > 0).all()
    assert len(terrain().part.triangles) == 45_000
