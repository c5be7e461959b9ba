"""Precompute: vertices, the terms of materials, transport vectors material by material."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.methods.base import Progress
from engine.methods.chunks import run_chunks
from engine.methods.glossy_prt.direct import Job as DirectJob
from engine.methods.glossy_prt.direct import direct_chunk
from engine.methods.glossy_prt.fits import fits_of
from engine.methods.glossy_prt.interreflection import Job as BounceJob
from engine.methods.glossy_prt.interreflection import Sources, bounce_chunk, stack
from engine.methods.glossy_prt.product import NAME, Prt
from engine.methods.glossy_prt.settings import Settings
from engine.methods.glossy_prt.terms import Terms, terms_of
from engine.methods.glossy_prt.vertices import Vertices, build_vertices
from engine.methods.glossy_prt.views import Maps, stack_maps
from engine.numerics.wavelet_vectors import WaveletVectors, added
from engine.scene.scene import Scene
from engine.store import Entry, Store

VERSION = 3  # of the stored arrays and of what they mean


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
    fits = fits_of(scene, terms, entry, progress)
    run = _Run(scene, settings, vertices, terms, entry, parts, executor, progress)
    direct, left = run.direct(), 0.0
    bounced: list[WaveletVectors] | None = None
    if settings.bounces:
        bounced, left = run.bounced(direct)
    parts.remove()
    return Prt(scene, settings, vertices, terms, direct, bounced, left, fits)


class _Run:
    """One precompute: what all its steps need."""

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        vertices: Vertices,
        terms: list[Terms],
        entry: Entry,
        parts: Entry,
        executor: Executor,
        progress: Progress,
    ) -> None:
        self.scene, self.settings, self.vertices, self.terms = scene, settings, vertices, terms
        self._entry, self._parts = entry, parts
        self._executor, self._progress = executor, progress
        self._count = np.bincount(vertices.material, minlength=len(terms))
        self._first = np.concatenate([[0], np.cumsum(self._count)])

    def direct(self) -> list[WaveletVectors]:
        """Direct transport of all materials' vertices."""
        s = self.settings

        def stored(m: int) -> WaveletVectors:
            job = DirectJob(
                rays=self.scene.rays,
                vertices=self.vertices,
                first=int(self._first[m]),
                count=int(self._count[m]),
                terms=self.terms[m],
                light_texels=s.light_texels,
                visibility_texels=s.visibility_texels,
                coarse_texels=s.coarse_texels,
                coefficients=s.coefficients,
                tolerance=s.tolerance,
            )
            return self._stored(f"direct-{m}", partial(direct_chunk, job), job.chunks)

        return [stored(m) for m in range(len(self.terms))]

    def bounced(self, direct: list[WaveletVectors]) -> tuple[list[WaveletVectors], float]:
        """(sum of the passes, part of all light that would still follow)."""
        s, n = self.settings, self.settings.light_texels
        channels = 1 if all(map(_is_grey, self.terms)) else 3
        maps = stack_maps(self.terms, self._count)
        last, total, energy = direct, None, [_energy(direct, self.terms)]
        left = 0.0
        for number in range(1, s.bounces + 1):
            sources = stack(last, self.terms)
            last = [
                self._bounce(number, m, maps, sources, channels) for m in range(len(self.terms))
            ]
            energy.append(_energy(last, self.terms))
            if total is None:
                total = last
            else:
                total = [
                    added(a, b, t.weight_of(channels), s.bounce_coefficients, s.tolerance, n)
                    for a, b, t in zip(total, last, self.terms, strict=True)
                ]
            ratio = min(0.99, energy[-1] / max(energy[-2], 1e-30))
            left = energy[-1] * ratio / (1 - ratio) / max(sum(energy), 1e-30)
            if left < s.remaining:
                break
        assert total is not None
        return total, left

    def _bounce(
        self, number: int, m: int, maps: Maps, sources: Sources, channels: int
    ) -> WaveletVectors:
        s = self.settings
        job = BounceJob(
            scene=self.scene,
            vertices=self.vertices,
            first=int(self._first[m]),
            count=int(self._count[m]),
            terms=self.terms[m],
            maps=maps,
            sources=sources,
            gather_texels=s.gather_texels,
            light_texels=s.light_texels,
            coefficients=s.bounce_coefficients,
            tolerance=s.tolerance,
            channels=channels,
        )
        return self._stored(f"bounce-{number}-{m}", partial(bounce_chunk, job), job.chunks)

    def _stored(
        self, name: str, work: Callable[[int], dict[str, NDArray[Any]]], chunks: int
    ) -> WaveletVectors:
        """The vectors of that name, from the store or from their chunks."""
        found = self._entry.read(name)
        if found is not None:
            return WaveletVectors(*(found.arrays[field] for field in WaveletVectors._fields))
        # A material that nothing has still gives arrays, if empty ones.
        if chunks == 0:
            made = work(0)
        else:
            made = run_chunks(work, chunks, name, self._parts, self._executor, self._progress)
        self._entry.write(name, made, {"settings": asdict(self.settings)})
        return WaveletVectors(*(made[field] for field in WaveletVectors._fields))


def _is_grey(terms: Terms) -> bool:
    grey = terms.channels == 1 and not terms.textured
    return grey and bool((terms.view == terms.view[..., :1]).all())


def _energy(vectors: list[WaveletVectors], terms: list[Terms]) -> float:
    """What all vertices together make of white light, up to a factor."""
    return sum(
        float(np.abs(v.base.sum(axis=1) * t.weight_of(v.scale.shape[1] // t.count)).sum())
        * t.count / v.scale.shape[1]
        for v, t in zip(vectors, terms, strict=True)
    )  # fmt: skip


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
