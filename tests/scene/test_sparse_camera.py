"""A camera of every n-th pixel sees what the whole picture shows there."""

from __future__ import annotations

import numpy as np
import pytest

from engine.measure.edges import pixels_that_count
from engine.scene.camera import Camera, SparseCamera, sparse
from engine.scene.edits import edited_camera
from engine.scene.open import open_scene

WHOLE = Camera(position=(1, 2, 3), target=(0, 0.5, 0), fov_y_degrees=50, width=31, height=20)


@pytest.mark.parametrize("stride", [2, 3, 5])
def test_its_pixels_are_those_of_the_whole(stride: int) -> None:
    few = sparse(WHOLE, stride)
    assert (few.height, few.width) == WHOLE.shape(stride)
    y, x = np.mgrid[0 : few.height, 0 : few.width].reshape(2, -1)
    rng = np.random.default_rng(1)
    dx, dy = rng.random((2, len(x)))  # somewhere within the pixels
    expected = WHOLE.directions(stride * x + dx, stride * y + dy)
    np.testing.assert_allclose(few.directions(x + dx, y + dy), expected, atol=1e-7)
    assert few.spread == WHOLE.spread


def test_places_in_its_picture_are_found_from_directions() -> None:
    few = sparse(WHOLE, 3)
    y, x = np.mgrid[0 : few.height, 0 : few.width].reshape(2, -1)
    found = few.directions(x + 0.5, y + 0.5).astype(np.float64) @ few.to_pixels().T
    np.testing.assert_allclose(found[:, 0] / found[:, 2], x, atol=1e-4)
    np.testing.assert_allclose(found[:, 1] / found[:, 2], y, atol=1e-4)


def test_it_stays_sparse_where_it_is_moved() -> None:
    moved = edited_camera(sparse(WHOLE, 3), {"position": (0, 2, 4)})
    assert isinstance(moved, SparseCamera)
    assert moved.whole == WHOLE.model_copy(update={"position": (0, 2, 4)})


def test_every_pixel_is_one_of_a_step_of_one() -> None:
    assert sparse(WHOLE, 1) is WHOLE


def test_the_pixels_that_count_are_those_of_the_whole() -> None:
    """Among few pixels there are no more by an edge than among all of them."""
    scene = open_scene("knot")
    scene = scene.with_camera(edited_camera(scene.camera, {"width": 96, "height": 72}))
    few = scene.with_camera(sparse(scene.camera, 3))
    np.testing.assert_array_equal(pixels_that_count(few), pixels_that_count(scene)[::3, ::3])
