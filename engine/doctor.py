"""What of this machine Relight leans on, tried out: threads, Embree, OpenGL, kernels, the store."""

from __future__ import annotations

import math
import os
import platform
import shutil
import time
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import numba
import numpy as np

from engine.backend.choice import VARIABLE, wanted
from engine.backend.gl.context import device
from engine.errors import BackendError, RelightError
from engine.numerics.parallel import thread_count
from engine.scene.rays import RayTracer
from engine.store import Store

RAYS = 1 << 18
LEAST_FREE, LITTLE_FREE = 64e6, 2e9  # bytes of a disk
SLOW_RAYS = 0.5e6  # a second and thread: what Embree does by far
CPU_QUOTA = Path("/sys/fs/cgroup/cpu.max")  # "max 100000", or microseconds of each so many

State = Literal["ok", "note", "broken"]


@dataclass(frozen=True)
class Finding:
    """One thing that was tried.

    what   its name
    state  `note` where something could be better, `broken` where nothing works without it
    says   what was found
    do     what would mend it, a command where there is one
    """

    what: str
    state: State
    says: str
    do: str = ""


def examine(store: Store | None = None) -> list[Finding]:
    """Everything, one after the other, in about a second."""
    return [
        Finding("relight", "ok", f"{version('relight')} on Python {platform.python_version()}"),
        _threads(),
        _embree(),
        _gl(),
        _kernels(),
        _store(store or Store()),
    ]


def _threads() -> Finding:
    count, cores = thread_count(), _cores()
    says = f"{count} threads for {cores:g} cores"
    if count <= math.ceil(cores):
        return Finding("threads", "ok", says)
    advice = f"export RELIGHT_THREADS={math.ceil(cores)}"
    return Finding("threads", "note", f"{says}: they wait for each other", advice)


def _cores() -> float:
    """Cores that this process may use, a container's limit included."""
    able = (
        os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count() or 1)
    )
    cores = float(len(able))
    try:
        quota, period = CPU_QUOTA.read_text().split()
        if quota != "max":
            cores = min(cores, int(quota) / int(period))
    except (OSError, ValueError):
        pass  # no such limit here
    return cores


def _embree() -> Finding:
    """A square of two triangles, and rays that meet it or pass it by."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    rng = np.random.default_rng(1)
    origins = rng.uniform(-2, 2, (RAYS, 3)).astype(np.float32)
    origins[:, 2] = 1
    down = np.tile(np.array([0, 0, -1], np.float32), (RAYS, 1))
    try:
        tracer = RayTracer(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
        start = time.perf_counter()
        hits = tracer.intersect(origins, down)
        rate = RAYS / (time.perf_counter() - start)
    except Exception as error:  # whatever a native library may raise
        return Finding(
            "Embree", "broken", f"does not trace: {error}", "pip install --force-reinstall embreex"
        )
    met = (np.abs(origins[:, :2]) < 1).all(axis=1)
    near_rim = (np.abs(np.abs(origins[:, :2]) - 1) < 1e-4).any(axis=1)
    if ((hits.triangle >= 0) != met)[~near_rim].any():
        return Finding(
            "Embree", "broken", "rays miss what they should meet",
            "pip install --force-reinstall embreex",
        )  # fmt: skip
    says = f"{rate / 1e6:.1f} million rays a second"
    if rate < SLOW_RAYS * thread_count():
        return Finding("Embree", "note", f"{says}: slow, is the machine busy?", "uptime")
    return Finding("Embree", "ok", says)


def _gl() -> Finding:
    asked = wanted()
    if asked == "cpu":
        return Finding("OpenGL", "ok", f"not asked for: {VARIABLE} is cpu")
    try:
        found = device()
    except BackendError as error:
        return Finding(
            "OpenGL", "note", f"the CPU draws all frames: {error}",
            "nothing, or have a GPU's driver installed; in a container of NVIDIA's: --gpus all "
            "-e NVIDIA_DRIVER_CAPABILITIES=all",
        )  # fmt: skip
    if found.software and asked == "auto":
        says = f"{found.renderer} is a software rasteriser: the CPU's kernels are quicker and draw"
        return Finding("OpenGL", "ok", says)
    return Finding("OpenGL", "ok", f"{found.renderer} draws")


def _kernels() -> Finding:
    folder = Path(numba.config.CACHE_DIR)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _try_to_write(folder)
    except OSError as error:
        return Finding(
            "kernels", "note",
            f"every start compiles anew, for a minute: {folder} cannot be written: "
            f"{error.strerror}",
            "export NUMBA_CACHE_DIR=a folder that can",
        )  # fmt: skip
    count = sum(1 for _ in folder.rglob("*.nbc"))
    if count == 0:
        return Finding("kernels", "note", "none compiled: the first start takes a minute longer")
    return Finding("kernels", "ok", f"{count} compiled, in {folder}")


def _store(store: Store) -> Finding:
    root, advice = store.root, "export RELIGHT_STORE=a folder elsewhere"
    try:
        entry = store.entry(f"doctor-{os.getpid()}")
        entry.write("probe", {"numbers": np.arange(1000)}, {})
        read = entry.read("probe")
        entry.remove()
    except (RelightError, OSError) as error:
        return Finding("store", "broken", f"nothing can be kept: {error}", advice)
    if read is None or (read.arrays["numbers"] != np.arange(1000)).any():
        says = f"{store.where} does not give back what was written"
        return Finding("store", "broken", says, advice)
    free = shutil.disk_usage(root).free
    used = sum(file.stat().st_size for file in root.rglob("*") if file.is_file())
    says = f"{used / 1e9:.2f} GB in {root}, {free / 1e9:.1f} GB free"
    if store.where != str(root):
        says = f"{store.where} keeps what it is given; of copies there are {says}"
    if free < LITTLE_FREE:
        state: State = "broken" if free < LEAST_FREE else "note"
        clean = f"rm -r {root}: all of it can be made again; or {advice}"
        return Finding("store", state, f"{says}: little", clean)
    return Finding("store", "ok", says)


def _try_to_write(folder: Path) -> None:
    probe = folder / f".doctor-{os.getpid()}"
    probe.write_bytes(b"")
    probe.unlink()
