"""Precompute: vertices, the terms of materials, transport vectors material by material."""

from __future__ import annotations

import hashlib
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.methods.base import Progress
from engine.methods.chunks import run_chunks
from engine.methods.glossy_prt.direct import Job, direct_chunk
from engine.methods.glossy_prt.product import NAME, Prt
from engine.methods.glossy_prt.settings import Settings
from engine.methods.glossy_prt.terms import Terms, terms_of
from engine.methods.glossy_prt.vertices import build_vertices
from engine.numerics.wavelet_vectors import WaveletVectors
from engine.scene.scene import Scene
from engine.store import Entry, Store

VERSION = 1  # of the stored arrays and of what they mean


def precompute(
    scene: Scene, settings: Settings, executor: Executor, progress: Progress, store: Store
) -> Prt:
    """The transport of a scene: read from the store, finished from its chunks, or made."""
    entry = store.entry(key(scene, settings))
    parts = store.entry(key(scene, settings) + ".parts")
    progress("vertices", 0, 1)
    vertices = build_vertices(scene)
    progress("vertices", 1, 1)
    terms = _terms(scene, settings, entry, progress)
    vectors = []
    for material, its_terms in enumerate(terms):
        name = f"transport-{material}"
        found = entry.read(name)
        if found is None:
            of_it = np.flatnonzero(vertices.material == material)
            job = Job(
                rays=scene.rays,
                vertices=vertices,
                first=int(of_it[0]) if len(of_it) else 0,
                count=len(of_it),
                terms=its_terms,
                light_texels=settings.light_texels,
                visibility_texels=settings.visibility_texels,
                coarse_texels=settings.coarse_texels,
                coefficients=settings.coefficients,
            )
            made = _run(job, name, parts, executor, progress)
            entry.write(name, made, {"settings": asdict(settings)})
        else:
            made = found.arrays
        vectors.append(WaveletVectors(*(made[field] for field in WaveletVectors._fields)))
    parts.remove()
    return Prt(scene, settings, vertices, terms, vectors)


def _run(
    job: Job, name: str, parts: Entry, executor: Executor, progress: Progress
) -> dict[str, NDArray[Any]]:
    """The vectors of one material's vertices."""
    if job.count == 0:
        return direct_chunk(job, 0)
    return run_chunks(partial(direct_chunk, job), job.chunks, name, parts, executor, progress)


def _terms(scene: Scene, settings: Settings, entry: Entry, progress: Progress) -> list[Terms]:
    """The materials' terms, which take seconds each for a glossy one."""
    found = entry.read("terms")
    count = len(scene.materials)
    if found is None:
        progress("materials", 0, count)
        terms = terms_of(scene, settings.terms, settings.brdf_texels)
        progress("materials", count, count)
        arrays = {f"light-{m}": t.light for m, t in enumerate(terms)}
        arrays |= {f"view-{m}": t.view for m, t in enumerate(terms)}
        entry.write("terms", arrays, {"textured": [t.textured for t in terms]})
        return terms
    return [
        Terms(found.arrays[f"light-{m}"], found.arrays[f"view-{m}"], found.meta["textured"][m])
        for m in range(count)
    ]


def key(scene: Scene, settings: Settings) -> str:
    """Name of the stored product: a digest of all that it depends on; the camera is not in it."""
    digest = hashlib.blake2b(digest_size=16)
    for part in (NAME, VERSION, scene.transport_digest, asdict(settings)):
        digest.update(f"{part}\n".encode())
    return digest.hexdigest()
