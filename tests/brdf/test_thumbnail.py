"""Small pictures of materials."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.table import MODELS
from engine.brdf.thumbnail import SIZE, thumbnail
from engine.brdf.ward import Ward


def test_a_matt_ball_has_its_colour_and_is_lit_from_above() -> None:
    image = thumbnail(Diffuse(diffuse=(0.5, 0.1, 0.1))).astype(float)
    assert image.shape == (SIZE, SIZE, 3)
    inside = image.max(axis=2) > 0
    # A disc that touches the edges: no light is all that there is.
    assert inside.mean() == pytest.approx(np.pi / 4, abs=0.02)
    assert inside[:, SIZE // 2].all()
    red, green, blue = image[inside].mean(axis=0)
    assert red > 1.5 * green
    assert green == blue
    upper, lower = image[: SIZE // 2], image[SIZE // 2 :]
    assert upper.mean() > 1.3 * lower.mean()


def test_a_grain_runs_around() -> None:
    """A highlight is longest across the grain, wherever that runs."""
    round_, along = (
        thumbnail(Ward(diffuse=(0, 0, 0), roughness=u, roughness_v=v)).astype(float)[..., 0]
        for u, v in ((0.15, 0.15), (0.5, 0.05))
    )

    def widths(image: np.ndarray) -> tuple[int, int]:
        bright = image > 0.6 * image.max()
        return int(bright.any(axis=0).sum()), int(bright.any(axis=1).sum())

    assert widths(along)[0] > 1.5 * widths(along)[1]
    assert widths(along)[0] / widths(along)[1] > 1.3 * widths(round_)[0] / widths(round_)[1]


@pytest.mark.parametrize("model", MODELS)
def test_every_model_has_one_of_any_size(model: type[Material]) -> None:
    image = thumbnail(model(), 24)
    assert image.shape == (24, 24, 3)
    assert image[12, 12].max() > 20
