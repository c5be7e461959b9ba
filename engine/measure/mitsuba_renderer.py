"""A scene in Mitsuba 3, alone and through Open Image Denoise.

Mitsuba's scene is made and its kernels are compiled before anything is timed. The denoiser gets
albedo and normals of the fixed view, which are made once without noise, as our transport is.
"""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.measure.mitsuba_variant import fastest_variant
from engine.scene.scene import Scene

PASS = 1 << 22  # samples that Mitsuba holds in memory at once
GUIDE_SAMPLES = 64

Image = NDArray[np.float32]

# Say what is missing before there is work to lose. They are imported when it is clear how.
for _name in ("mitsuba", "mitsuba_oidn"):
    if find_spec(_name) is None:
        raise ModuleNotFoundError(f"no module named {_name}", name=_name.replace("_", "-"))


def take_fastest() -> tuple[str, str]:
    """Use the fastest variant that runs here; (its name, Mitsuba's version)."""
    variant = fastest_variant()
    import mitsuba as mi

    mi.set_variant(variant)
    return variant, str(mi.__version__)


class Mitsuba:
    """A scene that is ready to be rendered."""

    def __init__(self, scene: Scene, max_bounces: int | None = None) -> None:
        import mitsuba as mi

        from engine.measure.mitsuba_scene import mitsuba_scene

        with tempfile.TemporaryDirectory(prefix="relight-mitsuba-") as folder:
            self._scene = mitsuba_scene(scene, Path(folder), max_bounces)
        self._pixels = scene.camera.width * scene.camera.height
        # Albedo and normals of the first hits, for the denoiser.
        guides = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal"})
        picture = np.array(mi.render(self._scene, integrator=guides, spp=GUIDE_SAMPLES), np.float32)
        self._albedo = np.ascontiguousarray(picture[..., :3])
        self._normal = np.ascontiguousarray(picture[..., 3:6])

    def picture(self, samples: int, seed: int) -> Image:
        """(h, w, 3) float32, linear radiance."""
        import mitsuba as mi

        most = max(1, PASS // self._pixels)
        total = np.zeros(0, np.float32)
        for done in range(0, samples, most):
            count = min(most, samples - done)
            part = np.array(mi.render(self._scene, spp=count, seed=1000 * seed + done), np.float32)
            total = part * count if not done else total + part * count
        return total / np.float32(samples)

    def denoised(self, samples: int, seed: int, quality: str) -> Image:
        """The same through the denoiser."""
        import mitsuba_oidn as oidn

        noisy, level = self.picture(samples, seed), oidn.Quality[quality]
        guides = (self._albedo, self._normal)
        clean = oidn.denoise(noisy, *guides, hdr=True, clean_aux=True, quality=level)
        return np.array(clean, np.float32)
