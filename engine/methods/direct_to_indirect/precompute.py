"""Precompute: view samples, gather cloud, bounce matrix, final-gather matrix."""

from __future__ import annotations

import hashlib
from concurrent.futures import Executor
from dataclasses import asdict

import numpy as np

from engine.methods.base import Progress
from engine.methods.direct_to_indirect.product import NAME, Transfer
from engine.methods.direct_to_indirect.settings import Settings
from engine.methods.fixed_view.chunks import run_chunks
from engine.methods.fixed_view.cloud import GatherCloud, build_cloud, cloud_arrays, cloud_from
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather import Job
from engine.methods.fixed_view.importance import wavelet_importance
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import pixel_tiles, run_tiles
from engine.methods.fixed_view.view import View
from engine.scene.scene import Scene
from engine.store import Store

VERSION = 8  # of the stored arrays and of what they mean

# Settings that the matrices do not depend on.
AT_RUN_TIME = ("bounces",)


def precompute(
    scene: Scene, settings: Settings, executor: Executor, progress: Progress, store: Store
) -> Transfer:
    """The transfer of a scene: read from the store, finished from its chunks, or made."""
    entry = store.entry(key(scene, settings))
    parts = store.entry(key(scene, settings) + ".parts")
    progress("view samples", 0, 1)
    view = View(scene)
    progress("view samples", 1, 1)

    stored = {name: entry.read(name) for name in ("cloud", "bounce", "final")}
    if stored["cloud"] is None:
        progress("gather cloud", 0, 1)
        cloud = build_cloud(
            scene, view.buffer.centre, settings.gather_samples, settings.position_weight,
            settings.seed,
        )  # fmt: skip
        entry.write("cloud", cloud_arrays(cloud), {"area": cloud.area})
        progress("gather cloud", 1, 1)
    else:
        cloud = cloud_from(stored["cloud"].arrays, stored["cloud"].meta["area"])

    # Each matrix is finished before it is stored, its chunks are let go after that.
    rows = {}
    for name in ("bounce", "final"):
        found = stored[name]
        if found is None:
            job = _job(scene, settings, view, cloud, final=name == "final")
            made = run_chunks(job, name, parts, executor, progress)
            meta = {
                "settings": asdict(settings),
                "rays": int(made["rays"].sum()),
                "kept": float(made["kept"].mean()),
            }
            arrays = {field: made[field] for field in PackedRows._fields}
            entry.write(name, arrays, meta)
            rows[name] = PackedRows(**arrays)
        else:
            rows[name] = PackedRows(**{f: found.arrays[f] for f in PackedRows._fields})
    parts.remove()
    return Transfer(view, settings, cloud, rows["final"], rows["bounce"])


def key(scene: Scene, settings: Settings) -> str:
    """Name of the stored product: a digest of all that it depends on."""
    digest = hashlib.blake2b(digest_size=16)
    fixed = {k: v for k, v in asdict(settings).items() if k not in AT_RUN_TIME}
    for part in (NAME, VERSION, scene.transport_digest, scene.camera.model_dump_json(), fixed):
        digest.update(f"{part}\n".encode())
    return digest.hexdigest()


def _job(scene: Scene, settings: Settings, view: View, cloud: GatherCloud, final: bool) -> Job:
    points: Points = view.buffer.centre if final else cloud.points
    if final:
        tiles = pixel_tiles(scene.camera.width, scene.camera.height)
        tiles = np.where(points.model[tiles] >= 0, tiles, -1).astype(np.int32)
    else:
        tiles = run_tiles(len(cloud))
    return Job(
        positions=scene.geometry.positions,
        triangles=scene.geometry.triangles,
        tiles=tiles,
        position=points.position,
        normal=points.normal,
        geometric=points.geometric,
        leaf_position=cloud.points.position,
        leaf_geometric=cloud.points.geometric,
        clusters=cloud.clusters,
        importance=wavelet_importance(scene, cloud, settings.seed),
        link_size=settings.link_size if final else settings.bounce_link_size,
        patch_size=settings.patch_size,
        coefficients=settings.coefficients if final else settings.bounce_coefficients,
        seed=settings.seed + (1 if final else 2),
        rays=scene.rays,
    )
