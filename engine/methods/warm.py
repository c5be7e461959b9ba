"""Compile the kernels before somebody waits for a picture.

Numba compiles a kernel at its first call and keeps the machine code in a folder named after the
engine's sources (`engine._cache`). A tiny scene with every kind of light and material, seen through
the preview and through a product, calls all that a session calls. Numba compiles one kernel at a
time in a process, so that pictures and transport are compiled in a process each.
"""

from __future__ import annotations

import multiprocessing
import queue
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

from engine.backend.gl.bvh import build_tree
from engine.brdf.table import MODELS
from engine.light.cube_disk import covered
from engine.light.table import LIGHTS
from engine.methods import METHODS, prepare
from engine.methods.base import Progress, silent
from engine.methods.fixed_view.preview import DirectPreview
from engine.numerics.display import to_srgb8
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene
from engine.store import Store

METHOD = "direct_to_indirect"
GATHER_SAMPLES = 256
MARKER = "compiled"
POLL_SECONDS = 0.5

Report = Callable[[float], None]


def compile_kernels(progress: Progress = silent) -> None:
    """Fill the folder of compiled kernels, once for these sources; takes a minute or so.

    What cannot be compiled now is compiled when it is needed: nothing is raised for it.
    """
    folder = numba.config.CACHE_DIR
    marker = Path(folder) / MARKER if folder else None
    if marker is None or marker.exists():
        return
    # Children started afresh share nothing with this process but the folder.
    context = multiprocessing.get_context("spawn")
    reports: Any = context.Queue()
    workers = {
        name: context.Process(target=_work, args=(name, reports), daemon=True) for name in PARTS
    }
    for name, worker in workers.items():
        progress(f"compiling for {name}, once", 0, 1)
        worker.start()
    while any(worker.is_alive() for worker in workers.values()) or not reports.empty():
        try:
            name, done = reports.get(timeout=POLL_SECONDS)
        except queue.Empty:
            continue
        progress(f"compiling for {name}, once", done, 1)
    if all(worker.exitcode == 0 for worker in workers.values()):
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()


def _work(name: str, reports: Any) -> None:
    # Ctrl-C is the parent's affair; it ends this process too.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    PARTS[name](lambda done: reports.put((name, done)))


def _pictures(report: Report) -> None:
    """Direct light and its way to the screen: what the first pixels need."""
    preview = DirectPreview(tiny_scene())
    report(0.2)
    for scale in (1, 2):
        to_srgb8(preview.relight(Edits(), scale).image, 0.0)
    environment = preview.view.scene.environment
    if environment is not None:
        covered(environment.disk, 8)
    report(1)


def _transport(report: Report) -> None:
    """A precompute, and a product that comes back from the store."""
    shares = {"gather cloud": 0.15, "bounce": 0.6, "final": 0.95}
    settings = METHODS[METHOD].settings(gather_samples=GATHER_SAMPLES)
    with tempfile.TemporaryDirectory() as folder:
        store, scene = Store(Path(folder)), tiny_scene()
        prepare(scene, METHOD, settings, lambda p, *_: report(shares.get(p, 0)), store=store)
        product = prepare(scene, METHOD, settings, store=store)
        for scale in (1, 2):
            product.relight(Edits(), scale, "cpu")
    # Drawing on a GPU needs nothing else that is compiled here.
    build_tree(scene.geometry.positions, scene.geometry.triangles)
    report(1)


PARTS: dict[str, Callable[[Report], None]] = {"pictures": _pictures, "transport": _transport}


def tiny_scene() -> Scene:
    """32 x 32 pixels with every material, every light and its shadows, and an environment."""
    spheres = [
        {
            "name": f"ball {i}",
            "mesh": {"shape": "sphere", "radius": 0.4},
            "material": f"material {i}",
            "transform": {"translate": (i - 0.5 * len(MODELS), 0, 0)},
        }
        for i in range(len(MODELS))
    ]
    floor = {
        "name": "floor",
        "mesh": {"shape": "rectangle", "size": [8, 8]},
        "material": "material 0",
        "transform": {"translate": (0, -0.5, 0), "rotate_degrees": (-90, 0, 0)},
    }
    kinds = [model.model_fields["type"].default for model in MODELS]
    document = {
        "camera": {"position": (0, 1, 4), "target": (0, 0, 0), "width": 32, "height": 32},
        "environment": {"map": "studio", "area_light": {"direction": (0, -1, 0.1)}},
        "lights": [_light(light.model_fields) for light in LIGHTS],
        "materials": {f"material {i}": {"type": kind} for i, kind in enumerate(kinds)},
        "objects": [floor, *spheres],
    }
    return build(describe(document), Path())


def _light(fields: Any) -> dict[str, Any]:
    """A light above the middle, in sight, whatever its kind calls its place."""
    usual = {
        "position": (0, 1.2, 0),
        "target": (0, 0, 0.1),
        "direction": (0, -1, 0.1),
        "width": 0.3,
        "height": 0.3,
        "intensity": (1, 1, 1),
    }
    kind = fields["type"].default
    return {"id": kind, "type": kind, **{k: v for k, v in usual.items() if k in fields}}
