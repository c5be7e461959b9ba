"""Figures 1, 4, 6, 7, 9, 11 and 12 of `brdf_editing` (Ben-Artzi et al. 2008), with references.

Each is a product of one of the built-in scenes, whose materials are edited as a person would, and
the path tracer's picture of the edited scene.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from engine.brdf import hemispherical_albedo
from engine.measure.contact_sheet import Row, Sheet
from engine.measure.editing_session import FULL, Compared, Materials, Session, edits_of
from engine.scene.edits import apply
from engine.scene.scene import Scene

GLOSSY_WALL = {
    "type": "blinn_phong",
    "diffuse": [0.25, 0.25, 0.25],
    "specular": [0.5, 0.5, 0.5],
    "exponent": 300,
}
YELLOW = {"diffuse": [0.75, 0.6, 0.08]}
BOX: Materials = {"back wall": GLOSSY_WALL, "short block": YELLOW}
GREEN_SOFA = {
    "type": "blinn_phong",
    "diffuse": [0.08, 0.32, 0.1],
    "specular": [0.2, 0.2, 0.2],
    "exponent": 40,
}
SHINY_BOARDS = {
    "type": "blinn_phong",
    "diffuse": [0.2, 0.11, 0.06],
    "specular": [0.35, 0.35, 0.35],
    "exponent": 250,
}
ROOM: Materials = {"sofa": GREEN_SOFA, "boards": SHINY_BOARDS}


def _sheet(
    session: Session, scene: Scene, figure: int, title: str, seen: str, parts: Sequence[Compared]
) -> Sheet:
    below = f"Below: red is too bright, blue too dark, full colour at {FULL:.0%} of the mean."
    rows = [part.rows() for part in parts]
    if all(len(part.numbers) == 1 for part in parts):  # side by side
        rows = [[Row("", [t for pair in rows for t in pair[k].tiles]) for k in (0, 1)]]
    return Sheet(
        f"{title} (the paper's figure {figure})",
        f"{seen}\n{below}",
        [row for pair in rows for row in pair],
        session.document(figure, scene, [n for part in parts for n in part.numbers]),
    )


def _compared(
    session: Session,
    scene: Scene,
    edits: Mapping[str, Materials],
    settings: Mapping[str, Mapping[str, Any]],
    bounces: int | None = None,
) -> list[Compared]:
    """Edits by name, each by settings by name, beside a reference of so many
    bounces behind the first, or of all light.
    """
    images = {
        title: session.images(scene, list(edits.values()), **each)
        for title, each in settings.items()
    }
    parts = []
    for k, (name, edit) in enumerate(edits.items()):
        part = Compared(session, scene, session.truth(scene, edit, bounces), name)
        for title, pictures in images.items():
            part.add(pictures[k], title)
        parts.append(part)
    return parts


def room_session(session: Session) -> Sheet:
    """Figure 1: the sofa and the floor of the room edited, and direct light alone."""
    scene = session.scene("room")
    edits: dict[str, Materials] = {"as it is": {}, "green sofa, shiny floor": ROOM}
    made = {"(64, 1, 1)": {"bounces": 2}, "direct light alone": {"bounces": 0}}
    parts = _compared(session, scene, edits, made)
    return _sheet(
        session, scene, 1, "Materials of a room",
        "A sofa and a floor edited in one sitting. The reference has all light, the series three "
        "bounces.", parts,
    )  # fmt: skip


def series(session: Session) -> Sheet:
    """Figure 4: what each series of elements makes of a teapot on a shiny tray, two bounces."""
    scene = session.scene("teatray")
    made = {
        f"({bands}, {second})": {"bands": bands, "second_bands": second, "bounces": 1}
        for bands, second in ((128, 8), (16, 8), (128, 1))
    }
    made["direct light alone"] = {"bands": 128, "bounces": 0}
    parts = _compared(session, scene, {"teatray": {}}, made, bounces=1)
    return _sheet(
        session, scene, 4, "Series of elements",
        "Two bounces. The tray mirrors the teapot, and the teapot its spout and the tray: with a "
        "matt second bounce it mirrors them matt.", parts,
    )  # fmt: skip


def box_edits(session: Session) -> Sheet:
    """Figure 6: a block and the back wall of the Cornell box edited."""
    scene = session.scene("cornell-box")
    edits: dict[str, Materials] = {"as it is": {}, "glossy wall": BOX}
    parts = _compared(session, scene, edits, {"(64, 1, 1, 1)": {}})
    return _sheet(
        session, scene, 6, "Edits of the Cornell box",
        "The small block turns yellow, the back wall glossy: it mirrors the box, and the large "
        "block takes the colour of the small one.", parts,
    )  # fmt: skip


def coarser(session: Session) -> Sheet:
    """Figure 7: the glossy wall with matt indirect light, and with direct light alone."""
    scene = session.scene("cornell-box")
    matt = _matt(apply(scene, edits_of(BOX)))
    (full,) = session.images(scene, [BOX])
    direct, matt_direct = session.images(scene, [BOX, matt], bounces=0)
    (matt_all,) = session.images(scene, [matt])
    part = Compared(session, scene, session.truth(scene, BOX), "glossy wall")
    part.add(full, "(64, 1, 1, 1)")
    part.add(direct + matt_all - matt_direct, "direct + matt indirect")
    part.add(direct, "direct light alone")
    return _sheet(
        session, scene, 7, "Coarser ways",
        "Where what the wall reflects of the box is taken as matt, it mirrors the lamp and "
        "nothing else.", [part],
    )  # fmt: skip


def _matt(scene: Scene) -> Materials:
    """Edits that make all materials matt, each as bright as it is."""
    table = scene.material_table
    albedo = hemispherical_albedo(table.model, table.row)
    return {
        name: {"type": "diffuse", "diffuse": np.clip(albedo[m], 0, 1).tolist()}
        for m, name in enumerate(scene.material_names)
    }


def anisotropy(session: Session) -> Sheet:
    """Figure 9: the highlight of the vase turned, and its Fresnel reflection made stronger."""
    scene = session.scene("vase")
    vase = scene.materials[scene.material_names.index("vase")].model_dump()
    turned = {"exponent_u": vase["exponent_v"], "exponent_v": vase["exponent_u"]}
    rim = {**turned, "specular": [0.04, 0.04, 0.04], "diffuse": [0.1, 0.13, 0.2]}
    edits: dict[str, Materials] = {
        "as it is": {},
        "brushed the other way": {"vase": turned},
        "stronger Fresnel": {"vase": rim},
    }
    made = {"(64, 8, 1, 1)": {"second_bands": 8}, "(64, 1, 1, 1)": {}}
    parts = _compared(session, scene, edits, made)
    return _sheet(
        session, scene, 9, "Anisotropy and Fresnel",
        "The exponents of the vase change places; then little is left of its reflectance at "
        "normal incidence, and all of it towards the rim.\nBelow it mirrors the table, and lamps "
        "in it: that asks for gloss behind the first bounce.", parts,
    )  # fmt: skip


def caustics(session: Session) -> Sheet:
    """Figure 11: the caustic of a ring, sharp and wide, on a matt and on a glossy plane."""
    scene = session.scene("ring")
    glossy = {"specular": [0.3, 0.3, 0.3], "diffuse": [0.15, 0.15, 0.16]}
    edits: dict[str, Materials] = {
        "as it is": {},
        "a rougher ring": {"ring": {"roughness": 0.32}},
        "a glossy plane": {"plane": glossy},
    }
    made = {"(64, 16)": {"second_bands": 16, "bounces": 1}, "(64, 1)": {"bounces": 1}}
    parts = _compared(session, scene, edits, made, bounces=1)
    return _sheet(
        session, scene, 11, "Caustics",
        "Two bounces. With a matt second one the ring throws no caustic, and mirrors no light of "
        "its other side.", parts,
    )  # fmt: skip


def gloss_in_gloss(session: Session) -> Sheet:
    """Figure 12: the room as it is, and with a floor and a sofa that mirror one another."""
    scene = session.scene("room")
    shiny = {"sofa": {**GREEN_SOFA, "exponent": 80}, "boards": SHINY_BOARDS}
    edits: dict[str, Materials] = {"as it is": {}, "exponents 80, 250": shiny}
    parts = _compared(session, scene, edits, {"(64, 1, 1)": {"bounces": 2}}, bounces=2)
    return _sheet(
        session, scene, 12, "Gloss in gloss",
        "Three bounces. What is off is where light meets two glossy things or more.", parts,
    )  # fmt: skip


FIGURES: dict[int, Callable[[Session], Sheet]] = {
    1: room_session,
    4: series,
    6: box_edits,
    7: coarser,
    9: anisotropy,
    11: caustics,
    12: gloss_in_gloss,
}
"""By their numbers in the paper."""
