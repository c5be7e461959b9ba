"""Each method on a scene of its kind, so small that it is precomputed in a second or two."""

from __future__ import annotations

import hashlib
from concurrent.futures import Executor
from functools import cache
from pathlib import Path
from typing import Any

from methods.scenes import cornell, small_knot

from engine.methods import METHODS, prepare
from engine.methods.base import Product, Progress, silent
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

# Chunks are 64 tiles of 64 points, 4096 pixels, or a cluster of vertices: there are several each.
SETTINGS: dict[str, dict[str, Any]] = {
    "direct_to_indirect": {
        "gather_samples": 256,
        "opening_rays": 64,
        "coefficients": 16,
        "bounce_coefficients": 16,
        "view_rays": 16,
        "bounce_rays": 16,
    },
    "brdf_editing": {
        "gather_samples": 1024,
        "bounce_coefficients": 16,
        "view_rays": 16,
        "bounce_rays": 16,
        "second_bands": 8,
    },
    "glossy_prt": {
        "light_texels": 8,
        "visibility_texels": 8,
        "coarse_texels": 8,
        "gather_texels": 8,
        "brdf_texels": 16,
    },
    "wavelet_brdf": {"cells": 8},
}


@cache
def small_scene(method: str) -> Scene:
    """A knot where a method needs gloss, else the box under its spot alone."""
    if method in ("glossy_prt", "wavelet_brdf"):
        return small_knot(32, 32, 16)
    box = cornell(112)
    return box.with_lights(box.lights[1:])


def made(
    method: str,
    folder: Path | str,
    executor: Executor | None = None,
    progress: Progress = silent,
) -> Product:
    """The small product, from a store or into it."""
    settings = METHODS[method].settings(**SETTINGS[method])
    scene = small_scene(method)
    return prepare(scene, method, settings, progress, store=Store(folder), executor=executor)


def digest(product: Product) -> str:
    """Of its picture and size: products that differ in a bit differ here, but by rare chance."""
    image = product.relight(Edits(), backend="cpu").image
    return hashlib.blake2b(image.tobytes() + str(product.bytes).encode()).hexdigest()
