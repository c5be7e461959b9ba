"""What fixed-view methods store alike: where its parts lie, their gather cloud, gather jobs."""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from typing import Any

from engine.methods.base import Progress
from engine.methods.fixed_view.cloud import (
    GatherCloud,
    Spread,
    build_cloud,
    cloud_arrays,
    cloud_from,
)
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather import Job
from engine.methods.fixed_view.view import View
from engine.scene.scene import Scene
from engine.store import Entry


def part_key(
    method: str, version: int, scene: Scene, settings: Any, needed: Collection[str]
) -> str:
    """Name of a stored part of a product: a digest of all that it depends on.

    version is that of the method's arrays; of the settings they depend on those that are `needed`.
    """
    digest = hashlib.blake2b(digest_size=16)
    chosen = {name: getattr(settings, name) for name in sorted(needed)}
    for part in (method, version, scene.transport_digest, scene.camera.model_dump_json(), chosen):
        digest.update(f"{part}\n".encode())
    return digest.hexdigest()


def stored_cloud(
    entry: Entry, view: View, settings: Any, spread: Spread, progress: Progress
) -> GatherCloud:
    """The cloud of an entry, built into it where it is not there.

    settings has `gather_samples`, `position_weight` and `seed`.
    """
    found = entry.read("cloud")
    if found is not None:
        return cloud_from(found.arrays)
    progress("gather cloud", 0, 1)
    cloud = build_cloud(
        view.scene, view.buffer.centre, settings.gather_samples, settings.position_weight, spread,
        settings.seed,
    )  # fmt: skip
    entry.write("cloud", cloud_arrays(cloud), {})
    progress("gather cloud", 1, 1)
    return cloud


def gather_job(scene: Scene, cloud: GatherCloud, points: Points, **rest: Any) -> Job:
    """The job of points that gather from a cloud; `rest` as in `Job`."""
    return Job(
        positions=scene.geometry.positions,
        triangles=scene.geometry.triangles,
        position=points.position,
        normal=points.normal,
        geometric=points.geometric,
        leaf_position=cloud.points.position,
        leaf_geometric=cloud.points.geometric,
        clusters=cloud.clusters,
        rays=scene.rays,
        **rest,
    )
