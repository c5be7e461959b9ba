"""Small scenes of measured materials, and a code that no built-in material has."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from brdf.wavelet.sources import ASKEW
from methods.scenes import camera, rectangle, scene
from numpy.typing import NDArray

from engine.brdf.acquisition import Report
from engine.brdf.acquisition.report import Energy
from engine.brdf.measured import Measured
from engine.methods.wavelet_brdf import Wavelets
from engine.scene.scene import Scene
from engine.scene.tables import changed_table

LAMP: dict[str, Any] = {
    "id": "lamp", "type": "point", "position": [0.8, 1.0, 1.6], "intensity": [4, 3, 2],
}  # fmt: skip
GENERAL = "general"


def measured(file: str = "plastic", **fields: Any) -> dict[str, Any]:
    """A description; GENERAL is put in by `with_general`."""
    return {"type": "measured", "file": "plastic" if file == GENERAL else file, **fields}


def plane(material: dict[str, Any], size: int = 24, **more: Any) -> Scene:
    """A wall of it that fills the picture: z = 0, its tangent along x."""
    return scene(
        camera=camera(size, position=[0.3, 0.2, 2], fov_y_degrees=40),
        **{"lights": [LAMP], **more},
        materials={"wall": material},
        objects=[{**rectangle("wall", [6, 6], [0, 0, 0]), "material": "wall"}],
    )


def ball(material: dict[str, Any], size: int = 48, rings: int = 48, **more: Any) -> Scene:
    """A ball of it alone."""
    return scene(
        camera=camera(size, position=[0, 0.4, 2], fov_y_degrees=34),
        **{"lights": [LAMP], **more},
        materials={"ball": material},
        objects=[
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": rings},
             "material": "ball"},
        ],
    )  # fmt: skip


def table(body: dict[str, Any], ground: dict[str, Any], size: int = 40, **more: Any) -> Scene:
    """A ball over a floor, which it keeps the lamp from in a place."""
    return scene(
        camera=camera(size, position=[0.5, 1.2, 2.4], target=[0, -0.2, 0], fov_y_degrees=40),
        **{"lights": [LAMP], **more},
        materials={"ball": body, "floor": ground},
        objects=[
            {**rectangle("floor", [4, 4], [0, -0.5, 0], [-90, 0, 0]), "material": "floor"},
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.4, "rings": 24},
             "material": "ball"},
        ],
    )  # fmt: skip


def with_general(made: Scene) -> Scene:
    """The scene with a code that has no symmetry in place of every plastic."""
    materials = list(made.materials)
    for k, material in enumerate(materials):
        if isinstance(material, Measured) and material.file == "plastic":
            materials[k] = material.model_copy()
            materials[k]._measurement = AskewMeasurement()
    table = changed_table(made.material_table, materials)
    changed = replace(made, materials=tuple(materials), material_table=table)
    changed.__dict__["rays"] = made.rays
    return changed


@dataclass(frozen=True)
class AskewMeasurement:
    """A lobe that is stretched along neither axis, as if it had been measured."""

    name: str = GENERAL
    isotropic: bool = False

    @property
    def report(self) -> Report:
        return Report(self.name, False, 0, *[Energy(0.5, 0.0, 0)] * 2)

    def evaluate(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        return ASKEW.evaluate(wi, wo)


def write_terrain(path: Path, n: int, steep: float, size: float = 4.0, seed: int = 1) -> Path:
    """An n x n mesh over z = 0 whose vertices lie at random heights; `steep` is their slope."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-size / 2, size / 2, n)
    z = steep * size / n * rng.standard_normal((n, n))
    points = np.stack([*np.meshgrid(x, x, indexing="ij"), z], axis=-1).reshape(-1, 3)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (q.ravel() + 1 for q in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    lines = ["v {:.7g} {:.7g} {:.7g}".format(*p) for p in points]
    lines += ["f {} {} {}".format(*f) for f in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def off(found: NDArray[Any], true: NDArray[Any]) -> float:
    """Relative L2 error."""
    return float(np.linalg.norm(found - true) / np.linalg.norm(true))


def inner(product: Wavelets) -> NDArray[np.bool_]:
    """(height, width) of the picture drawn last: pixels that one surface fills."""
    seen = product._seen
    assert seen is not None
    buffer = seen.view.buffer
    mask = buffer.centre.object >= 0
    mask[buffer.edge] = False
    return mask.reshape(buffer.camera.height, buffer.camera.width)
