"""Where `glossy_prt` fails: sharp lobes, tiny suns, small turns, odd frames, meshes and skies."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.scenes import camera, rectangle, scene
from numpy.typing import NDArray

from engine.images import write_image
from engine.methods import prepare
from engine.methods.glossy_prt import Prt, Settings
from engine.numerics.wavelet_vectors import white_light
from engine.reference import render
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene
from engine.store import Store

Make = Callable[..., Prt]
GREY = {"type": "diffuse", "diffuse": [0.5, 0.5, 0.5]}


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """make(scene, **settings): its product, in a store of this module's own."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(of: Scene, **settings: Any) -> Prt:
        fields = {"light_texels": 32, "visibility_texels": 64, "bounces": 0, **settings}
        return prepare(of, "glossy_prt", Settings(**fields), store=store)  # type: ignore[return-value]

    return product


def ball(material: dict[str, Any], folder: Path = Path(), size: int = 24, **fields: Any) -> Scene:
    """A ball alone, filling the picture."""
    return scene(
        **{
            "camera": camera(size, position=[0, 0, 2], fov_y_degrees=24),
            "environment": {"map": [1, 1, 1]},
            "materials": {"ball": material},
            "objects": [
                {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 24},
                 "material": "ball"},
            ],
            **fields,
        }
    )  # fmt: skip


def phong(exponent: float) -> dict[str, Any]:
    return {"type": "phong", "diffuse": [0.2] * 3, "specular": [0.5] * 3, "exponent": exponent}


def sky(**fields: Any) -> Edits:
    return Edits(environment=fields)


def off(found: NDArray, true: NDArray) -> float:
    return float(np.linalg.norm(found - true) / np.linalg.norm(true))


@pytest.mark.parametrize(("exponent", "energy"), [(5, 0.05), (50, 0.15), (1000, 0.5)])
def test_sharp_lobes_keep_little_of_themselves_in_four_terms(
    make: Make, exponent: float, energy: float
) -> None:
    """Never negative; under an even sky the picture loses no more than this of its light."""
    made = ball(phong(exponent))
    even = make(made).relight(Edits()).image
    true = render(made, samples=64, max_bounces=1).image
    assert even.min() >= 0
    assert abs(even.sum() / true.sum() - 1) < energy
    hard = make(made).relight(sky(map="studio")).image
    assert hard.min() >= 0
    assert np.isfinite(hard).all()


def scene_in(folder: Path, map_: str) -> Scene:
    """The ball under a map of a folder."""
    document = {
        "camera": camera(24, position=[0, 0, 2], fov_y_degrees=24),
        "environment": {"map": map_},
        "lights": [],
        "materials": {"ball": GREY},
        "objects": [
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 24},
             "material": "ball"},
        ],
    }  # fmt: skip
    return build(describe(document), folder)


def test_small_turns_do_not_flicker(make: Make) -> None:
    """A turn by a tenth of a texel changes the picture by less than one of a whole texel."""
    product = make(ball(phong(20)))
    texel = 90 / 32

    def frames(step: float) -> list[NDArray]:
        return [
            product.relight(sky(map="studio", rotation_degrees=30 + k * step)).image
            for k in range(12)
        ]

    small = [off(b, a) for a, b in pairwise(frames(texel / 10))]
    large = [off(b, a) for a, b in pairwise(frames(texel))]
    assert max(small) < 0.3 * max(large)
    # No step stands out from its neighbours.
    assert max(small) < 4 * np.median(small) + 1e-4


def test_the_one_normal_without_a_tangent(make: Make) -> None:
    """Seen from below, the pole of the ball shows no star: frames are not mixed across it."""
    under = camera(33, position=[0, -2, 0.01], fov_y_degrees=8)
    made = ball(phong(10), camera=under)
    product = make(made, light_texels=64, visibility_texels=64, cluster_error=0)
    found = product.relight(sky(map="studio")).image
    middle = found[10:23, 10:23].mean(axis=2)
    jolt = np.abs(middle[2:] - 2 * middle[1:-1] + middle[:-2]).max()
    assert jolt < 0.1 * middle.max()


