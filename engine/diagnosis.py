"""What a scene, a method or the planner has to say about its own picture, in plain words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Diagnosis:
    """One thing the user should know.

    code      one of VOCABULARY
    message   a sentence: what is wrong, how large it is, which setting or method would mend it
    size      the measured or estimated relative error or excess, 0 where it has no number
    """

    code: str
    message: str
    size: float = 0.0


@dataclass(frozen=True)
class Meaning:
    """What a code says of a scene, a measurement or a picture, and what mends it."""

    of: str
    meaning: str
    mend: str


def worth_saying(diagnoses: Iterable[Diagnosis], budget: float) -> tuple[Diagnosis, ...]:
    """Those whose size is above an allowed relative error, and those that have no number."""
    return tuple(d for d in diagnoses if d.size == 0 or d.size > budget)


def _of(kind: str, **codes: tuple[str, str]) -> dict[str, Meaning]:
    return {code: Meaning(kind, *words) for code, words in codes.items()}


NOTHING = "nothing: it is as it should be"
VOCABULARY: dict[str, Meaning] = {
    **_of(
        "scene",
        albedo_above_one=("a material reflects more than it receives", "scale its colours"),
        default_lights=("the file has no lights, so some were set up", "give it lights"),
        degenerate_triangles=("triangles without area were left out", NOTHING),
        emission_averaged=("a texture of emission was replaced by its mean", "lights of its own"),
        ignored_extension=("the file uses a glTF extension that is not read", "export without it"),
        missing_file=("a file that is named is not beside the scene", "put it there"),
        no_tangents=("a brushed material has no direction on its surface", "texture coordinates"),
        no_texture_coordinates=("a texture has no coordinates to go by", "texture coordinates"),
        normals_made=("shading normals were made from the triangles", "export normals"),
        opaque=("a transparent material is drawn opaque", NOTHING),
        reflectance_limited=("a material would create energy, so it was made darker", NOTHING),
        texture_reduced=("a texture is so large that it was reduced", NOTHING),
    ),
    **_of(
        "measurement",
        colours_out_of_gamut=("spectra have colours that sRGB has not", NOTHING),
        material_not_reciprocal=("it is another one when light and eye change places", "measure"),
        measurement_has_gaps=("directions far from any sample are carried on", "measure there"),
        measurement_has_holes=("within the samples there are holes", "measure there"),
        measurement_not_reciprocal=("pairs of samples contradict each other", "measure again"),
        samples_below_surface=("samples lie below the surface and were left out", NOTHING),
        samples_below_zero=("samples are negative and were taken as zero", NOTHING),
    ),
    **_of(
        "picture",
        bounces_truncated=("light bounces on after it was followed", "more `bounces`"),
        caustics_spread=("light that glossy surfaces send on is spread evenly", "the reference"),
        code_too_small=("a code is far off what it stands for", "smaller `error`, more `bytes`"),
        drawn_by_formula=("a material with textures has no code", NOTHING),
        environment_left_out=("the environment does not shine", "glossy_prt, direct_to_indirect"),
        environment_too_sharp=("much light comes from a spot of the sky", "a light of type `sun`"),
        facets_within_pixels=("a pixel shows one facet of many", "`detail` footprint, more pixels"),
        gloss_seen_as_matt=("gloss seen in gloss looks matt", "more `second_bands`"),
        indirect_left_out=("light that bounces is left out", "direct_to_indirect"),
        lamp_seen_as_points=("a mirrored lamp shows the points it is taken as", "the reference"),
        light_between_samples=("a light is too near to surfaces", "more `gather_samples`"),
        lights_left_out=("the lamps of the scene do not shine", "direct_to_indirect"),
        lobe_between_rays=(
            "a lobe is narrower than rays are apart",
            "`view_rays`, `lobe_exponent`",
        ),
        lobe_narrower_than_cells=("a lobe is narrower than a cell", "more `cells`"),
        mesh_too_coarse=("shadows change between vertices", "a finer mesh"),
        mirror_blurred=("something like a mirror is blurred", "more `gather_samples`"),
        occluders_too_simple=("shadows are those of a simpler mesh", "more `occluder_vertices`"),
        surfaces_between_samples=("surfaces are smaller than clusters", "more `gather_samples`"),
        textures_left_out=("textures of gloss or normals are not followed", "direct_to_indirect"),
        too_glossy_for_terms=("a few terms do not hold a lobe", "more `terms`"),
        too_sharp_for_bands=("a lobe is sharper than bands", "more `bands`"),
    ),
    **_of(
        "notice",
        codes_pending=("the materials have not been encoded yet", "wait"),
        gl_unavailable=("the CPU draws, because GL does not", "see what it says"),
        indirect_pending=("indirect light has not been precomputed yet", "wait"),
        preview_shown=("a quick version is shown, the whole one is not there yet", "wait"),
    ),
}
"""Every code that there is."""
