"""The codes of a scene's materials, made or read from the store.

What is measured is encoded, and so is every glossy model that no texture reaches into. A matt
material is its own formula. One with textures of its reflectances or its roughness is too, since a
code cannot tell what of it a texture would change; a measured one's multiplies all of it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf import measured
from engine.brdf.acquisition import of_material
from engine.brdf.base import SPECULAR, Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.measured import Measured
from engine.brdf.table import INDEX
from engine.brdf.wavelet.analysis import Grid
from engine.brdf.wavelet.encoding import Encoded, Target
from engine.brdf.wavelet.tabulate import Source
from engine.methods.base import Progress
from engine.methods.chunks import CallingThread
from engine.methods.wavelet_brdf.settings import Settings
from engine.methods.wavelet_brdf.sharpness import Sharpness, sharpness_of
from engine.scene.scene import MaterialTable, Scene
from engine.scene.surface import NORMAL_MAP
from engine.scene.tables import changed_table
from engine.store import Store

NAME = "wavelet_brdf"
VERSION = 2  # of the stored codes and of what they mean


@dataclass(frozen=True, eq=False)
class Codes:
    """Materials as this method draws them.

    table  those of the scene, with rows of `measured` where there is a code
    each   the codes; None where a material is its own formula
    sharp  how well they show highlights
    """

    table: MaterialTable
    each: tuple[Encoded | None, ...]
    sharp: tuple[Sharpness | None, ...]


def codes_of(
    scene: Scene,
    materials: Sequence[Material],
    settings: Settings,
    store: Store,
    used: Sequence[int],
    progress: Progress,
    executor: Executor | None = None,
) -> Codes:
    """Codes of materials that stand in the scene; of those not in `used` none is made.

    The executor makes those that the store lacks, half a second each; None is this thread.
    """
    executor = executor or CallingThread()
    table = changed_table(scene.material_table, materials)
    each: list[Encoded | None] = [None] * len(materials)
    sharp: list[Sharpness | None] = [None] * len(materials)
    for k, m in enumerate(used):
        progress("codes", k, len(used))
        if has_code(materials[m], table, m):
            each[m], sharp[m] = _code(materials[m], table.row[m], settings, store, executor)
    progress("codes", len(used), len(used))
    model, row = table.model.copy(), table.row.copy()
    for m, code in enumerate(each):
        if code is not None:
            model[m] = INDEX[Measured]
            colour = row[m, SPECULAR : SPECULAR + 3].copy()
            row[m] = 0
            row[m, SPECULAR : SPECULAR + 3] = colour if isinstance(materials[m], Measured) else 1.0
            measured.fill(row[m], code)
            row[m, measured.NEAREST] = settings.filter == "nearest"
    return Codes(table._replace(model=model, row=row), tuple(each), tuple(sharp))


def has_code(material: Material, table: MaterialTable, m: int) -> bool:
    """Whether a material is encoded; see above."""
    if isinstance(material, Measured):
        return True
    return not isinstance(material, Diffuse) and bool((table.maps[m, :NORMAL_MAP] < 0).all())


def _code(
    material: Material,
    row: NDArray[np.float32],
    settings: Settings,
    store: Store,
    executor: Executor,
) -> tuple[Encoded, Sharpness]:
    digest = hashlib.blake2b(digest_size=16)
    target = settings.target
    for part in (VERSION, INDEX[type(material)], settings.bits, asdict(target)):
        digest.update(f"{part}\n".encode())
    # The colour that multiplies a measured material is none of its code's.
    known = row.copy()
    if isinstance(material, Measured):
        known[SPECULAR : SPECULAR + 3] = 1
    digest.update(known.data)
    entry = store.entry(f"{NAME}-{digest.hexdigest()}")
    stored = entry.read("code")
    if stored is not None:
        grid = Grid(**stored.meta["grid"])
        code = Encoded(stored.arrays["data"], grid, **stored.meta["quality"])
        return code, Sharpness(**stored.meta["sharp"])
    code, sharp = executor.submit(_made, material, settings.bits, target).result()
    quality = {name: getattr(code, name) for name in ("error", "worst", "light", "kept")}
    meta = {"grid": asdict(code.grid), "quality": quality, "sharp": asdict(sharp)}
    entry.write("code", {"data": code.data}, meta)
    return code, sharp


def _made(material: Material, bits: int, target: Target) -> tuple[Encoded, Sharpness]:
    source = source_of(material)
    code = measured.encoded(source, bits, target)
    return code, sharpness_of(source, code)


def source_of(material: Material) -> Source:
    """What a material is encoded from."""
    return material.measurement() if isinstance(material, Measured) else of_material(material)
