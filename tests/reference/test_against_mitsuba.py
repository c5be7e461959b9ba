"""The path tracer against Mitsuba 3 on scenes that both define alike.

Pictures are compared block by block and as a whole, with the variances of both. What is left out,
because the definitions differ: Schlick's Fresnel (so metals have F0 = 1), the penumbra of a spot
(so it has none), environment maps between texels (so they are smooth), and correlated
against separable masking (so facets are smooth enough, α ≤ 0.2, and seen well above the horizon:
the two differ there by less than 0.2 %).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import stats

from engine.images import write_image
from engine.reference import render
from engine.scene.build import build
from engine.scene.edits import edited_camera
from engine.scene.open import describe, open_scene
from engine.scene.scene import Scene

mi = pytest.importorskip("mitsuba")

from engine.measure.mitsuba_scene import differences, mitsuba_scene  # noqa: E402

OUT = Path(__file__).parents[2] / "out" / "reference"
SIZE, BLOCK = 48, 6
BATCHES = 24
FALSE_ALARM = 1e-3  # probability that two right renderers fail one of these tests


def cornell_box() -> tuple[Scene, tuple[float, float, float]]:
    """The lamp alone; the spot has a penumbra."""
    scene = open_scene("cornell-box")
    scene = scene.with_camera(edited_camera(scene.camera, {"width": SIZE, "height": SIZE}))
    white = scene.materials[scene.material_names.index("white")].diffuse
    return scene.with_lights(scene.lights[:1]), white


STILL_LIFE = [
    {
        "name": "floor",
        "mesh": {"shape": "rectangle", "size": [6, 6]},
        "material": "metal",
        "transform": {"rotate_degrees": [-90, 0, 0]},
    },
    {
        "name": "wall",
        "mesh": {"shape": "rectangle", "size": [6, 4]},
        "material": "wall",
        "transform": {"translate": [0, 0.5, -1.5]},
    },
    {
        "name": "ball",
        "mesh": {"shape": "sphere", "radius": 0.5, "rings": 24},
        "material": "ball",
        "transform": {"translate": [-0.6, 0.55, 0]},
    },
    {
        "name": "block",
        "mesh": {"shape": "box", "size": [0.7, 0.7, 0.7]},
        "material": "block",
        "transform": {"translate": [0.6, 0.37, -0.2], "rotate_degrees": [0, 30, 0]},
    },
]


def still_life(roughness: float, **light: object) -> Scene:
    return build(
        describe(
            {
                "camera": {
                    "position": [0.4, 2.6, 3.4],
                    "target": [0, 0.3, 0],
                    "fov_y_degrees": 34,
                    "width": SIZE,
                    "height": SIZE,
                },
                "materials": {
                    "metal": {
                        "type": "ggx",
                        "diffuse": [0, 0, 0],
                        "specular": [1, 1, 1],
                        "roughness": roughness,
                    },
                    "wall": {"type": "diffuse", "diffuse": [0.6, 0.5, 0.3]},
                    "ball": {"type": "diffuse", "diffuse": [0.8, 0.2, 0.2]},
                    "block": {"type": "diffuse", "diffuse": [0.2, 0.4, 0.7]},
                },
                "objects": STILL_LIFE,
                **light,
            }
        ),
        Path(),
    )


def gloss_and_sky() -> tuple[Scene, tuple[float, float, float]]:
    return still_life(0.35, environment={"map": [0.7, 0.9, 1.2]}, lights=[]), (0, 0, 0)


def gloss_and_spot() -> tuple[Scene, tuple[float, float, float]]:
    spot = {
        "id": "spot",
        "type": "spot",
        "position": [1.2, 3.0, 2.0],
        "target": [0.0, 0.2, -0.5],
        "cone_degrees": 24,
        "penumbra_degrees": 0,
        "intensity": [20, 18, 14],
    }
    lamp = {
        "id": "lamp",
        "type": "area",
        "position": [-2.2, 2.0, 1.0],
        "target": [0, 0, 0],
        "width": 0.8,
        "height": 0.5,
        "intensity": [3, 4, 6],
    }
    return still_life(0.447, lights=[spot, lamp]), (0, 0, 0)


def gloss_and_projector() -> tuple[Scene, tuple[float, float, float]]:
    """From the side and tilted, so that an image turned over or mirrored shows."""
    projector = {
        "id": "projector",
        "type": "projector",
        "position": [1.4, 2.2, 2.4],
        "target": [0.0, 0.2, -0.5],
        "up": [0.3, 1, 0],
        "fov_y_degrees": 46,
        "image": "chart",
        "intensity": [14, 18, 24],
    }
    return still_life(0.4, lights=[projector]), (0, 0, 0)


def disk_and_sphere() -> tuple[Scene, tuple[float, float, float]]:
    """Above all surfaces: theirs are solid, and must be in nobody's way."""
    disk = {
        "id": "disk",
        "type": "disk",
        "position": [-2.2, 3.4, 1.0],
        "target": [0, 0, 0],
        "radius": 0.6,
        "intensity": [5, 6, 9],
    }
    ball = {
        "id": "ball",
        "type": "sphere",
        "position": [1.6, 3.2, 0.4],
        "radius": 0.3,
        "intensity": [24, 20, 14],
    }
    return still_life(0.447, lights=[disk, ball]), (0, 0, 0)


