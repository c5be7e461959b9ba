"""Precompute: the codes of a scene's materials."""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np

from engine.methods.base import Progress
from engine.methods.wavelet_brdf.codes import codes_of
from engine.methods.wavelet_brdf.product import Wavelets
from engine.methods.wavelet_brdf.settings import Settings
from engine.scene.scene import Scene
from engine.store import Store


def precompute(
    scene: Scene, settings: Settings, executor: Executor, progress: Progress, store: Store
) -> Wavelets:
    """Codes from the store, or made into it: a second or two for each material."""
    used = np.unique(scene.geometry.material).tolist()
    codes = codes_of(scene, scene.materials, settings, store, used, progress, executor)
    return Wavelets(scene, settings, codes, store)
