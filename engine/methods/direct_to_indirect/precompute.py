"""Precompute: view samples, gather cloud, bounce matrix, final-gather matrix."""

from __future__ import annotations

import hashlib
from concurrent.futures import Executor
from dataclasses import asdict

import numpy as np

from engine.methods.base import Progress
from engine.methods.direct_to_indirect.product import NAME, Transfer, glossy_pixels
from engine.methods.direct_to_indirect.settings import Settings
from engine.methods.fixed_view.chunks import run_chunks
from engine.methods.fixed_view.cloud import GatherCloud, build_cloud, cloud_arrays, cloud_from
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather import Job, Lobes, cosine_lobes
from engine.methods.fixed_view.importance import wavelet_importance
from engine.methods.fixed_view.rows import PackedRows, no_rows
from engine.methods.fixed_view.tiles import pixel_tiles, run_tiles
from engine.methods.fixed_view.view import View, gloss_of
from engine.scene.scene import Scene
from engine.store import Store

VERSION = 9  # of the stored arrays and of what they mean

# Settings that the matrices do not depend on.
AT_RUN_TIME = ("bounces",)

# One bounce, F_d and F_g.
MATRICES = ("bounce", "final", "gloss")


def precompute(
    scene: Scene, settings: Settings, executor: Executor, progress: Progress, store: Store
) -> Transfer:
    """The transfer of a scene: read from the store, finished from its chunks, or made."""
    entry = store.entry(key(scene, settings))
    parts = store.entry(key(scene, settings) + ".parts")
    progress("view samples", 0, 1)
    view = View(scene)
    progress("view samples", 1, 1)

    stored = {name: entry.read(name) for name in ("cloud", *MATRICES)}
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
    for name in MATRICES:
        found = stored[name]
        if found is not None:
            rows[name] = PackedRows(**{f: found.arrays[f] for f in PackedRows._fields})
            continue
        job = _job(name, scene, settings, view, cloud)
        if (job.tiles < 0).all():
            rows[name] = no_rows(len(job.tiles))
            continue
        made = run_chunks(job, name, parts, executor, progress)
        meta = {
            "settings": asdict(settings),
            "rays": int(made["rays"].sum()),
            "kept": float(made["kept"].mean()),
        }
        arrays = {field: made[field] for field in PackedRows._fields}
        entry.write(name, arrays, meta)
        rows[name] = PackedRows(**arrays)
    parts.remove()
    return Transfer(view, settings, cloud, rows["bounce"], rows["final"], rows["gloss"])


def key(scene: Scene, settings: Settings) -> str:
    """Name of the stored product: a digest of all that it depends on."""
    digest = hashlib.blake2b(digest_size=16)
    fixed = {k: v for k, v in asdict(settings).items() if k not in AT_RUN_TIME}
    for part in (NAME, VERSION, scene.transport_digest, scene.camera.model_dump_json(), fixed):
        digest.update(f"{part}\n".encode())
    return digest.hexdigest()


def _job(name: str, scene: Scene, settings: Settings, view: View, cloud: GatherCloud) -> Job:
    """The work of one of MATRICES."""
    bounce, gloss = name == "bounce", name == "gloss"
    points: Points = cloud.points if bounce else view.buffer.centre
    if bounce:
        tiles = run_tiles(len(cloud))
    else:
        tiles = pixel_tiles(scene.camera.width, scene.camera.height)
        wanted = glossy_pixels(view) if gloss else points.model >= 0
        tiles = np.where(wanted[tiles], tiles, -1).astype(np.int32)
    lobes = cosine_lobes(points.normal)
    if gloss:
        lobes = Lobes(points.view, points.model, gloss_of(points.row))
    counts = {
        "final": settings.view_rays,
        "gloss": settings.gloss_rays,
        "bounce": settings.bounce_rays,
    }
    coefficients = {
        "final": settings.coefficients,
        "gloss": settings.gloss_coefficients,
        "bounce": settings.bounce_coefficients,
    }
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
        lobes=lobes,
        # Links know no lobes, so gloss is gathered by rays in any case.
        count=counts[name] if gloss or settings.gather == "rays" else 0,
        link_size=settings.bounce_link_size if bounce else settings.link_size,
        patch_size=settings.patch_size,
        coefficients=coefficients[name],
        seed=settings.seed + 1 + MATRICES.index(name),
        rays=scene.rays,
    )