def blocks(image: np.ndarray) -> np.ndarray:
    """(..., h, w, 3) -> (..., h / BLOCK, w / BLOCK, 3) means."""
    lead, n = image.shape[:-3], SIZE // BLOCK
    return image.reshape(*lead, n, BLOCK, n, BLOCK, 3).mean(axis=(-4, -2))


def keep(name: str, **pictures: np.ndarray) -> str:
    """Write pictures side by side for a person to look at; returns where."""
    OUT.mkdir(parents=True, exist_ok=True)
    row = np.concatenate([np.clip(p, 0, 1) ** (1 / 2.2) for p in pictures.values()], axis=1)
    path = OUT / f"{name}.png"
    image = Image.fromarray((255 * row).astype(np.uint8))
    image.resize((8 * image.width, 8 * image.height), Image.Resampling.NEAREST).save(path)
    return f"{', '.join(pictures)} in {path.relative_to(OUT.parents[1])}"


@pytest.mark.parametrize(
    ("make", "our_samples", "their_samples"),
    [
        (cornell_box, 1024, 64),
        (gloss_and_sky, 256, 12),
        (gloss_and_spot, 512, 24),
        (gloss_and_projector, 768, 32),
        (disk_and_sphere, 384, 16),
    ],
)
def test_same_picture(make, our_samples, their_samples, tmp_path):
    scene, lamp_albedo = make()
    compare(make.__name__, scene, lamp_albedo, our_samples, their_samples, tmp_path)


def test_same_textures(tmp_path):
    """An image with another colour in each corner lies the same way round."""
    corners = np.array([[[255, 60, 60], [60, 255, 60]], [[60, 60, 255], [255, 255, 60]]], np.uint8)
    Image.fromarray(corners.repeat(32, axis=0).repeat(32, axis=1)).save(tmp_path / "corners.png")
    scene = build(
        describe(
            {
                "camera": {"position": [0, 0, 1.3], "target": [0, 0, 0], "fov_y_degrees": 40}
                | {"width": SIZE, "height": SIZE},
                "environment": {"map": [1, 1, 1]},
                "lights": [],
                "materials": {
                    "m": {
                        "type": "diffuse",
                        "diffuse": {"texture": "corners.png", "factor": [0.9, 0.8, 0.7]},
                    }
                },
                "objects": [
                    {
                        "name": "wall",
                        "mesh": {"shape": "rectangle", "size": [2, 2]},
                        "material": "m",
                        "transform": {"rotate_degrees": [20, 30, 0]},
                    }
                ],
            }
        ),
        tmp_path,
    )
    compare("textures", scene, (0, 0, 0), 256, 8, tmp_path)


