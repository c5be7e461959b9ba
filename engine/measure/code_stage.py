"""Objects that lamps shine on, for the tables and figures of `wavelet_brdf`.

Claustres, Barthe, Paulin 2007, §6.3: one point light, nothing behind the object.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.brdf.base import Material
from engine.brdf.built_in import BUILT_IN
from engine.brdf.measured import Measured
from engine.light.point import PointLight
from engine.measure.stage import Thing, knot, stage
from engine.scene.part import Part, grid_triangles
from engine.scene.scene import Scene

METHOD = "wavelet_brdf"
DARK = (0.0, 0.0, 0.0)
BRDF_FILES = (".brdf", ".binary", ".csv")
KEY = PointLight(id="key", position=(1.3, 2.1, 1.5), intensity=(9.0, 9.0, 9.0))
CUTS = 150  # of the terrain along a side: 45 K triangles, as the paper's


def measured_by_name(names: list[str]) -> dict[str, Measured]:
    """Materials of files and built-in ones, by their names; without names the built-in ones."""
    return {Path(n).stem: measured(n) for n in names or list(BUILT_IN)}


def small_knot() -> Thing:
    """A knot of 11 K triangles, as many as the paper's fabric has."""
    return knot(172, 32)


def measured(name: str) -> Measured:
    """The material of a file or a built-in one."""
    return Measured(emission=DARK, file=name).located(Path())


def is_material(name: str) -> bool:
    """Whether a word of the command line names a measured material."""
    return name in BUILT_IN or Path(name).suffix.lower() in BRDF_FILES


def lit(thing: Thing, material: Material, size: tuple[int, int]) -> Scene:
    """An object of a material, alone, before black, under one point light."""
    scene = stage(thing, material, size, cuts=None)
    return replace(scene, lights=(KEY,), environment=None)


def away(scene: Scene, diagonals: float, zoom: float = 1.0) -> Scene:
    """The scene from so many of its diagonals away, of the picture the middle, so much larger."""
    camera = scene.camera
    target = np.array(camera.target)
    way = np.array(camera.position) - target
    way *= diagonals * scene.diagonal / np.linalg.norm(way)
    half = np.tan(np.radians(camera.fov_y_degrees) / 2) / zoom
    update = {
        "position": tuple((target + way).tolist()),
        "fov_y_degrees": float(2 * np.degrees(np.arctan(half))),
    }
    return scene.with_camera(camera.model_copy(update=update))


def terrain(cuts: int = CUTS, seed: int = 5) -> Thing:
    """Hills: a height field of cuts² squares, sums of waves of one octave after another."""
    x, z = np.meshgrid(*[np.linspace(-0.5, 0.5, cuts + 1)] * 2)
    rng, height = np.random.default_rng(seed), np.zeros_like(x)
    slope = np.zeros((2, *x.shape))
    for octave in range(5):
        for _ in range(4):
            angle, phase = rng.uniform(0, 2 * np.pi, 2)
            wave = 2 * np.pi * 1.5 * 2**octave * np.array([np.cos(angle), np.sin(angle)])
            size = 0.03 * 0.45**octave
            argument = wave[0] * x + wave[1] * z + phase
            height += size * np.sin(argument)
            slope += size * np.cos(argument) * wave[:, None, None]
    normals = np.stack([-slope[0], np.ones_like(x), -slope[1]], axis=-1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    positions = np.stack([x, height, z], axis=-1).reshape(-1, 3)
    uvs = np.stack([x + 0.5, 0.5 - z], axis=-1).reshape(-1, 2)
    # Seen from above, z runs down where the grid's rows run up.
    triangles = grid_triangles(cuts, cuts)[:, ::-1]
    return Thing("terrain", Part(positions, triangles, normals, uvs))
