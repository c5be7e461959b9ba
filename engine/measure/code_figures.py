"""Figures 3, 8, 9 and 10 of `wavelet_brdf` (Claustres, Barthe, Paulin 2007), with references.

References evaluate what was measured, or the model, for every ray, with no code in between.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import Material
from engine.brdf.lewis import Lewis
from engine.measure.cast import cast, per_vertex
from engine.measure.code_rates import LEVELS, frames_per_second
from engine.measure.code_stage import DARK, METHOD, away, lit, terrain
from engine.measure.contact_sheet import Row, Sheet, Tile, difference, picture
from engine.measure.document import finite, provenance
from engine.measure.edges import scene_edges
from engine.measure.fresh import fresh
from engine.measure.machine import this_machine
from engine.measure.metrics import auto_exposure, lab_difference, lab_distance, relative_l2
from engine.measure.settings import settings_from
from engine.measure.stage import Thing
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.scene.edits import Edits
from engine.scene.scene import Scene

Image = NDArray[np.float32]

SIZE = (256, 256)
FULL = 0.5  # part of the reference's mean at which the colours of a difference are full
FULL_LAB = 5.0  # ΔE at which they are
GRID = 8  # rays along each side of a pixel of references from afar
FAR, ZOOM = 24.0, 9.0  # diagonals to the object of figure 3; how much its picture is enlarged
FROM, TO = (0.0, 0.42, 0.72), (0.0, 0.0, 0.02)  # the camera over the terrain, and where it looks
ALPHA = 4.0  # α over the terrain, whose far end is but one diagonal away
CROP = 4  # how much the terrain from afar is magnified
SPEED = (512, 512)  # pixels of pictures that are timed
SHINY = Lewis(emission=DARK, diffuse=(0.4, 0.1, 0.05), specular=(0.3, 0.3, 0.3), exponent=200)


@dataclass(frozen=True)
class Shoot:
    """What all figures are made with.

    thing      the object
    materials  measured ones by name
    size       width and height of a picture
    fixed      settings that hold where a figure does not set them
    """

    thing: Thing
    materials: Mapping[str, Material]
    size: tuple[int, int] = SIZE
    fixed: Mapping[str, Any] = field(default_factory=dict)
    progress: Progress = silent

    def image(self, scene: Scene, **settings: Any) -> Image:
        """The method's picture of a scene at some settings."""
        chosen = settings_from(METHODS[METHOD].settings, {**self.fixed, **settings})
        with fresh(scene, METHOD, chosen, self.progress) as made:
            return made.product.relight(Edits()).image

    def document(self, figure: int, scene: Scene, pictures: list[dict[str, Any]]) -> dict[str, Any]:
        """The numbers of a figure."""
        return finite(
            {
                **provenance(),
                "machine": this_machine().as_dict(),
                "method": METHOD,
                "figure": figure,
                "width": scene.camera.width,
                "height": scene.camera.height,
                "object": scene.name,
                "triangles": len(scene.geometry.triangles),
                "settings": asdict(settings_from(METHODS[METHOD].settings, self.fixed)),
                "pictures": pictures,
            }
        )


def exposure_of(reference: Image) -> float:
    """Stops that bring nearly all of what is there below 1."""
    return auto_exposure(reference[reference.max(axis=2) > 0][None])


def numbers(image: Image, reference: Image, mask: NDArray[np.bool_]) -> dict[str, float]:
    """How far a picture is off, over the masked pixels, or over all if those are none."""
    mask = mask if mask.any() else np.ones_like(mask)
    exposure = exposure_of(reference)
    distance = lab_distance(image, reference, exposure)[mask]
    return {
        "relative_l2": relative_l2(image, reference, mask),
        "light": float(image[mask].mean() / reference[mask].mean()),
        "lab": float(distance.mean()),
        "lab_deviation": float(distance.std()),
        "lab_2000": lab_difference(image, reference, mask, exposure),
    }


DETAILS = {
    "finest": {"detail": "finest"},
    "by distance": {"detail": "distance"},
    "by footprint": {"detail": "footprint"},
}


def from_afar(shoot: Shoot) -> Sheet:
    """Figure 3: an object from far away, with the finest level and with levels of detail."""
    size = min(64, shoot.size[0]), min(64, shoot.size[1])
    rows: list[Row] = []
    found: list[dict[str, Any]] = []
    for name, material in {"plastic, n = 200": SHINY, **shoot.materials}.items():
        scene = away(lit(shoot.thing, material, size), FAR, ZOOM)
        rows += _compared(shoot, scene, name, {}, found)
    return Sheet(
        "From afar (the paper's figure 3)",
        f"An object {FAR:g} of its diagonals away, the middle of a picture {ZOOM:g} times as wide. "
        f"Below: red is too bright, blue too dark,\nfull colour at {FULL:.0%} of the mean.",
        rows,
        shoot.document(3, scene, found),
    )


def materials(shoot: Shoot) -> Sheet:
    """Figure 8: measured materials; a plastic by its code and by its formula, also at vertices."""
    shown, found = [], []
    for name, material in shoot.materials.items():
        scene = lit(shoot.thing, material, shoot.size)
        image = shoot.image(scene, detail="finest")
        shown.append(picture(image, exposure_of(image), name))
    scene = lit(shoot.thing, SHINY, shoot.size)
    right, mask = cast(scene), ~scene_edges(scene)
    mask &= right.max(axis=2) > 0
    exposure = exposure_of(right)
    made = {"code": shoot.image(scene, detail="finest"), "formula at vertices": per_vertex(scene)}
    plastic = [picture(right, exposure, "formula at pixels")]
    off: list[Tile | None] = [None]
    for title, image in made.items():
        each = numbers(image, right, mask)
        plastic.append(picture(image, exposure, title))
        text = f"{each['relative_l2']:.1%} off, ΔE {each['lab']:.2f}"
        off.append(difference(image, right, mask, FULL, text))
        found.append({"material": "plastic, n = 200", "by": title, **each})
    return Sheet(
        "Measured materials, and a plastic (the paper's figure 8)",
        f"{len(scene.geometry.triangles):,} triangles. The plastic is Lewis's model with the "
        "exponent 200. Below: red is too bright, blue too dark,\nfull colour at "
        f"{FULL:.0%} of the mean.",
        [Row("measured", shown), Row("plastic", plastic), Row("off by", off)],
        shoot.document(8, scene, found),
    )


