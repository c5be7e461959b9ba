"""References that the store keeps: a converged picture of a scene under an edit."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.light.table import light_table
from engine.measure.edges import pixels_that_count
from engine.methods.base import Progress, silent
from engine.reference import render
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Entry, Store

# Part of every key: raise it when the reference renderer gives other pictures.
VERSION = 2


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
    max_seconds: float | None = None,
) -> Truth:
    """The picture of the scene under the edits to a relative L2 error, from the store if it can.

    The error is that of the pixels that count. Each seed has noise of its own; the limits are those
    of `engine.reference.render`.
    """
    edited = apply(scene, edits)
    entry = store.entry(_name(edited, error, seed, max_bounces, max_seconds))
    found = _read(entry)
    if found is not None:
        return found
    result = render(
        edited, error=error, seed=seed, max_bounces=max_bounces, max_seconds=max_seconds,
        counted=pixels_that_count(edited), progress=progress,
    )  # fmt: skip
    entry.write(
        "picture",
        {"image": result.image, "variance": result.variance},
        {"error": result.error, "seconds": result.seconds, "samples": result.samples},
    )
    return Truth(result.image, result.variance, result.error, result.seconds, result.samples)


def known_truth(
    scene: Scene, edits: Edits, error: float, store: Store, max_seconds: float
) -> Truth | None:
    """What `truth` has left in the store; None where it has not been asked."""
    return _read(store.entry(_name(apply(scene, edits), error, 0, None, max_seconds)))


def _name(
    scene: Scene, error: float, seed: int, max_bounces: int | None, max_seconds: float | None
) -> str:
    name = f"reference-{picture_digest(scene, error)}"
    name += "" if max_bounces is None else f"-bounces-{max_bounces}"
    name += "" if max_seconds is None else f"-within-{max_seconds:g}-s"
    return name + (f"-{seed}" if seed else "")


def _read(entry: Entry) -> Truth | None:
    found = entry.read("picture")
    if found is None:
        return None
    return Truth(found.arrays["image"], found.arrays["variance"], **found.meta)


def picture_digest(scene: Scene, error: float) -> str:
    """Everything that a reference depends on: the scene, its light, its camera."""
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
