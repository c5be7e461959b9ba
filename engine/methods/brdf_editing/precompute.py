"""Precompute: view samples, gather cloud, one bounce, what rays meet."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np

from engine.light.base import Light
from engine.methods.base import Progress
from engine.methods.brdf_editing.hand import Transport
from engine.methods.brdf_editing.links import Job as LinkJob
from engine.methods.brdf_editing.links import link_chunk
from engine.methods.brdf_editing.patterns import Patterns, patterns
from engine.methods.brdf_editing.product import NAME, Polynomial
from engine.methods.brdf_editing.second_tables import second_patterns
from engine.methods.brdf_editing.settings import Settings
from engine.methods.chunks import Arrays, run_chunks
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.environment_light import EnvironmentLight, EnvironmentRows
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather import ENVIRONMENT, cosine_lobes, gather_chunk
from engine.methods.fixed_view.importance import wavelet_importance
from engine.methods.fixed_view.nearest import build_grid
from engine.methods.fixed_view.rows import PackedRows, no_rows
from engine.methods.fixed_view.stored import gather_job, part_key, stored_cloud
from engine.methods.fixed_view.tiles import run_tiles
from engine.methods.fixed_view.view import View
from engine.scene.scene import Scene
from engine.store import Store

VERSION = 2  # of the stored arrays and of what they mean

_CLOUD = ("gather_samples", "position_weight", "seed")
NEEDS = {
    "cloud": _CLOUD,
    "bounce": (*_CLOUD, "bounce_rays", "bounce_coefficients"),
    "links": (*_CLOUD, "view_rays", "lobe_rays", "lobe_exponent"),
    "second-links": _CLOUD,
}
"""The settings that each stored part depends on, of which another one is made for others."""

Work = tuple[Callable[[int], Arrays], int]
"""What makes a chunk of its number, and how many there are."""


def precompute(
    scene: Scene, settings: Settings, executor: Executor, progress: Progress, store: Store
) -> Polynomial:
    """The transport of a scene: read from the store, finished from its chunks, or made."""
    progress("view samples", 0, 1)
    view = View(scene)
    progress("view samples", 1, 1)
    cloud_entry = store.entry(key(scene, settings, "cloud"))
    cloud = stored_cloud(cloud_entry, view, settings, "uniform", progress)

    def made(name: str, job: Callable[[], Work]) -> Arrays:
        """Arrays from the store, or from the chunks that `job` tells how to make, and how many."""

        def told(_: str, done: float, total: float) -> None:
            progress(name, done, total)

        name_of = key(scene, settings, name)
        entry, parts = store.entry(name_of), store.entry(name_of + ".parts")
        stored = entry.read(name)
        if stored is not None:
            return dict(stored.arrays)
        make, chunks = job()
        arrays = run_chunks(make, chunks, name, parts, executor, told)
        entry.write(name, arrays, {})
        parts.remove()
        return arrays

    bounce = made("bounce", lambda: _bounces(scene, settings, cloud, progress))
    beyond = PackedRows(*(bounce[ENVIRONMENT + name] for name in PackedRows._fields))
    environment = _environment_light(cloud, beyond)
    sample = made("links", lambda: _links(scene, settings, view, cloud))["sample"]
    suns: tuple[Light, ...] = ()
    if scene.environment is not None:
        environment.use(scene.environment)
        suns = environment.suns
    second = None
    if settings.second_bands > 1:
        second = made("second-links", lambda: _second_links(scene, cloud))["sample"]
    rows = PackedRows(*(bounce[name] for name in PackedRows._fields))
    transport = Transport(rows, sample, (*scene.lights, *suns), environment, second)
    return Polynomial(view, settings, cloud, transport)


def _environment_light(cloud: GatherCloud, rows: PackedRows) -> EnvironmentLight:
    """What the environment sends to a cloud of albedo 1, over π the irradiance."""
    white = replace(cloud, albedo=np.ones_like(cloud.albedo))
    return EnvironmentLight(white, EnvironmentRows(rows, no_rows(0), no_rows(0)), {})


def key(scene: Scene, settings: Settings, part: str) -> str:
    """Name of a stored part of NEEDS: a digest of all that it depends on."""
    return part_key(NAME, VERSION, scene, settings, NEEDS[part])


def _bounces(scene: Scene, settings: Settings, cloud: GatherCloud, progress: Progress) -> Work:
    progress("importance", 0, 1)
    importance = wavelet_importance(scene, cloud, settings.seed)
    progress("importance", 1, 1)
    job = gather_job(
        scene,
        cloud,
        cloud.points,
        tiles=run_tiles(len(cloud)),
        importance=importance,
        lobes=cosine_lobes(cloud.points.normal),
        count=settings.bounce_rays,
        link_size=1.0,
        patch_size=1.0,
        coefficients=settings.bounce_coefficients,
        environment_coefficients=max(1, settings.bounce_coefficients // 2),
        seed=settings.seed + 1,
    )
    return partial(gather_chunk, job), job.chunks


def _links(scene: Scene, settings: Settings, view: View, cloud: GatherCloud) -> Work:
    job = _link_job(scene, cloud, view.buffer.centre, patterns(settings))
    return partial(link_chunk, job), job.chunks


def _second_links(scene: Scene, cloud: GatherCloud) -> Work:
    job = _link_job(scene, cloud, cloud.points, second_patterns())
    return partial(link_chunk, job), job.chunks


def _link_job(scene: Scene, cloud: GatherCloud, points: Points, rays: Patterns) -> LinkJob:
    leaves = cloud.points
    return LinkJob(
        positions=scene.geometry.positions,
        triangles=scene.geometry.triangles,
        points=points,
        width=scene.camera.width,
        patterns=rays,
        leaf_position=leaves.position,
        leaf_geometric=leaves.geometric,
        depth=cloud.clusters.depth,
        grid=build_grid(leaves.position, leaves.geometric, cloud.area),
        rays=scene.rays,
    )