def beside_reference(shoot: Shoot) -> Sheet:
    """Figure 9: pictures beside references, and how far apart their colours are."""
    rows, found = [], []
    for name, material in shoot.materials.items():
        scene = lit(shoot.thing, material, shoot.size)
        image, edges = shoot.image(scene, detail="finest"), scene_edges(scene)
        # The method looks at four places of a pixel at an edge, and so has the reference to.
        reference = np.where(edges[..., None], cast(scene, 2), cast(scene))
        there = reference.max(axis=2) > 0
        exposure = exposure_of(reference)
        each, everywhere = (numbers(image, reference, m) for m in (there & ~edges, there))
        distance = lab_distance(image, reference, exposure)
        colours = matplotlib.colormaps["magma"](np.clip(distance / FULL_LAB, 0, 1))[..., :3]
        text = f"ΔE {each['lab']:.2f}, deviation {each['lab_deviation']:.2f}"
        rows.append(
            Row(
                name,
                [
                    picture(image, exposure, "wavelet_brdf"),
                    picture(reference, exposure, "what was measured, by rays"),
                    Tile(colours, text),
                ],
            )
        )
        found.append({"material": name, **each, "lab_with_edges": everywhere["lab"]})
    return Sheet(
        "Beside references (the paper's figure 9)",
        f"Distance in L*a*b* over the object without edges; black is 0, yellow {FULL_LAB:g}. The "
        "paper has 1.3 and a deviation of 2.29.",
        rows,
        shoot.document(9, scene, found),
    )


def landscape(shoot: Shoot) -> Sheet:
    """Figure 10: levels over a terrain from near by, and the terrain from far away, magnified."""
    hills = terrain()
    found: list[dict[str, Any]] = []
    scene = lit(hills, SHINY, shoot.size)
    update = {"position": FROM, "target": TO, "fov_y_degrees": 40.0}
    near = scene.with_camera(scene.camera.model_copy(update=update))
    rows = list(_compared(shoot, near, "near by", {"alpha": ALPHA}, found))
    levels = [shoot.image(near, show="levels", alpha=ALPHA, **DETAILS[name]) for name in DETAILS]
    rows.insert(1, Row("levels", [*(Tile(image.astype(float), "") for image in levels), None]))
    name, first = next(iter(shoot.materials.items()))
    size = shoot.size[0] // CROP, shoot.size[1] // CROP
    for title, material in (("plastic, n = 200", SHINY), (name, first)):
        far = away(lit(hills, material, size), FAR, ZOOM)
        rows += _compared(shoot, far, f"from afar: {title}", {}, found)
    speed = _speed_by_level(shoot, near)
    found.append({"material": "plastic, n = 200", "frames_per_second": speed})
    ratios = ", ".join(f"{fps / speed[-1]:.2f}" for fps in speed[-2::-1])
    return Sheet(
        "A terrain (the paper's figure 10)",
        f"{len(scene.geometry.triangles):,} triangles. Levels: blue is the finest, red the "
        f"coarsest; α = {ALPHA:g} near by.\nFrom {FAR:g} diagonals away, {CROP} times as large. "
        f"With a moved light coarser levels are faster\nthan the finest by {ratios} (the paper: "
        "1.3, 1.8, 2.7, 5.7).",
        rows,
        shoot.document(10, near, found),
    )


def _compared(
    shoot: Shoot, scene: Scene, name: str, settings: Mapping[str, Any], found: list[dict[str, Any]]
) -> Iterator[Row]:
    """Pictures by what picks the level, beside the reference, and what is off."""
    reference = cast(scene, GRID)
    mask, exposure = reference.max(axis=2) > 0, exposure_of(reference)
    shown, off = [], []
    for title, detail in DETAILS.items():
        image = shoot.image(scene, **settings, **detail)
        each = numbers(image, reference, mask)
        shown.append(picture(image, exposure, title))
        text = f"{each['relative_l2']:.1%} off, {each['light']:.1%} of the light"
        off.append(difference(image, reference, mask, FULL, text))
        found.append({"picture": name, "detail": title, **each})
    shown.append(picture(reference, exposure, f"{GRID**2} rays a pixel"))
    yield Row(name, shown)
    yield Row("off by", [*off, None])


def _speed_by_level(shoot: Shoot, scene: Scene) -> list[float]:
    """Frames per second of a moved light, from the coarsest level to the finest."""
    found = []
    update = {"width": SPEED[0], "height": SPEED[1]}
    scene = scene.with_camera(scene.camera.model_copy(update=update))
    for level in range(LEVELS - 1, -1, -1):
        chosen = {"shadows": False, **shoot.fixed, "detail": "finest", "level": float(level)}
        settings = settings_from(METHODS[METHOD].settings, chosen)
        with fresh(scene, METHOD, settings, shoot.progress) as made:
            found.append(frames_per_second(made.product, "light", "cpu"))
    return found


FIGURES: dict[int, Callable[[Shoot], Sheet]] = {
    3: from_afar,
    8: materials,
    9: beside_reference,
    10: landscape,
}
"""By their numbers in the paper."""
