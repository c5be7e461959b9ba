"""Figures 6, 8, 10 and 11 of `glossy_prt` (Wang, Tran, Luebke 2006, §5), with references.

The paper shows pictures and leaves it to the eye; here each has a reference by the path tracer, its
error, and where that error is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import Material
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.maps import load_environment
from engine.measure.accuracy import METHOD, counted, error
from engine.measure.contact_sheet import Row, Sheet, difference, picture
from engine.measure.document import finite, provenance
from engine.measure.fresh import fresh
from engine.measure.machine import this_machine
from engine.measure.metrics import auto_exposure
from engine.measure.settings import settings_from
from engine.measure.stage import MATERIALS, Thing, stage
from engine.measure.truth import Truth, truth
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.numerics import cube_map
from engine.reference import render
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

FULL = 0.3  # part of the reference's mean at which the colours of a difference are full
FULL_OF_BOUNCE = 0.1  # the same of bounced light alone
SIZE, CUTS, REFERENCE_ERROR = (256, 256), 128, 0.02
HEIGHT = 256  # of the maps that are made here
SUN = ((-0.62, 0.8, 0.12), 1.5, (1.0, 0.95, 0.85), 0.04)
LAMP = ((-0.35, 0.62, 0.7), 6.0, (1.0, 0.62, 0.28), 0.0)
"""Direction to the light, its radius in degrees, its colour, radiance of the rest of the sky over
the mean of the light's."""


@dataclass(frozen=True)
class Shoot:
    """What all figures are made with.

    thing            the object
    size             width and height of a picture
    cuts             of the floor along both sides
    fixed            settings that hold where a figure does not set them
    reference_error  relative L2 error that references are rendered to
    store            where they are kept
    """

    thing: Thing
    size: tuple[int, int] = SIZE
    cuts: int = CUTS
    fixed: Mapping[str, Any] = field(default_factory=dict)
    reference_error: float = REFERENCE_ERROR
    store: Store = field(default_factory=Store)
    progress: Progress = silent

    def scene(self, material: Material, sky: Environment, *, alone: bool = False) -> Scene:
        """The object of a material under a sky."""
        cuts = None if alone else self.cuts
        return stage(self.thing, material, self.size, cuts=cuts, environment=sky)

    def image(self, scene: Scene, **settings: Any) -> NDArray[np.float32]:
        """The method's picture of a scene at some settings."""
        chosen = settings_from(METHODS[METHOD].settings, {**self.fixed, **settings})
        with fresh(scene, METHOD, chosen, self.progress) as made:
            return made.product.relight(Edits()).image

    def truth(self, scene: Scene, bounces: int | None) -> Truth:
        """The reference of light that bounces so often, or to its end."""
        limit = None if bounces is None else bounces + 1
        error = self.reference_error
        return truth(scene, Edits(), error, self.store, self.progress, max_bounces=limit)

    def document(self, figure: int, pictures: list[dict[str, Any]]) -> dict[str, Any]:
        """The numbers of a figure."""
        return finite(
            {
                **provenance(),
                "machine": this_machine().as_dict(),
                "method": METHOD,
                "figure": figure,
                "width": self.size[0],
                "height": self.size[1],
                "object": self.thing.name,
                "vertices": len(self.thing.part.positions),
                "settings": asdict(settings_from(METHODS[METHOD].settings, self.fixed)),
                "reference_error": self.reference_error,
                "seed": 0,  # of the references; nothing else is drawn
                "pictures": pictures,
            }
        )


def spot_sky(
    direction: tuple[float, float, float],
    degrees: float,
    colour: tuple[float, float, float],
    rest: float,
) -> Environment:
    """A disk of light in an even sky, whose light together is that of radiance 1 from everywhere.

    direction  to the light, of any length
    degrees    radius of the disk
    rest       radiance of the sky, over that of both together spread out evenly
    """
    theta = (np.arange(HEIGHT)[:, None] + 0.5) * np.pi / HEIGHT
    phi = (np.arange(2 * HEIGHT)[None] + 0.5) * np.pi / HEIGHT - np.pi
    d = np.stack(
        np.broadcast_arrays(
            np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)
        ),
        axis=-1,
    )
    axis = np.array(direction) / np.linalg.norm(direction)
    inside = np.arccos(np.clip(d @ axis, -1, 1)) < np.radians(degrees)
    share = float((inside * np.sin(theta)).sum() / (np.sin(theta) * np.ones_like(phi)).sum())
    level = rest + np.where(inside, (1 - rest) / share, 0)
    radiance = level[..., None] * np.array(colour)
    return Environment(EnvironmentDescription(map=colour), radiance.astype(np.float32))


def interreflections(shoot: Shoot) -> Sheet:
    """Figure 6: direct light, one and two bounces, on matt and on glossy surfaces."""
    sky = load_environment(EnvironmentDescription(map="studio"), Path())
    rows, numbers = [], []
    for name in ("diffuse", "red Phong"):
        scene = shoot.scene(MATERIALS[name], sky)
        pixels, whole = counted(scene).whole, shoot.truth(scene, None)
        exposure = auto_exposure(whole.image)
        shown, off = [], []
        for bounces, title in enumerate(("direct", "1 bounce", "2 bounces")):
            image = shoot.image(scene, bounces=bounces, remaining=0.0)
            same = error(image, shoot.truth(scene, bounces), pixels)
            of_all = error(image, whole, pixels)
            shown.append(picture(image, exposure, title))
            text = f"{same:.1%} off {title}\n{of_all:.1%} off all light"
            off.append(difference(image, whole.image, pixels, FULL, text))
            numbers.append(
                {"material": name, "bounces": bounces, "relative_l2": same, "of_all": of_all}
            )
        shown.append(picture(whole.image, exposure, "path tracer, all light"))
        rows += [Row(name, shown), Row("off all light by", [*off, None])]
    return Sheet(
        "Interreflections (the paper's figure 6)",
        "An object over a matt floor in the studio. Below: red is too bright, blue too dark, full "
        f"colour at {FULL:.0%} of the mean;\nwhat is missing without bounces is where surfaces "
        "face each other.",
        rows,
        shoot.document(6, numbers),
    )


