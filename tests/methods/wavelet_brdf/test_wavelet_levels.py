"""The level of detail of each pixel, §5.4.1: by distance as the formula says, or by footprint."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from brdf.materials import hemisphere
from methods.scenes import camera
from methods.wavelet_brdf.measured_scenes import (
    LAMP,
    ball,
    inner,
    measured,
    off,
    plane,
    table,
    write_terrain,
)
from numpy.typing import NDArray

from engine.brdf import evaluate
from engine.brdf.measured import LEVEL, Measured
from engine.brdf.table import INDEX
from engine.methods.wavelet_brdf import Wavelets
from engine.methods.wavelet_brdf.levels import COLOURS
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene

Make = Callable[..., Wavelets]
LEVELS = {"plastic": 3, "brushed": 2}  # N of a code of 8 cells
BLUE, RED = COLOURS[0], COLOURS[-1]
pytestmark = pytest.mark.usefixtures("small_codes")


def levels_of(product: Wavelets, edits: Edits = Edits()) -> NDArray[np.float32]:  # noqa: B008
    """(height, width) of the pixels that one surface fills; NaN elsewhere."""
    product.relight(edits)
    mask = inner(product)
    level = product._seen.view.buffer.centre.row[:, LEVEL].reshape(mask.shape)  # type: ignore[union-attr]
    return np.where(mask, level, np.nan)


@pytest.mark.parametrize("file", LEVELS)
@pytest.mark.parametrize("alpha", [0.0, 0.15, 6.0, 1000.0])
def test_by_distance(make: Make, file: str, alpha: float) -> None:
    """l = clamp(log2(α d), 0, N - 1), d from the eye to each pixel's surface in diagonals."""
    scene = plane(measured(file))
    product = make(scene, detail="distance", alpha=alpha)
    level = levels_of(product)
    away = np.linalg.norm(
        product._seen.view.buffer.centre.position - np.array(scene.camera.position),  # type: ignore[union-attr]
        axis=1,
    ).reshape(level.shape)
    expected = np.log2(np.maximum(1, alpha * away / scene.diagonal))
    np.testing.assert_allclose(level, np.clip(expected, 0, LEVELS[file] - 1), atol=1e-5)
    if alpha == 6:
        assert 0 < level.min() < level.max() < LEVELS[file] - 1


def test_by_distance_from_a_camera_that_moves(make: Make) -> None:
    """Twice as far, one level more, until the coarsest."""
    product = make(ball(measured()), detail="distance", alpha=4)
    found = [
        np.nanmedian(levels_of(product, Edits(camera={"position": [0, 0, d], "fov_y_degrees": f})))
        for d, f in ((1.5, 50), (3, 24), (6, 12), (12, 6), (24, 3))
    ]
    assert found == pytest.approx([1.3, 2, 2, 2, 2], abs=0.4)
    assert found == sorted(found)


def test_by_footprint_a_flat_wall_has_the_finest(make: Make) -> None:
    """From near or far, head-on or aslant: from pixel to pixel nothing turns."""
    product = make(plane(measured()), detail="footprint")
    for position, fov in (([0.3, 0.2, 2], 40), ([0, -1.5, 0.3], 40), ([0, 0, 300], 1)):
        looks = {"position": position, "fov_y_degrees": fov}
        assert np.nanmax(levels_of(product, Edits(camera=looks))) == 0