def test_vertices_inside_the_floor_are_black_and_harm_nobody(make: Make) -> None:
    floor = rectangle("floor", [3, 3], [0, -0.3, 0], [-90, 0, 0])
    floor["mesh"]["segments"] = [24, 24]
    made = ball(
        GREY,
        camera=camera(24, position=[0, 1, 2.5], target=[0, -0.2, 0]),
        objects=[
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 24},
             "material": "ball"},
            {**floor, "material": "ball"},
        ],
    )  # fmt: skip
    product = make(made, bounces=1)
    black = ~product.multiply(white_light(64)[:, None] * np.ones(3, np.float32)).any(axis=1)
    assert black.any()
    image = product.relight(Edits()).image
    assert np.isfinite(image).all()
    assert image.min() >= 0


@pytest.mark.parametrize("bad", ["degenerate", "flipped", "unused", "non-manifold"])
def test_odd_meshes(make: Make, tmp_path: Path, bad: str) -> None:
    """A picture without NaN, whatever the mesh."""
    corners = [(-1, 0, 0), (1, 0, 0), (0, 1.5, 0), (0, 0, 1), (0, 0, -1)]
    faces = {
        "degenerate": [(1, 2, 3), (1, 1, 3), (2, 3, 4)],
        "flipped": [(1, 2, 3), (1, 2, 4)],
        "unused": [(1, 2, 3)],
        "non-manifold": [(1, 2, 3), (1, 2, 4), (2, 1, 5), (1, 2, 5)],
    }[bad]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "mesh.obj").write_text("\n".join(lines))
    document = {
        "camera": camera(16, position=[0, 1, 4]),
        "environment": {"map": "studio"},
        "lights": [],
        "materials": {"grey": GREY},
        "objects": [{"name": "mesh", "mesh": "mesh.obj", "material": "grey"}],
    }
    image = make(build(describe(document), tmp_path), bounces=1).relight(Edits()).image
    assert np.isfinite(image).all()
    assert image.max() > 0


def test_a_range_of_a_million_to_one(make: Make, tmp_path: Path) -> None:
    image = np.full((64, 128, 3), 1e-3, np.float32)
    image[20, 30] = 1e3
    write_image(tmp_path / "wide.exr", image)
    found = make(scene_in(tmp_path, "wide.exr")).relight(Edits()).image
    assert np.isfinite(found).all()
    assert found.min() >= 0


@pytest.mark.sweep
def test_coarse_gather_maps_make_bands(make: Make) -> None:
    """The paper's figure 11: fewer texels for a bounce, more banding; measured against 64."""
    floor = rectangle("floor", [3, 3], [0, -0.51, 0], [-90, 0, 0])
    floor["mesh"]["segments"] = [24, 24]
    made = ball(
        GREY,
        camera=camera(32, position=[0, 0.6, 2.2], target=[0, -0.2, 0]),
        environment={"map": "studio"},
        objects=[
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 24},
             "material": "ball"},
            {**floor, "material": "ball"},
        ],
    )  # fmt: skip
    images = {
        texels: make(made, bounces=1, gather_texels=texels).relight(Edits()).image
        for texels in (4, 8, 16, 32, 64)
    }
    errors = [off(images[texels], images[64]) for texels in (4, 8, 16, 32)]
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[3] < 0.005


@pytest.mark.sweep
def test_borders_of_clusters_fade_with_their_error(make: Make) -> None:
    """Neighbouring clusters leave out different things, which a hard light shows."""
    made, lamp = ball(phong(10), size=48), sky(map="studio", rotation_degrees=60)
    exact = make(made, cluster_error=0.0, coefficients=1024).relight(lamp).image
    errors = [
        off(make(made, cluster_error=e).relight(lamp).image, exact) for e in (0.2, 0.05, 0.01)
    ]
    assert errors[0] > 1.5 * errors[1] > 2 * errors[2]
    assert errors[1] < 0.02
    assert errors[2] < 0.005
