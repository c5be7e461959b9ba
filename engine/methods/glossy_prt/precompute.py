"""Precompute: vertices, the terms of materials, transport vectors material by material."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.methods.base import Progress
from engine.methods.chunks import Arrays, CallingThread, run_chunks
from engine.methods.glossy_prt.coarseness import between_vertices, of_simpler
from engine.methods.glossy_prt.compression import Job as ClusterJob
from engine.methods.glossy_prt.compression import cluster_chunk
from engine.methods.glossy_prt.direct import SOURCE, direct_chunk
from engine.methods.glossy_prt.direct import Job as DirectJob
from engine.methods.glossy_prt.fits import fits_of
from engine.methods.glossy_prt.gl_visibility import GlVisibility
from engine.methods.glossy_prt.interreflection import Job as BounceJob
from engine.methods.glossy_prt.interreflection import Sources, bounce_chunk, stack
from engine.methods.glossy_prt.measured import Measured
from engine.methods.glossy_prt.occluders import Occluders, occluders
from engine.methods.glossy_prt.product import NAME, Prt, Stored, Transport
from engine.methods.glossy_prt.settings import Settings
from engine.methods.glossy_prt.terms import Terms, terms_of
from engine.methods.glossy_prt.vertices import Vertices, build_vertices
from engine.methods.glossy_prt.views import Maps, stack_maps
from engine.methods.glossy_prt.visibility import OpenParts, open_parts
from engine.numerics.cluster_basis import Clusters
from engine.numerics.wavelet_vectors import WaveletVectors, added
from engine.scene.scene import Scene
from engine.store import Entry, Store

BOUNCED = 2  # times the error of direct transport: there is so much less bounced light
VERSION = 6  # of the stored arrays and of what they mean


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
    transport = _read(entry, settings, len(terms))
    if transport is None:
        transport = _Run(scene, settings, vertices, terms, parts, executor, progress).transport()
        _write(transport, entry)
        parts.remove()
    return Prt(scene, settings, vertices, terms, transport, fits)


def _write(transport: Transport, entry: Entry) -> None:
    parts = {"direct": transport.direct, "bounced": transport.bounced}
    arrays = {
        f"{part}-{m}-{name}": array
        for part, of_materials in parts.items()
        for m, vectors in enumerate(of_materials)
        for name, array in vectors._asdict().items()
    }
    entry.write("transport", arrays, transport.measured._asdict())


def _read(entry: Entry, settings: Settings, materials: int) -> Transport | None:
    found = entry.read("transport")
    if found is None:
        return None
    kind: type[Stored] = Clusters if settings.cluster_error else WaveletVectors

    def vectors(part: str) -> list[Stored]:
        return [_of(kind, found.arrays, f"{part}-{m}-") for m in range(materials)]

    bounced = vectors("bounced") if settings.bounces else []
    return Transport(vectors("direct"), bounced, Measured(**found.meta))


class _Run:
    """One precompute: what all its steps need."""

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        vertices: Vertices,
        terms: list[Terms],
        parts: Entry,
        executor: Executor,
        progress: Progress,
    ) -> None:
        self.scene, self.settings, self.vertices, self.terms = scene, settings, vertices, terms
        self._parts, self._executor, self._progress = parts, executor, progress
        self._occluders = occluders(scene, settings.occluder_vertices)
        self._count = np.bincount(vertices.material, minlength=len(terms))
        first = np.concatenate([[0], np.cumsum(self._count)]).astype(np.int32)
        # Where the clusters of a material begin, and its end; a material of nothing has an empty
        # one.
        at = np.searchsorted(vertices.cluster, first)
        self._bounds = [
            np.append(vertices.cluster[low : max(high, low + 1)], first[m + 1])
            for m, (low, high) in enumerate(itertools.pairwise(at))
        ]

    def transport(self) -> Transport:
        """Of all materials."""
        direct, sources = self._direct()
        self._progress("between vertices", 0, 1)
        n = self.settings.light_texels
        exact = self._by_rays(occluders(self.scene))
        between = between_vertices(self.scene, self.vertices, exact, n)
        simpler = 0.0
        if self.settings.occluder_vertices:
            simpler = of_simpler(self.vertices, self._by_rays(self._occluders), exact, n)
        self._progress("between vertices", 1, 1)
        if not self.settings.bounces:
            return Transport(direct, [], Measured(0.0, between, simpler))
        found, left = self._bounced(sources)
        bounced: list[Stored] = list(found)
        if self.settings.cluster_error:
            bounced = [self._clustered(m, v) for m, v in enumerate(found)]
        return Transport(direct, bounced, Measured(left, between, simpler))

    def _direct(self) -> tuple[list[Stored], list[WaveletVectors]]:
        """(direct transport, the vectors that bounces are gathered from)."""
        s = self.settings
        executor, look_around = self._visibility()
        direct: list[Stored] = []
        sources = []
        for m, terms in enumerate(self.terms):
            job = DirectJob(
                open_parts=look_around,
                vertices=self.vertices,
                bounds=self._bounds[m],
                terms=terms,
                light_texels=s.light_texels,
                visibility_texels=s.visibility_texels,
                coefficients=s.coefficients,
                tolerance=s.tolerance,
                cluster_error=s.cluster_error,
                sources=s.bounces > 0,
            )
            made = self._made(f"direct-{m}", partial(direct_chunk, job), job.bounds, executor)
            if not s.cluster_error:
                direct.append(_of(WaveletVectors, made))
                sources.append(_of(WaveletVectors, made))
                continue
            direct.append(_of(Clusters, made))
            if s.bounces:
                sources.append(_of(WaveletVectors, made, SOURCE))
        return direct, sources

    def _visibility(self) -> tuple[Executor, OpenParts]:
        """(who finds what vertices see, how): a GL context belongs to one thread, which is this."""
        s = self.settings
        light, fine = s.light_texels, s.visibility_texels
        if s.visibility == "gl":
            return CallingThread(), GlVisibility(self._occluders, light, fine)
        return self._executor, self._by_rays(self._occluders)

    def _by_rays(self, blocking: Occluders) -> OpenParts:
        s = self.settings
        fine, coarse = s.visibility_texels, s.coarse_texels
        return partial(open_parts, blocking, light=s.light_texels, fine=fine, coarse=coarse)

    def _bounced(self, direct: list[WaveletVectors]) -> tuple[list[WaveletVectors], float]:
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
            bounds=self._bounds[m],
            terms=self.terms[m],
            maps=maps,
            sources=sources,
            gather_texels=s.gather_texels,
            light_texels=s.light_texels,
            coefficients=s.bounce_coefficients,
            tolerance=s.tolerance,
            channels=channels,
        )
        name = f"bounce-{number}-{m}"
        made = self._made(name, partial(bounce_chunk, job), job.bounds, self._executor)
        return _of(WaveletVectors, made)

    def _clustered(self, m: int, vectors: WaveletVectors) -> Clusters:
        s, terms = self.settings, self.terms[m]
        job = ClusterJob(
            vectors=vectors,
            start=vectors.start,
            bounds=self._bounds[m] - self._bounds[m][0],
            weight=terms.weight_of(vectors.scale.shape[1] // terms.count),
            light_texels=s.light_texels,
            error=BOUNCED * s.cluster_error,
        )
        made = self._made(f"clusters-{m}", partial(cluster_chunk, job), job.bounds, self._executor)
        return _of(Clusters, made)

    def _made(
        self,
        name: str,
        work: Callable[[int], Arrays],
        bounds: NDArray[np.int32],
        executor: Executor,
    ) -> Arrays:
        return run_chunks(work, len(bounds) - 1, name, self._parts, executor, self._progress)


Kind = TypeVar("Kind", bound=Stored)


def _of(kind: type[Kind], arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Kind:
    """Vectors from their arrays by name."""
    return kind(*(arrays[f"{prefix}{name}"] for name in kind._fields))


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
