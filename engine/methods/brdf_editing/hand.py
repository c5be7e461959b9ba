"""Taking a material in hand: all others are frozen, and the light with them (§5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import is_matt
from engine.brdf.layers import LAYERS
from engine.light.base import Light
from engine.methods.brdf_editing.albedos import albedos_of
from engine.methods.brdf_editing.arriving import Arriving, Even, in_lanes
from engine.methods.brdf_editing.fold import Folded, Slots, fold
from engine.methods.brdf_editing.interleaved import shared
from engine.methods.brdf_editing.light_seen import shining
from engine.methods.brdf_editing.lighting import Lighting
from engine.methods.brdf_editing.limits import Limits, limits_of
from engine.methods.brdf_editing.patterns import patterns
from engine.methods.brdf_editing.places import Places
from engine.methods.brdf_editing.polynomial import CloudLight, Later
from engine.methods.brdf_editing.reflect import reflect
from engine.methods.brdf_editing.second_tables import (
    Incoming,
    SecondRays,
    no_second,
    second_bounce,
)
from engine.methods.brdf_editing.second_views import views_asked
from engine.methods.brdf_editing.settings import Settings
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.environment_light import EnvironmentLight
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.view import View
from engine.scene.scene import MaterialTable


class Transport(NamedTuple):
    """What a precompute found.

    bounce       one bounce of the gather cloud
    sample       (n, N) uint16, see `links`
    lights       that shine: the scene's, and suns of its environment
    environment  what it sends to a cloud of albedo 1
    second       (n_g, R) uint16, what rays of gather samples meet, where that bounce has gloss
    """

    bounce: PackedRows
    sample: NDArray[np.uint16]
    lights: tuple[Light, ...]
    environment: EnvironmentLight
    second: NDArray[np.uint16] | None


@dataclass(frozen=True)
class Hand:
    """A material in hand, all others frozen.

    material  its number, -1 for none
    cut       which of LAYERS its quotients are
    table     all materials as they were when it was taken
    lights    as they were then
    scale     1 for all pixels, 2 for every second one of every second row
    pixels    (m,) int32   that show it
    folded    F of those
    others    (n, deg + 1, 3) float32   V of all pixels
    behind    F of its second bounce, of all pixels or none
    limits    what is left out
    """

    material: int
    cut: int
    table: MaterialTable
    lights: tuple[Light, ...]
    scale: int
    pixels: NDArray[np.int32]
    folded: Folded
    others: NDArray[np.float32]
    behind: Folded
    limits: Limits

    def changed(self, table: MaterialTable) -> NDArray[np.intp]:
        """Which materials of a table are others."""
        return changed_materials(self.table, table)

    def holds(
        self, table: MaterialTable, lights: tuple[Light, ...], *, loosely: bool = False
    ) -> bool:
        """Whether frames of a table under lights can be made with it; see `Layers.covers`."""
        m, changed = self.material, self.changed(table)
        if lights != self.lights:
            return False
        if len(changed) == 0:
            return True
        layers = LAYERS[self.cut]
        return (
            list(changed) == [m]
            and table.model[m] == self.table.model[m]
            and layers is not None
            and layers.covers(self.table.row[m], table.row[m], loosely=loosely)
        )


def changed_materials(before: MaterialTable, after: MaterialTable) -> NDArray[np.intp]:
    """Which materials of two tables of a scene differ."""
    differs = (after.row != before.row).any(axis=1) | (after.model != before.model)
    return np.flatnonzero(differs)


class Freezer:
    """Takes materials of a scene in hand."""

    def __init__(
        self, view: View, settings: Settings, cloud: GatherCloud, transport: Transport
    ) -> None:
        scene = self._scene = view.scene
        self._settings, self._cloud, self._second = settings, cloud, transport.second
        self._within = CloudLight(cloud, transport.bounce)
        self._environment = self._irradiance(transport)
        lit = scene.environment is not None
        beyond = transport.environment.radiance if lit else np.zeros((0, 3), np.float32)
        self._points = Places(view, scene.material_table)
        self._suns = transport.lights[len(scene.lights) :]
        self._lighting = Lighting(view, self._points, cloud, self._second is not None)
        lights = shining([])
        no_light = np.zeros((0, 1, 3), np.float32)
        self._arriving = Arriving(
            patterns(settings), scene.camera.width, transport.sample, no_light, no_light[:, 0],
            no_second(cloud, lights), Even(no_light, no_light[..., None]), no_light[:, 0], beyond,
            lights, np.zeros((0, 0), np.uint64), no_light[:, 0],
        )  # fmt: skip
        self._texture = self._cloud_texture()
        self._asked: dict[int, NDArray[np.bool_]] = {}

    def __call__(
        self, material: int, cut: int, table: MaterialTable, lights: tuple[Light, ...], scale: int
    ) -> Hand:
        """A material of a table in hand, -1 for none, cut as one of LAYERS, under lights."""
        s, surface = self._settings, self._points.surface(table)
        glossy = (surface.material >= 0) & _glossy(table, material)[surface.material]
        lit = self._lighting.of((*lights, *self._suns), scale, glossy)
        matt, gloss = albedos = albedos_of(table, s, self._points.mean_gloss)
        of = self._cloud.points.material
        base = self._texture * matt[of]
        albedo = (base + gloss[of]).astype(np.float32)
        mine = of == material
        whole = (matt[of] + gloss[of]).astype(np.float32)
        # How much of the albedo in hand each sample has: 1 but for textures.
        share = np.where(whole > 0, albedo / np.maximum(whole, 1e-6), 1).astype(np.float32)
        edited = np.where(mine[:, None], share, 0).astype(np.float32)
        fixed = np.where(mine[:, None], 0, albedo).astype(np.float32)
        later, sent = self._within.powers(self._environment + lit.first, fixed, edited, s.bounces)
        if material < 0:
            later = Later(*(np.ascontiguousarray(a[:, :1]) for a in later))
        arriving = self._arriving._replace(
            powers=later.radiance,
            rows=in_lanes(later.radiance),
            matt=_even_albedos(table),
            lights=lit.lights,
            seen=lit.seen,
            direct=lit.direct,
        )
        every = self._points.pixels(scale)
        if self._second is not None and s.bounces:
            came = Incoming(
                later, base.astype(np.float32), self._texture,
                (matt + gloss)[material], arriving.beyond,
            )  # fmt: skip
            rays = SecondRays(self._second, lit.second)
            if scale not in self._asked:
                self._asked[scale] = views_asked(surface, arriving, every)
            asked = self._asked[scale]
            second = second_bounce(
                self._cloud, rays, asked, table, material, cut, came, lit.lights, s
            )
            arriving = arriving._replace(second=second)
        arriving = arriving._replace(even=shared(surface, arriving, material, every, scale))
        slots, pixels = Slots(cut, 0, 0, s.bands, s.basis == "tents"), np.zeros(0, np.int32)
        if material >= 0:
            layers = LAYERS[cut]
            assert layers is not None
            slots = slots._replace(constants=layers.constants, curves=layers.curves)
            pixels = self._points.showing(material, scale)
        folded = fold(surface, arriving, pixels, material, slots)
        limits = limits_of(
            self._scene.material_names, table, material, cut, s, albedos, self._points.mean_gloss,
            of, surface, arriving, sent,
        )  # fmt: skip
        others, behind = reflect(surface, arriving, material, every)
        return Hand(material, cut, table, lights, scale, pixels, folded, others, behind, limits)

    def _cloud_texture(self) -> NDArray[np.float32]:
        """(n_g, 3): what textures make of the diffuse part of gather samples' albedos."""
        table, of = self._scene.material_table, self._cloud.points.material
        matt, gloss = albedos_of(table, self._settings, self._points.mean_gloss)
        found = (self._cloud.albedo - gloss[of]) / np.maximum(matt[of], 1e-6)
        textured = (table.maps[of, 0] >= 0)[:, None] & (matt[of] > 1e-3)
        return np.where(textured, np.maximum(found, 0), 1).astype(np.float32)

    def _irradiance(self, transport: Transport) -> NDArray[np.float32]:
        """(n_g, 3): what the environment sends to the cloud, but for its suns."""
        if self._scene.environment is None:
            return np.zeros((len(self._cloud), 3), np.float32)
        return transport.environment.gather * np.float32(np.pi)


def _glossy(table: MaterialTable, hand: int) -> NDArray[np.bool_]:
    """(m,): whether materials are more than matt; that in hand may become so."""
    found = np.ones(len(table.model), np.bool_)
    for m, model in enumerate(table.model):
        layers = LAYERS[model]
        if layers is not None and layers.even:
            found[m] = layers.curves > 0 if m == hand else not is_matt.py_func(table.row[m])
    return found


def _even_albedos(table: MaterialTable) -> NDArray[np.float32]:
    """(m, 3): colours of what is matt of each material, -1 where nothing is; see `Arriving`."""
    found = np.full((len(table.model), 3), -1, np.float32)
    for m, model in enumerate(table.model):
        layers = LAYERS[model]
        if layers is not None and layers.even:
            found[m] = layers.colours(table.row[m])[0]
    return found
