"""How well the codes fit, and what users are told."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.measured import Measured
from engine.brdf.wavelet import layout
from engine.brdf.wavelet.layout import block
from engine.diagnosis import Diagnosis
from engine.methods.base import MaterialFit
from engine.methods.light_shares import Shares
from engine.methods.wavelet_brdf.codes import Codes, has_code
from engine.methods.wavelet_brdf.sharpness import Sharpness
from engine.scene.scene import Scene

OFF = 0.05  # mean relative error of a code: less is not worth a warning
MISPLACED = 0.1  # part of the light
LOST = 0.02  # the same
SCATTERED = 0.03  # of a picture, relative L2


def fits_of(scene: Scene, codes: Codes, used: Sequence[int]) -> tuple[MaterialFit, ...]:
    """Of the materials in use; a formula is exact."""
    found = []
    for m in used:
        code = codes.each[m]
        if code is None:
            found.append(MaterialFit(scene.material_names[m], 1, 3, 0.0))
            continue
        channels = int(block(code.data).header[layout.CHANNELS])
        found.append(
            MaterialFit(scene.material_names[m], code.tiles, channels, code.error, code.bytes)
        )
    return tuple(found)


def said_of(
    scene: Scene, materials: Sequence[Material], codes: Codes, used: Sequence[int], shares: Shares
) -> Iterator[Diagnosis]:
    """What all frames of a scene come with, whose light as it stands has these shares."""
    if scene.environment is not None and shares.environment > OFF:
        yield Diagnosis(
            "environment_left_out",
            "This method reflects the light of lamps alone: the environment is seen behind, but "
            f"does not shine, which is {shares.environment:.0%} of the light in the scene as it "
            "stands. glossy_prt carries its light, direct_to_indirect that of both.",
            shares.environment,
        )
    if shares.bounced > OFF:
        yield Diagnosis(
            "indirect_left_out",
            "This method reflects light once: what surfaces throw on each other is left out, "
            f"{shares.bounced:.0%} of the light in the scene as it stands. direct_to_indirect "
            "carries it, for a camera that stands still.",
            shares.bounced,
        )
    for m in used:
        code, sharp, name = codes.each[m], codes.sharp[m], scene.material_names[m]
        material = materials[m]
        if isinstance(material, Measured):
            yield from _of_measurement(name, material)
        if code is not None and code.error > OFF:
            yield Diagnosis(
                "code_too_small",
                f"The code of {name!r} is {100 * code.error:.0f} % off its samples on average: "
                "set a smaller error, or more bytes.",
                code.error,
            )
        elif sharp is not None and sharp.misplaced > MISPLACED:
            yield _narrow(name, sharp)
        if not isinstance(material, Diffuse) and not has_code(material, codes.table, m):
            yield Diagnosis(
                "drawn_by_formula",
                f"{name!r} has textures of what its formula is made of, so it is drawn by that, at "
                "the finest detail: highlights may sparkle from afar.",
            )


def said_of_facets(scattered: float) -> Iterator[Diagnosis]:
    """What a picture comes with that is so far off by pixels that show one facet of many."""
    if scattered > SCATTERED:
        yield Diagnosis(
            "facets_within_pixels",
            "Facets are smaller than pixels, and each pixel shows one of them: for that the "
            f"picture is about {scattered:.0%} off, and glitters when the view moves. Come nearer, "
            "draw more pixels, or set detail to footprint.",
            scattered,
        )


def _narrow(name: str, sharp: Sharpness) -> Diagnosis:
    lost = f", {1 - sharp.light:.0%} of it nowhere" if sharp.light < 1 - LOST else ""
    return Diagnosis(
        "lobe_narrower_than_cells",
        f"Highlights of {name!r} are narrower than the cells of its code: at their brightest they "
        f"have {sharp.peak:.1%} of what they should, and up to {sharp.misplaced:.0%} of the light "
        f"goes elsewhere{lost}. Set more cells.",
        sharp.misplaced,
    )


def _of_measurement(name: str, material: Measured) -> Iterator[Diagnosis]:
    for said in material.measurement().report.diagnoses():
        yield Diagnosis(said.code, f"{name!r}: {said.message}", said.size)