def test_same_normal_maps(tmp_path):
    """Waves that run another way in x than in y, on a turned wall and a ball seen from the front.

    At a rim they differ: normals that face away from the eye are bent back here, and black there.
    """
    y, x = np.mgrid[0:64, 0:64] / 64 * 2 * np.pi
    slope = np.stack([0.5 * np.cos(x), 0.3 * np.sin(2 * y), np.ones_like(x)], axis=-1)
    normal = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
    Image.fromarray(np.round(255 * (normal + 1) / 2).astype(np.uint8)).save(tmp_path / "waves.png")
    waves = {"normal": {"texture": "waves.png"}}
    ball = {"shape": "sphere", "radius": 3, "rings": 96}
    scene = build(
        describe(
            {
                "camera": {"position": [0, 0, 2.6], "target": [0, 0, 0], "fov_y_degrees": 40}
                | {"width": SIZE, "height": SIZE},
                "environment": {"map": [0.2, 0.3, 0.4]},
                "lights": [
                    {"id": "a", "type": "point", "position": [1, 2, 2], "intensity": [6, 3, 2]},
                    {"id": "b", "type": "distant", "direction": [1, -0.3, -1]},
                ],
                "materials": {"m": {"type": "diffuse", "diffuse": [0.8, 0.7, 0.6], **waves}},
                "objects": [
                    {
                        "name": "wall",
                        "mesh": {"shape": "rectangle", "size": [0.8, 0.8]},
                        "material": "m",
                        "transform": {"translate": [0.3, 0.2, 0.2], "rotate_degrees": [10, 15, 40]},
                    },
                    {
                        "name": "ball",
                        "mesh": ball,
                        "material": "m",
                        "transform": {"translate": [0, 0, -3.5], "rotate_degrees": [0, 0, 30]},
                    },
                ],
            }
        ),
        tmp_path,
    )
    compare("normal_maps", scene, (0, 0, 0), 512, 24, tmp_path)


def test_same_environment_maps(tmp_path):
    """A smooth map of which every side is another one, turned by an odd angle."""
    y, x = np.mgrid[0:64, 0:128]
    theta, phi = np.pi * (y + 0.5) / 64, 2 * np.pi * (x + 0.5) / 128
    lobes = [1.3 + np.sin(phi - shift) * np.sin(theta) + 0.3 * np.cos(theta) for shift in range(3)]
    write_image(tmp_path / "map.exr", (0.5 * np.stack(lobes, axis=-1)).astype(np.float32))
    environment = {"map": str(tmp_path / "map.exr"), "rotation_degrees": 70, "intensity": 1.5}
    scene = still_life(0.4, environment=environment, lights=[])
    compare("environment_maps", scene, (0, 0, 0), 512, 24, tmp_path)


def compare(name, scene, lamp_albedo, our_samples, their_samples, tmp_path):
    assert all("is solid" in known for known in differences(scene)), "the lamp's albedo is given"
    ours = render(scene, samples=our_samples, seed=3)
    mi.set_variant("scalar_rgb")  # the one that needs no LLVM
    twin = mitsuba_scene(scene, tmp_path, lamp_albedo=lamp_albedo)
    each = np.array(
        [mi.render(twin, spp=their_samples, seed=1 + k) for k in range(BATCHES)], np.float64
    )
    theirs = each.mean(axis=0)

    # Welch's test, block by block and channel by channel: ours knows its variance from a thousand
    # samples, theirs from BATCHES pictures.
    our_variance = blocks(ours.variance.astype(np.float64)) / BLOCK**2
    their_variance = blocks(each).var(axis=0, ddof=1) / BATCHES
    variance = our_variance + their_variance
    difference = blocks(ours.image) - blocks(theirs)
    freedom = (BATCHES - 1) * (variance / their_variance) ** 2
    p = 2 * stats.t.sf(np.abs(difference) / np.sqrt(variance), freedom)
    sidak = 1 - (1 - FALSE_ALARM) ** (1 / p.size)

    # The whole picture, where a wrong factor shows. The three channels of a sample go together, so
    # their errors are taken to add up in full.
    our_error = np.sqrt(np.square(np.sqrt(ours.variance).mean(axis=2)).sum()) / SIZE**2
    their_totals = each.mean(axis=(1, 2, 3))
    error = np.hypot(our_error, their_totals.std(ddof=1) / np.sqrt(BATCHES)) / ours.image.mean()
    bias = ours.image.mean() / their_totals.mean() - 1
    where = keep(
        name,
        ours=ours.image,
        theirs=theirs,
        z=np.kron(np.abs(difference) / np.sqrt(variance) / 8, np.ones((BLOCK, BLOCK, 1))),
    )
    assert p.min() > sidak, f"a block differs with p = {p.min():.2g}: {where}"
    assert abs(bias) < 4 * error, f"{100 * bias:.2f} % of light too much: {where}"
    assert error < 3e-3, "too noisy to see a wrong factor"
