"""Materials of OBJ files.

MTL has no measured meaning, so this is a choice: Kd is the diffuse reflectance; where Ks is not
black, it is the reflectance of a Blinn-Phong lobe with exponent Ns. Kd is lowered where Kd + Ks
would reflect more than it receives. map_Kd multiplies Kd, or replaces it where Kd is black, as
exporters write it. `norm` is a normal map; heights (`map_Bump`) are left out, as MTL gives them no
unit. Ke is emitted radiance. Transparency is not modelled.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.diffuse import Diffuse
from engine.diagnosis import Diagnosis
from engine.scene.companions import Companions
from engine.scene.surfaces import Surface
from engine.scene.textures import MAX_SIDE, Image, read_image


class Converter:
    """Turns the materials of one file into ours; an image used twice is read once."""

    def __init__(self, companions: Companions) -> None:
        self.companions = companions
        self._images: dict[tuple[Path, bool], Image] = {}
        self._reduced: list[Diagnosis] = []
        self._transparent: list[str] = []
        self._limited: dict[str, float] = {}

    def diagnoses(self) -> list[Diagnosis]:
        """What to say of the materials converted so far."""
        found = list(self._reduced)
        if self._transparent:
            found.append(opaque(self._transparent))
        if self._limited:
            worst = max(self._limited, key=lambda name: self._limited[name])
            found.append(
                Diagnosis(
                    "reflectance_limited",
                    f"{len(self._limited)} material(s) would reflect more than they receive, "
                    f"{worst!r} the most with Kd + Ks {1 + self._limited[worst]:.2f}: Kd was "
                    "lowered",
                    self._limited[worst],
                )
            )
        return found

    def surface(self, material: Any) -> Surface:
        """Ours for one of trimesh's `SimpleMaterial`."""
        words = material.kwargs
        diffuse, specular = _colour(words.get("kd"), 0.8), _colour(words.get("ks"), 0.0)
        images: dict[str, Image] = {}
        # trimesh keeps the path of a texture it found, and the companions that of one it did not.
        if named_image(material):
            self._add(images, "diffuse", named_image(material))
        if "map_ks" in words:
            self._add(images, "specular", " ".join(words["map_ks"]))
        if "norm" in words:
            self._add(images, "normal", " ".join(words["norm"]))
        if "diffuse" in images and not diffuse.any():
            diffuse = np.ones(3)
        if "specular" in images and not specular.any():
            specular = np.ones(3)
        shown = material.name or "material"
        if _number(words.get("d"), 1.0) < 1 or _number(words.get("tr"), 0.0) > 0:
            self._transparent.append(shown)
        specular = np.clip(specular, 0, 1)
        room = 1 - specular
        excess = float(np.max(diffuse + specular)) - 1
        if excess > 1e-6:
            seen = diffuse > 0
            diffuse = diffuse * min(1.0, float(np.min(room[seen] / diffuse[seen])))
            self._limited[shown] = excess
        emission = tuple(np.clip(_colour(words.get("ke"), 0.0), 0, None).tolist())
        kd, ks = tuple(np.clip(diffuse, 0, 1).tolist()), tuple(specular.tolist())
        made: Material
        if specular.any():
            exponent = min(max(_number(words.get("ns"), 0.0), 0.0), 1e5)
            made = BlinnPhong(emission=emission, diffuse=kd, specular=ks, exponent=exponent)
        else:
            made = Diffuse(emission=emission, diffuse=kd)
        return Surface(made, images)

    def _add(self, images: dict[str, Image], slot: str, name: str) -> None:
        path = self.companions.find(name)
        if path is None:
            return
        key = path, slot != "normal"
        if key not in self._images:
            self._images[key], side = read_image(path, path.name, srgb=key[1])
            if side > MAX_SIDE:
                self._reduced.append(capped(path.name, side))
        images[slot] = self._images[key]


def named_image(material: Any) -> str:
    """The file of a material's image as the MTL names it, empty where it has none."""
    return "" if material.image is None else str(material.image.info.get("file_path", ""))


def opaque(names: list[str]) -> Diagnosis:
    """What to say of materials that let light through."""
    return Diagnosis(
        "opaque", f"transparent in the file but opaque here: {', '.join(sorted(names))}"
    )


def capped(name: str, side: int) -> Diagnosis:
    """What to say of an image that was made smaller."""
    return Diagnosis(
        "texture_reduced",
        f"{name} is {side} pixels long and was reduced to {MAX_SIDE} to spare memory",
        side / MAX_SIDE - 1,
    )


def _colour(value: Any, default: float) -> NDArray[np.float64]:
    """Three finite numbers from one or three, as numbers or words."""
    try:
        colour = np.broadcast_to(np.asarray(value, np.float64), 3)
    except (TypeError, ValueError):
        return np.full(3, default)
    return np.array(colour) if np.isfinite(colour).all() else np.full(3, default)


def _number(value: Any, default: float) -> float:
    try:
        number = float(value[-1] if isinstance(value, list) else value)
    except (TypeError, ValueError, IndexError):
        return default
    return number if np.isfinite(number) else default
