"""The terms of a scene's materials: light maps for the precompute, view maps for the picture.

Where the light maps of the three channels are the same but for a factor, as those of a coloured
matt surface are, the factor goes to the view maps: transport is grey then, and one channel of it
is stored. A material whose diffuse reflectance is textured has a term of its own for that, of
reflectance 1, which the texture scales in the picture; where its gloss is in proportion to the
specular reflectance, a texture of that scales the other terms in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import DIFFUSE, Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored, joined
from engine.brdf.factorisation import factor, factor_parts
from engine.scene.scene import Scene

EVEN, DIFFUSE_VARIES, BOTH_VARY = 0, 1, 2
WHITE = (1.0, 1.0, 1.0)
SAME = 1e-4  # of the largest texel: light maps that differ by less are one


@dataclass(frozen=True, eq=False)
class Terms:
    """One material's.

    light     (n, n, K, 1 or 3) float32   light maps g_k, sr⁻¹; one channel where they are grey
    view      (n, n, K, 3) float32        view maps h_k
    textured  EVEN; DIFFUSE_VARIES: term 0 is to be scaled by the diffuse reflectance, which is not
              in it; BOTH_VARY: the others by the specular reflectance as well
    """

    light: NDArray[np.float32]
    view: NDArray[np.float32]
    textured: int

    @property
    def count(self) -> int:
        """K."""
        return self.light.shape[2]

    @property
    def channels(self) -> int:
        """Of the light maps: 1 or 3."""
        return self.light.shape[3]

    @property
    def flat(self) -> NDArray[np.float32]:
        """(n², channels · K): the light maps, all terms of one channel before those of the next."""
        return np.ascontiguousarray(self.light.swapaxes(2, 3).reshape(len(self.light) ** 2, -1))

    def weight_of(self, channels: int) -> NDArray[np.float32]:
        """(channels · K,): how much what a term brings in each channel counts in pictures."""
        strength = np.sqrt((self.view.astype(np.float64) ** 2).mean(axis=(0, 1)))
        if channels == 1:
            strength = np.sqrt((strength**2).mean(axis=1, keepdims=True))
        return strength.T.ravel().astype(np.float32)


def terms_of(scene: Scene, terms: int, texels: int) -> list[Terms]:
    """The terms of every material, `terms` of each that is glossy, on maps of texels x texels."""
    maps = scene.material_table.maps
    return [
        material_terms(material, terms, texels, textured=_textured(material, *maps[index, :2]))
        for index, material in enumerate(scene.materials)
    ]


def _textured(material: Material, diffuse: int, specular: int) -> int:
    """What varies of a material with these textures, -1 for none."""
    if specular >= 0 and material.gloss_is_linear:
        return BOTH_VARY
    return DIFFUSE_VARIES if diffuse >= 0 else EVEN


def material_terms(material: Material, terms: int, texels: int, *, textured: int) -> Terms:
    """See `terms_of`; the factorisation is that of `engine.brdf.factorisation`.

    A coloured material whose gloss is grey by itself gets a grey term more for the matt part:
    that fits a little better, and is less to store than three channels of fewer terms.
    """
    if not textured:
        whole = _grey(factor(material, terms, texels), textured=EVEN)
        if whole.channels == 1:
            return whole
    if textured == BOTH_VARY:
        material = material.model_copy(update={"specular": WHITE})
    base, gloss = factor_parts(material, terms, texels)
    parts = base if isinstance(material, Diffuse) or not gloss.light.any() else joined(base, gloss)
    apart = _grey(parts, textured=textured)
    if textured:
        return apart
    if apart.channels == 3:
        return whole
    apart.view[:, :, 0] *= material.row()[DIFFUSE : DIFFUSE + 3]
    return apart


def _grey(factored: Factored, *, textured: int) -> Terms:
    """Colour moved from the light maps to the view maps, term by term, where that is exact."""
    light, view = factored.light.copy(), factored.view.copy()
    grey = True
    for k in range(factored.terms):
        g = light[:, :, k].reshape(-1, 3).astype(np.float64)
        size = np.linalg.norm(g, axis=0)
        if not size.any():
            continue
        main = int(size.argmax())
        factor_of = g.T @ g[:, main] / size[main] ** 2
        if np.abs(g - g[:, main, None] * factor_of).max() > SAME * np.abs(g).max():
            grey = False
            break
        light[:, :, k] = light[:, :, k, main, None]
        view[:, :, k] *= factor_of.astype(np.float32)
    if grey:
        return Terms(np.ascontiguousarray(light[..., :1]), view, textured)
    return Terms(factored.light, factored.view, textured)