def terms(shoot: Shoot) -> Sheet:
    """Figure 8: highlights of a brushed object under one coloured light, by terms K."""
    scene = shoot.scene(MATERIALS["Ashikhmin-Shirley"], spot_sky(*LAMP), alone=True)
    reference, pixels = shoot.truth(scene, 0), counted(scene).whole
    exposure = auto_exposure(reference.image)
    shown, off, numbers = [], [], []
    for k in (1, 2, 4, 8, 16):
        image = shoot.image(scene, terms=k, bounces=0)
        found = error(image, reference, pixels)
        light = float(image[pixels].mean() / reference.image[pixels].mean())
        shown.append(picture(image, exposure, f"K = {k}"))
        text = f"{found:.1%} off\n{light:.1%} of the light"
        off.append(difference(image, reference.image, pixels, 1.0, text))
        numbers.append({"terms": k, "relative_l2": found, "light": light})
    shown.append(picture(reference.image, exposure, "path tracer"))
    return Sheet(
        "Terms of a brushed material (the paper's figure 8)",
        "Ashikhmin-Shirley under one coloured light, direct light alone. Few terms spread the "
        "highlights. Below: red is too bright, blue too dark,\nfull colour at the mean of the "
        "reference.",
        [Row("Ashikhmin-Shirley", shown), Row("off by", [*off, None])],
        shoot.document(8, numbers),
    )


def wavelets(shoot: Shoot) -> Sheet:
    """Figure 10: the sharp shadow of a matt object on the floor, by wavelets N_l."""
    scene = shoot.scene(MATERIALS["diffuse"], spot_sky(*SUN))
    reference, pixels = shoot.truth(scene, 0), counted(scene).parts["floor"]
    exposure = auto_exposure(reference.image)
    texels = cube_map.FACES * settings_from(METHODS[METHOD].settings, shoot.fixed).light_texels ** 2
    shown, off, numbers = [], [], []
    for count in (32, 64, 128, 256, 512):
        image = shoot.image(scene, coefficients=count, cluster_error=0.0, bounces=0)
        found, kept = error(image, reference, pixels), count / texels
        shown.append(picture(image, exposure, f"$N_l$ = {count} ({kept:.2%})"))
        text = f"floor {found:.1%} off"
        off.append(difference(image, reference.image, pixels, FULL, text))
        numbers.append({"coefficients": count, "kept": kept, "floor": found})
    shown.append(picture(reference.image, exposure, "path tracer"))
    return Sheet(
        "Shadows by wavelets kept (the paper's figure 10)",
        "A matt object on a matt floor under a small sun, direct light alone. Below: red is too "
        f"bright, blue too dark, full colour at {FULL:.0%} of the mean.",
        [Row("matt", shown), Row("off by", [*off, None])],
        shoot.document(10, numbers),
    )


def gathering(shoot: Shoot) -> Sheet:
    """Figure 11: light of one bounce alone, by texels of the cube map that gathers it."""
    sky = load_environment(EnvironmentDescription(map="studio"), Path())
    scene = shoot.scene(MATERIALS["diffuse"], sky)
    found = render(scene, error=shoot.reference_error / 2, max_bounces=2, progress=shoot.progress)
    reference = Truth(found.indirect, found.indirect_variance, found.error, 0.0, found.samples)
    pixels, direct = counted(scene).whole, shoot.image(scene, bounces=0)
    exposure = auto_exposure(reference.image)
    images = {
        texels: shoot.image(scene, bounces=1, gather_texels=texels, remaining=0.0) - direct
        for texels in (8, 16, 32, 64)
    }
    shown, off, numbers = [], [], []
    for texels, image in images.items():
        relative = error(image, reference, pixels)
        shown.append(picture(image, exposure, f"6 x {texels} x {texels}"))
        text = f"{relative:.1%} off the path tracer"
        off.append(difference(image, images[64], pixels, FULL_OF_BOUNCE, text))
        numbers.append({"gather_texels": texels, "relative_l2": relative})
    shown.append(picture(reference.image, exposure, "path tracer"))
    return Sheet(
        "Resolution of gathering (the paper's figure 11)",
        "What one bounce adds to a matt object on a matt floor in the studio, alone and bright. "
        "Below, against 6 x 64 x 64: red is too bright, blue too dark,\nfull colour at "
        f"{FULL_OF_BOUNCE:.0%} of its mean: too few texels give bands.",
        [Row("bounced light", shown), Row("off 6 x 64 x 64 by", [*off, None])],
        shoot.document(11, numbers),
    )


FIGURES: dict[int, Callable[[Shoot], Sheet]] = {
    6: interreflections,
    8: terms,
    10: wavelets,
    11: gathering,
}
"""By their numbers in the paper."""
