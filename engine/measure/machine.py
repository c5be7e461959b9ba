"""What this machine can do: the yardsticks that timings are divided by."""

from __future__ import annotations

import os
import platform
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from engine.measure.timing import repeat
from engine.numerics.parallel import for_ranges, thread_count
from engine.scene.rays import RayTracer

BANDWIDTH_BYTES = 512 << 20  # far beyond every cache
RAYS = 1 << 18


@dataclass(frozen=True)
class Machine:
    """Facts and measured rates.

    memory_read_gb_s     10⁹ bytes per second that all threads read together, in order
    random_rays_m_s      10⁶ incoherent rays per second that all threads trace, nearest hit
    """

    cpu: str
    threads: int
    memory_gb: float
    system: str
    python: str
    packages: dict[str, str]
    memory_read_gb_s: float
    random_rays_m_s: float

    def as_dict(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)


@cache
def this_machine() -> Machine:
    """Measure once per process, in about two seconds."""
    return Machine(
        cpu=_cpu(),
        threads=thread_count(),
        memory_gb=round(_memory_bytes() / 1e9, 1),
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        packages={name: version(name) for name in ("numpy", "numba", "embreex")},
        memory_read_gb_s=memory_read_bandwidth() / 1e9,
        random_rays_m_s=ray_rate() / 1e6,
    )


@njit(cache=True, nogil=True)
def _sum(start, stop, values):
    total = np.int64(0)
    for k in range(start, stop):
        total += values[k]
    return total


def memory_read_bandwidth(count: int = 7) -> float:
    """Bytes per second that all threads together read from memory, median of `count` passes."""
    size = min(BANDWIDTH_BYTES, _memory_bytes() // 8)
    values = np.ones(size // 8, np.int64)
    timing = repeat(lambda: for_ranges(_sum, len(values), values), count)
    return values.nbytes / timing.median


def ray_rate(count: int = 5) -> float:
    """Nearest hits per second, all threads: random rays in a bumpy sphere of 65 K triangles."""
    tracer = RayTracer(*_bumpy_sphere(128, 256))
    rng = np.random.default_rng(1)
    origins = rng.uniform(-0.5, 0.5, (RAYS, 3)).astype(np.float32)
    directions = rng.normal(size=(RAYS, 3)).astype(np.float32)
    return RAYS / repeat(lambda: tracer.intersect(origins, directions), count).median


def _bumpy_sphere(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (v, 3) float32 and triangles (t, 3) int32."""
    theta, phi = np.meshgrid(
        np.linspace(0.001, np.pi - 0.001, rows + 1),
        np.linspace(0, 2 * np.pi, columns, endpoint=False),
        indexing="ij",
    )
    radius = 1.0 + 0.05 * np.sin(9 * theta) * np.sin(8 * phi)
    positions = radius[..., None] * np.stack(
        [np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=-1
    )
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a, b = row * columns + column, row * columns + (column + 1) % columns
    c, d = a + columns, b + columns
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)])
    return positions.reshape(-1, 3).astype(np.float32), triangles.reshape(-1, 3).astype(np.int32)


def _cpu() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def _memory_bytes() -> int:
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