def test_by_footprint_a_ball_has_more_the_fewer_pixels_it_fills(make: Make) -> None:
    """Half the pixels, twice the turn, a level more; towards the rim coarser."""
    product = make(ball(measured()), detail="footprint", cells=32)
    for n in (40, 28):
        level = levels_of(product, Edits(camera={"width": n, "height": n}))
        # A pixel is so wide in the middle, which is nearer by the radius.
        wide = 2 * np.tan(np.radians(17)) / n * (np.hypot(2, 0.4) - 0.5)
        expected = np.log2(2 * wide / 0.5 / np.sqrt(3) / (np.pi / 64))
        middle = np.nanmean(level[n // 2 - 2 : n // 2 + 2, n // 2 - 2 : n // 2 + 2])
        assert middle == pytest.approx(expected, abs=0.1)
        assert np.nanmax(level) > middle + 0.3


# Lamp, pixels: against pictures of 12 times as many, by footprint and at the finest, measured.
BLURRED = [
    ([-0.3, -0.4, -1], 12, 0.049, 0.325),
    ([-0.3, -0.4, -1], 24, 0.040, 0.071),
    ([-1, -0.4, 0.2], 24, 0.122, 0.032),
]


@pytest.mark.parametrize(("away", "size", "footprint", "finest"), BLURRED)
def test_by_footprint_a_ball_is_as_blurred_as_the_mean_over_a_pixel(
    make: Make, away: list[float], size: int, footprint: float, finest: float
) -> None:
    """With the lamp behind the eye seven times nearer to the truth than a point in each pixel.

    A highlight near the rim is blurred too much: there normals turn fast one way and slowly the
    other, and what is blurred is both.
    """
    sun = {"id": "sun", "type": "distant", "direction": away, "intensity": [3, 3, 3]}
    scene = ball(measured(), size, lights=[sun])
    fine = make(scene, cells=32).relight(Edits(camera={"width": 12 * size, "height": 12 * size}))
    truth = fine.image.reshape(size, 12, size, 12, 3).mean(axis=(1, 3))
    for detail, error in (("footprint", footprint), ("finest", finest)):
        picture = make(scene, cells=32, detail=detail).relight(Edits()).image
        assert off(picture, truth) == pytest.approx(error, rel=0.1)


def terrain(folder: Path, detail: float, size: int = 32) -> Scene:
    """A bumpy terrain from afar, whose triangles are so many times as large as a pixel."""
    path = write_terrain(folder / "terrain.obj", round(size / detail), 0.6)
    return build(
        describe(
            {
                "camera": camera(size, position=[0, 0, 40], fov_y_degrees=5),
                "lights": [LAMP],
                "materials": {"ground": measured()},
                "objects": [{"name": "ground", "mesh": path.name, "material": "ground"}],
            }
        ),
        folder,
    )


def test_by_footprint_fine_bumps_have_the_coarsest(make: Make, tmp_path: Path) -> None:
    """As if all of a pixel's facets turned as much as those of its neighbours do."""
    level = levels_of(make(terrain(tmp_path, 0.25), detail="footprint"))
    assert np.nanmedian(level) == LEVELS["plastic"] - 1
    assert np.nanmean(level) > 0.95 * (LEVELS["plastic"] - 1)


def test_show_levels(make: Make) -> None:
    """Blue where all is shown, red at the coarsest, black without a code or a surface."""
    scene = table(measured(), {"type": "diffuse"}, lights=[])
    near, far = (
        make(scene, detail="distance", show="levels", alpha=alpha).relight(Edits()).image
        for alpha in (0, 1000)
    )
    assert set(map(tuple, near.reshape(-1, 3))) == {tuple(BLUE.astype(np.float32)), (0, 0, 0)}
    assert set(map(tuple, far.reshape(-1, 3))) == {tuple(RED.astype(np.float32)), (0, 0, 0)}
    assert (near[0] == 0).all()
    middle = make(scene, detail="distance", show="levels", alpha=3).relight(Edits()).image
    assert len(np.unique(middle.reshape(-1, 3), axis=0)) > 100


def test_levels_blend() -> None:
    """A broken level lies on the straight line between its two neighbours; coarsest is the end."""
    row = Measured(file="threads").row()
    rng = np.random.default_rng(3)
    wi, wo = hemisphere(rng, 500), hemisphere(rng, 500)

    def at(level: float) -> NDArray[np.float64]:
        row[LEVEL] = level
        return evaluate(INDEX[Measured], row, wi, wo)

    assert off(at(1), at(0)) > 0.05
    np.testing.assert_allclose(at(0.25), 0.75 * at(0) + 0.25 * at(1), rtol=1e-5)
    assert (at(7) == at(1)).all()


def test_scales_are_pictures_of_their_own(make: Make) -> None:
    """Of every second pixel, with levels as they are there."""
    product = make(ball(measured(), size=33), detail="distance", alpha=2)
    whole, half = (product.relight(Edits(), scale).image for scale in (1, 2))
    assert half.shape == (17, 17, 3)
    product.relight(Edits(), 1)
    mask = inner(product)[::2, ::2]
    product.relight(Edits(), 2)
    both = mask & inner(product)
    assert both.sum() > 50
    np.testing.assert_allclose(whole[::2, ::2][both], half[both], rtol=1e-3)
