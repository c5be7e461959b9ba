"""How well the terms fit the materials: found once at precompute, kept with them, told to the user.

The error is of the BRDF, over all pairs of directions (`engine.brdf.fit`): what a point light would
show. Under soft light a picture is off by less, see `docs/glossy_prt.md`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from engine.brdf.base import DIFFUSE, SPECULAR, Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored
from engine.brdf.fit import Fit, fit_diagnosis, fit_of
from engine.diagnosis import Diagnosis
from engine.methods.base import MaterialFit, Progress
from engine.methods.glossy_prt.terms import BOTH_VARY, Terms
from engine.scene.scene import Scene
from engine.store import Entry

BOUND = 0.5  # of the fit's error: beyond it a highlight is hardly one any more, and that is said
EXACT = Fit(0.0, 1.0, 0.0, 1, 1.0)


class Fits(NamedTuple):
    """Of the materials that something is made of; what to say if some fit badly."""

    materials: tuple[MaterialFit, ...]
    said: tuple[Diagnosis, ...]


def fits_of(scene: Scene, terms: list[Terms], entry: Entry, progress: Progress) -> Fits:
    """The fits of a scene's materials, from the store or made, a second for each glossy one."""
    used = np.unique(scene.geometry.material).tolist()
    factored = [_factored(t, m) for t, m in zip(terms, scene.materials, strict=True)]
    found = entry.read("fits")
    if found is not None:
        fits = [Fit(*row) for row in found.meta["fits"]]
    else:
        fits = []
        for k, m in enumerate(used):
            progress("fits of materials", k, len(used))
            material = scene.materials[m]
            matt = isinstance(material, Diffuse)
            fits.append(EXACT if matt else fit_of(material, factored[m], BOUND))
        entry.write("fits", {}, {"fits": [list(fit) for fit in fits]})
    each = tuple(
        MaterialFit(scene.material_names[m], terms[m].count, terms[m].channels, fit.error)
        for m, fit in zip(used, fits, strict=True)
    )
    worst = int(np.argmax([fit.error for fit in fits]))
    told = fit_diagnosis(each[worst].name, fits[worst], factored[used[worst]], BOUND)
    others = [repr(e.name) for k, e in enumerate(each) if k != worst and e.error > BOUND]
    if told is not None and others:
        told = Diagnosis(
            told.code, f"{told.message} Too glossy as well: {', '.join(others)}.", told.size
        )
    return Fits(each, () if told is None else (told,))


def _factored(terms: Terms, material: Material) -> Factored:
    """The terms of a whole material, what a texture scales in the picture scaled by its factor."""
    view = terms.view
    if terms.textured:
        view = view.copy()
        view[:, :, 0] *= material.row()[DIFFUSE : DIFFUSE + 3]
    if terms.textured == BOTH_VARY:
        view[:, :, 1:] *= material.row()[SPECULAR : SPECULAR + 3]
    return Factored(np.broadcast_to(terms.light, view.shape), view)
