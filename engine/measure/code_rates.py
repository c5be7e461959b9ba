"""Table 2 of `wavelet_brdf` (Claustres, Barthe, Paulin 2007, §6.3): frames per second by level of
detail and filter, and how many values a second there are.

As in the paper there is one point light and no shadow. Level 4 is the finest here, as there; our
settings count the other way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.choice import Backend, chosen_device
from engine.backend.gl.brdfs import Evaluation
from engine.brdf import evaluate, library
from engine.brdf.built_in import BUILT_IN
from engine.brdf.measured import KEY, NEAREST, Measured, at_level
from engine.brdf.table import INDEX
from engine.measure.code_stage import METHOD, lit, measured
from engine.measure.document import table
from engine.measure.fresh import fresh
from engine.measure.settings import settings_from
from engine.measure.stage import Thing
from engine.measure.timing import repeat
from engine.methods import METHODS
from engine.methods.base import Product, Progress, silent
from engine.methods.wavelet_brdf.settings import FILTERS
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec
from engine.scene.edits import Edits

LEVELS = 5
FRAMES, PAIRS, REPEATS = 7, 1 << 20, 5
MATERIAL = "plastic"
PAPER = {"nearest": (390, 258, 192, 152, 124), "bilinear": (206, 90, 56, 41, 31)}
MOVES = {"light": "light moved", "camera": "camera moved"}


def rates(
    thing: Thing,
    size: tuple[int, int],
    fixed: Mapping[str, Any],
    progress: Progress = silent,
    pairs: int = PAIRS,
) -> dict[str, Any]:
    """Frames and values per second as JSON; `fixed` are further settings."""
    material = measured(MATERIAL)
    scene = lit(thing, material, size)
    device, _ = chosen_device("gl")
    backends: list[Backend] = ["cpu", "gl"] if device is not None else ["cpu"]
    rows = []
    for turn, kind in enumerate(FILTERS):
        for level in range(LEVELS):
            progress("levels", turn * LEVELS + level, len(FILTERS) * LEVELS)
            chosen = {"shadows": False, **fixed, "detail": "finest", "filter": kind}
            chosen["level"] = float(LEVELS - 1 - level)
            with fresh(scene, METHOD, settings_from(METHODS[METHOD].settings, chosen)) as made:
                for backend in backends:
                    fps = {move: frames_per_second(made.product, move, backend) for move in MOVES}
                    rows.append({"backend": backend, "filter": kind, "level": level, **fps})
    shown = settings_from(METHODS[METHOD].settings, {"shadows": False, **fixed})
    return {
        "object": thing.name,
        "triangles": len(scene.geometry.triangles),
        "width": size[0],
        "height": size[1],
        "pixels_of_object": _covered(scene, shown),
        "material": MATERIAL,
        "settings": asdict(shown),
        "gl": None
        if device is None
        else {"renderer": device.renderer, "software": device.software},
        "frames_per_second": rows,
        "values_per_second": {name: _values_of(name, pairs) for name in BUILT_IN},
        "pairs": pairs,
        "paper": PAPER,
    }


def _covered(scene: Any, settings: Any) -> int:
    with fresh(scene, METHOD, settings) as made:
        return int((made.product.relight(Edits()).image.max(axis=2) > 0).sum())


def frames_per_second(product: Product, move: str, backend: Backend | None) -> float:
    """Median over frames that each have another light or another camera."""
    scene = product.scene  # type: ignore[attr-defined]
    eye, place = np.array(scene.camera.position), np.array(scene.lights[0].position)
    turn = iter(np.linspace(0.0, 0.5, FRAMES + 1))

    def frame() -> None:
        angle = next(turn)
        c, s = np.cos(angle), np.sin(angle)
        spin = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        edits = (
            Edits(lights=[{"id": scene.lights[0].id, "position": tuple((spin @ place).tolist())}])
            if move == "light"
            else Edits(camera={"position": tuple((spin @ eye).tolist())})
        )
        product.relight(edits, backend=backend)

    return 1.0 / repeat(frame, FRAMES).median


def values_per_second(row: NDArray[np.float32], model: int, pairs: int) -> float:
    """Of one material, for pairs at random, by one call for all."""
    rng = np.random.default_rng(1)
    wi, wo = _hemisphere(rng, pairs), _hemisphere(rng, pairs)
    return pairs / repeat(lambda: evaluate(model, row, wi, wo), REPEATS).median


def _values_of(name: str, pairs: int) -> dict[str, float | None]:
    """Of one material at the finest level, for pairs that have nothing to do with each other."""
    rng, row, model = np.random.default_rng(1), measured(name).row(), INDEX[Measured]
    wi, wo = _hemisphere(rng, pairs), _hemisphere(rng, pairs)
    block = library.filed(*row[KEY : KEY + 2].tolist())
    assert block is not None
    out = np.zeros((pairs, 3))
    args = (np.uint64(block.ctypes.data), wi, wo, False, out)
    snapped = (np.uint64(block.ctypes.data), wi, wo, True, out)
    device, _ = chosen_device("gl")

    def per_second(call: Callable[[], Any]) -> float:
        return pairs / repeat(call, REPEATS).median

    found: dict[str, float | None] = {
        "one thread": per_second(lambda: _pairs(0, pairs, *args)),
        "all threads": per_second(lambda: for_ranges(_pairs, pairs, *args)),
        "all threads, nearest": per_second(lambda: for_ranges(_pairs, pairs, *snapped)),
        "engine.brdf.evaluate": per_second(lambda: evaluate(model, row, wi, wo)),
    }
    if device is not None:
        some = slice(0, min(pairs, 1 << 17) if device.software else pairs)
        for label, nearest in (("GL", 0.0), ("GL, nearest", 1.0)):
            row[NEAREST] = nearest
            run = Evaluation(device, model, row, wi[some], wo[some])
            found[label] = per_second(run.run) * (some.stop / pairs)
    return found


def _hemisphere(rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    w = rng.normal(size=(count, 3))
    w[:, 2] = np.abs(w[:, 2]) + 1e-3
    return w / np.linalg.norm(w, axis=1, keepdims=True)


@njit(cache=True, nogil=True)
def _pairs(start, stop, a, wi, wo, nearest, out):
    for i in range(start, stop):
        r, g, b = at_level(a, vec(wi, i), vec(wo, i), 0.0, nearest)
        out[i, 0], out[i, 1], out[i, 2] = r, g, b


def markdown(document: dict[str, Any]) -> list[str]:
    """Lines of table 2 and of the values per second."""
    gl, rows = document["gl"], document["frames_per_second"]
    if gl is None:
        drawn = "There is no GL here."
    else:
        kind = "a software rasteriser" if gl["software"] else "hardware"
        drawn = f"GL is {gl['renderer']}, {kind}."
    lines = [
        "## Frames per second by level (the paper's table 2)",
        "",
        f"{document['object']}, {document['triangles']:,} triangles, on "
        f"{document['pixels_of_object']:,} pixels of {document['width']} x {document['height']}; "
        f"{document['material']}, one point light without shadows. {drawn} Level 4 is the finest.",
        "",
    ]
    body = []
    for backend in dict.fromkeys(row["backend"] for row in rows):
        for kind in FILTERS[::-1]:
            for move, label in MOVES.items():
                here = [r for r in rows if (r["backend"], r["filter"]) == (backend, kind)]
                here.sort(key=lambda row: int(row["level"]))
                body.append([backend, kind, label, *(f"{row[move]:.3g}" for row in here)])
    for kind, printed in document["paper"].items():
        body.append(["the paper, GeForce 7800 GTX", kind, "", *map(str, printed)])
    head = ["", "filter", "", *(f"level {level}" for level in range(LEVELS))]
    lines += [*table(head, body, names=3), "", "## Values per second, millions", ""]
    values = document["values_per_second"]
    names = list(next(iter(values.values())))
    cells = [[name, *(f"{v[name] / 1e6:.3g}" for v in values.values())] for name in names]
    cells.append(["the paper: GPU, CPU", *["49, 0.32"] * len(values)])
    random = f"Of {document['pairs']:,} random pairs, at the finest level, bilinear unless said."
    return [*lines, random, "", *table(["", *values], cells), ""]
