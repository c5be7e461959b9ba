"""Precompute: view samples, gather cloud, bounce matrix, final-gather matrix."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.methods.base import Progress
from engine.methods.chunks import run_chunks
from engine.methods.direct_to_indirect.product import NAME, Transfer
from engine.methods.direct_to_indirect.reflected import glossy_pixels
from engine.methods.direct_to_indirect.settings import Settings
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.environment_light import EnvironmentRows
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather import ENVIRONMENT, Job, Lobes, cosine_lobes, gather_chunk
from engine.methods.fixed_view.importance import wavelet_importance
from engine.methods.fixed_view.rows import PackedRows, no_rows
from engine.methods.fixed_view.stored import gather_job, part_key, stored_cloud
from engine.methods.fixed_view.tiles import pixel_tiles, run_tiles
from engine.methods.fixed_view.view import View, gloss_of
from engine.scene.scene import Scene
from engine.store import Store

VERSION = 13  # of the stored arrays and of what they mean

# Wavelets of the environment by those of surfaces. Gloss shows the environment's details.
OF_ENVIRONMENT = {"bounce": 0.5, "final": 0.5, "gloss": 1.5}

# One bounce, F_d and F_g.
MATRICES = ("bounce", "final", "gloss")

_CLOUD = ("gather_samples", "cloud", "position_weight", "seed")
_VIEW = (*_CLOUD, "gather", "patch_size", "link_size", "opening_rays")
NEEDS = {
    "cloud": _CLOUD,
    "bounce": (
        *(*_CLOUD, "gather", "patch_size"),
        *("bounce_coefficients", "bounce_rays", "bounce_link_size"),
    ),
    "final": (*_VIEW, "coefficients", "view_rays"),
    "gloss": (*_VIEW, "gloss_coefficients", "gloss_rays"),
}
"""The settings that each stored part depends on, of which another one is made for others."""


def precompute(
    scene: Scene, settings: Settings, executor: Executor, progress: Progress, store: Store
) -> Transfer:
    """The transfer of a scene: read from the store, finished from its chunks, or made."""
    progress("view samples", 0, 1)
    view = View(scene)
    progress("view samples", 1, 1)

    entries = {name: store.entry(key(scene, settings, name)) for name in NEEDS}
    stored = {name: entries[name].read(name) for name in MATRICES}
    cloud = stored_cloud(entries["cloud"], view, settings, settings.cloud, progress)

    # Each matrix is finished before it is stored, its chunks are let go after that.
    rows, beyond = {}, {}
    importance = None
    for name in MATRICES:
        found = stored[name]
        if found is not None:
            rows[name], beyond[name] = _both(found.arrays)
            continue
        tiles = _tiles(name, view, cloud)
        if (tiles < 0).all():
            rows[name] = beyond[name] = no_rows(len(tiles))
            continue
        if importance is None:
            progress("importance", 0, 1)
            importance = wavelet_importance(scene, cloud, settings.seed)
            progress("importance", 1, 1)
        job = _job(name, settings, view, cloud, tiles, importance)
        parts = store.entry(key(scene, settings, name) + ".parts")
        made = run_chunks(partial(gather_chunk, job), job.chunks, name, parts, executor, progress)
        meta = {
            "settings": asdict(settings),
            "rays": int(made["rays"].sum()),
            "kept": float(made["kept"].mean()),
        }
        entries[name].write(name, {k: a for k, a in made.items() if k not in meta}, meta)
        parts.remove()
        rows[name], beyond[name] = _both(made)
    return Transfer(view, settings, cloud, **rows, environment=EnvironmentRows(**beyond))


def _both(arrays: Mapping[str, NDArray[Any]]) -> tuple[PackedRows, PackedRows]:
    """Rows of gather samples and of environment samples."""
    names = PackedRows._fields
    return (
        PackedRows(*(arrays[name] for name in names)),
        PackedRows(*(arrays[ENVIRONMENT + name] for name in names)),
    )


def key(scene: Scene, settings: Settings, part: str) -> str:
    """Name of a stored part of NEEDS: a digest of all that it depends on."""
    return part_key(NAME, VERSION, scene, settings, NEEDS[part])


def _tiles(name: str, view: View, cloud: GatherCloud) -> NDArray[np.int32]:
    """(m, 64) points that have a row in one of MATRICES, -1 for none."""
    if name == "bounce":
        return run_tiles(len(cloud))
    camera = view.scene.camera
    wanted = glossy_pixels(view) if name == "gloss" else view.buffer.centre.model >= 0
    tiles = pixel_tiles(camera.width, camera.height)
    return np.where(wanted[tiles], tiles, -1).astype(np.int32)


def _job(
    name: str,
    settings: Settings,
    view: View,
    cloud: GatherCloud,
    tiles: NDArray[np.int32],
    importance: NDArray[np.float32],
) -> Job:
    """The work of one of MATRICES."""
    scene, s = view.scene, settings
    points: Points = cloud.points if name == "bounce" else view.buffer.centre
    coefficients, rays, link_size = {
        "bounce": (s.bounce_coefficients, s.bounce_rays, s.bounce_link_size),
        "final": (s.coefficients, s.view_rays, s.link_size),
        "gloss": (s.gloss_coefficients, s.gloss_rays, s.link_size),
    }[name]
    gloss = name == "gloss"
    return gather_job(
        scene,
        cloud,
        points,
        tiles=tiles,
        importance=importance,
        lobes=(
            Lobes(points.view, points.model, gloss_of(points.row))
            if gloss
            else cosine_lobes(points.normal)
        ),
        # Links know no lobes, so gloss is gathered by rays in any case.
        count=rays if gloss or s.gather == "rays" else 0,
        opening_rays=0 if name == "bounce" else s.opening_rays,
        link_size=link_size,
        patch_size=s.patch_size,
        coefficients=coefficients,
        environment_coefficients=max(1, int(OF_ENVIRONMENT[name] * coefficients)),
        seed=s.seed + 1 + MATRICES.index(name),
    )
