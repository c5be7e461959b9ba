"""References that the store keeps: a converged picture of a scene under an edit."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.light.table import light_table
from engine.methods.base import Progress, silent
from engine.reference import render
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Store

# Part of every key: raise it when the reference renderer gives other pictures.
VERSION = 1


@dataclass(frozen=True)
class Truth:
    """A reference picture.

    image     (h, w, 3) float32, linear radiance
    variance  (h, w, 3) float32, of each of its values
    error     its own relative L2 error, estimated from its variance
    seconds   that it took, when it was rendered
    samples   per pixel
    """

    image: NDArray[np.float32]
    variance: NDArray[np.float32]
    error: float
    seconds: float
    samples: int


def truth(
    scene: Scene,
    edits: Edits,
    error: float,
    store: Store,
    progress: Progress = silent,
    seed: int = 0,
    max_bounces: int | None = None,
) -> Truth:
    """The picture of the scene under the edits to a relative L2 error, from the store if it can.

    Each seed has noise of its own; `max_bounces` is that of `engine.reference.render`.
    """
    edited = apply(scene, edits)
    name = f"reference-{_digest(edited, error)}"
    name += "" if max_bounces is None else f"-bounces-{max_bounces}"
    entry = store.entry(name + (f"-{seed}" if seed else ""))
    found = entry.read("picture")
    if found is None:
        result = render(edited, error=error, seed=seed, max_bounces=max_bounces, progress=progress)
        entry.write(
            "picture",
            {"image": result.image, "variance": result.variance},
            {"error": result.error, "seconds": result.seconds, "samples": result.samples},
        )
        return Truth(result.image, result.variance, result.error, result.seconds, result.samples)
    return Truth(found.arrays["image"], found.arrays["variance"], **found.meta)


def _digest(scene: Scene, error: float) -> str:
    """Everything that the picture depends on."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(f"{VERSION} {error!r} {scene.transport_digest} ".encode())
    digest.update(scene.camera.model_dump_json().encode())
    for light in scene.lights:
        digest.update(light.model_dump_json().encode())
    digest.update(light_table(scene.lights).texels.data)
    if scene.environment is not None:
        digest.update(scene.environment.description.model_dump_json().encode())
        digest.update(np.ascontiguousarray(scene.environment.radiance).data)
    return digest.hexdigest()
