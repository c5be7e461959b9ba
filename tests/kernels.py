"""Compile what both halves of the tests need, before they start: side by side they do it twice.

`make test` runs it. A tiny scene with every light and material goes through the reference and all
methods, in a process for each core.
"""

from __future__ import annotations

import multiprocessing
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from engine.methods import METHODS, prepare
from engine.methods.warm import compile_kernels, tiny_scene
from engine.numerics.parallel import thread_count
from engine.reference import render, render_direct
from engine.scene.edits import Edits
from engine.store import Store

SETTINGS: dict[str, dict[str, Any]] = {
    "brdf_editing": {"gather_samples": 256, "bands": 8, "second_bands": 4, "bounces": 1},
    "glossy_prt": {"light_texels": 8, "visibility_texels": 8, "coarse_texels": 8, "terms": 2},
}


def reference() -> None:
    """Paths, and direct light."""
    render(tiny_scene(), samples=1)
    render_direct(tiny_scene(), samples=1)


def brdf_editing() -> None:
    """A product, with a material in hand."""
    _draw("brdf_editing", Edits(materials={"material 0": {}}))


def glossy_prt() -> None:
    """A product, and a picture."""
    _draw("glossy_prt", Edits())


def direct_to_indirect() -> None:
    """What a service compiles when it starts, which it then need not."""
    compile_kernels()


def _draw(method: str, edits: Edits) -> None:
    settings = METHODS[method].settings(**SETTINGS[method])
    with tempfile.TemporaryDirectory() as folder:
        product = prepare(tiny_scene(), method, settings, store=Store(Path(folder)))
        for scale in (1, 2):
            product.relight(edits, scale, "cpu")


JOBS: tuple[Callable[[], None], ...] = (reference, brdf_editing, direct_to_indirect, glossy_prt)

if __name__ == "__main__":
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(thread_count(), mp_context=context) as pool:
        for job in [pool.submit(job) for job in JOBS]:
            job.result()
