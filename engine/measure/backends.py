"""The same frames by kernels and by OpenGL: what each takes, and how far apart the pictures are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.backend.choice import Backend, chosen_device
from engine.backend.gl.context import device
from engine.errors import BackendError, InputError
from engine.measure.probes import nudged
from engine.measure.timing import stopwatch
from engine.methods.base import Frame, Product
from engine.scene.edits import Edits

BACKENDS: tuple[Backend, ...] = ("cpu", "gl")
CPU_ALONE = ("brdf_editing",)
UNAVAILABLE = "gl_unavailable"
TURNS = 4  # of every edit, each a step further than the last


def require_gl(method: str) -> None:
    """Raise InputError for a method that the CPU alone draws, BackendError without OpenGL."""
    if method in CPU_ALONE:
        raise InputError(f"frames of {method} are drawn by the CPU alone", field="gl")
    found, notices = chosen_device("gl")
    if found is None:
        raise BackendError(notices[0].message)


def by_backend(product: Product, edits: Sequence[Edits], step: float) -> dict[str, Any]:
    """As JSON: the renderer, median seconds of a frame by each, the largest relative L2 between.

    Every frame is new to both. Raises BackendError where there is no OpenGL, or it fails.
    """
    require_gl(product.method)
    every = [nudged(edit, turn * step) for turn in range(TURNS) for edit in edits]
    warm_up, pictures, seconds = nudged(edits[0], -step), [], {}
    for backend in BACKENDS:
        frames: list[Frame] = [product.relight(warm_up, backend=backend)]
        took = [
            stopwatch(lambda: frames.append(product.relight(edit, backend=backend)))  # noqa: B023
            for edit in every
        ]
        failed = [w.message for frame in frames for w in frame.warnings if w.code == UNAVAILABLE]
        if failed:
            raise BackendError(failed[0])
        pictures.append([frame.image for frame in frames])
        seconds[backend] = float(np.median(took))
    apart = [np.linalg.norm(a - b) / np.linalg.norm(a) for a, b in zip(*pictures, strict=True)]
    return {
        "renderer": device().renderer,
        "seconds": seconds,
        "apart": {"median": float(np.median(apart)), "worst": float(max(apart))},
    }
