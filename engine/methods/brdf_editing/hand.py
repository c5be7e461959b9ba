"""Taking a material in hand: all others are frozen, and the light with them (§5.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.layers import LAYERS
from engine.light.base import Light
from engine.methods.brdf_editing.albedos import albedos_of
from engine.methods.brdf_editing.arriving import Apart, Arriving
from engine.methods.brdf_editing.fold import Folded, Slots, fold
from engine.methods.brdf_editing.interleaved import shared
from engine.methods.brdf_editing.light_seen import shining
from engine.methods.brdf_editing.limits import Limits, limits_of
from engine.methods.brdf_editing.patterns import patterns
from engine.methods.brdf_editing.places import Places
from engine.methods.brdf_editing.polynomial import CloudLight, Later
from engine.methods.brdf_editing.reflect import direct_of, reflect
from engine.methods.brdf_editing.second_tables import (
    Incoming,
    SecondRays,
    no_second,
    second_bounce,
)
from engine.methods.brdf_editing.settings import Settings
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.environment_light import EnvironmentLight
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.view import View
from engine.scene.scene import MaterialTable


class Transport(NamedTuple):
    """What a precompute found.

    bounce       one bounce of the gather cloud
    sample       (n, N) uint16, see `links`
    seen         (n + 4 m, l) uint64, see `light_seen`
    lights       that shine: the scene's, and suns of its environment
    environment  what it sends to a cloud of albedo 1
    second       what the rays of gather samples meet, where the second bounce has gloss
    """

    bounce: PackedRows
    sample: NDArray[np.uint16]
    seen: NDArray[np.uint64]
    lights: tuple[Light, ...]
    environment: EnvironmentLight
    second: SecondRays | None


@dataclass(frozen=True)
class Hand:
    """A material in hand, all others frozen.

    material  its number, -1 for none
    table     all materials as they were when it was taken
    pixels    (m,) int32   that show it
    folded    F of those
    others    (n, deg + 1, 3) float32   V of all pixels
    behind    F of its second bounce, of all pixels or none
    limits    what is left out
    """

    material: int
    table: MaterialTable
    pixels: NDArray[np.int32]
    folded: Folded
    others: NDArray[np.float32]
    behind: Folded
    limits: Limits

    def holds(self, table: MaterialTable, changed: NDArray[np.intp]) -> bool:
        """Whether frames of a table, in which those materials have changed, can be made with it."""
        m = self.material
        if len(changed) == 0:
            return True
        layers = LAYERS[table.model[m]]
        return (
            list(changed) == [m]
            and table.model[m] == self.table.model[m]
            and layers is not None
            and layers.covers(self.table.row[m], table.row[m])
        )


class Freezer:
    """Takes materials of a scene in hand."""

    def __init__(
        self, view: View, settings: Settings, cloud: GatherCloud, transport: Transport
    ) -> None:
        scene = self._scene = view.scene
        self._settings, self._cloud, self._second = settings, cloud, transport.second
        self._within = CloudLight(cloud, transport.bounce)
        self._first = self._irradiance(transport)
        lit = scene.environment is not None
        beyond = transport.environment.radiance if lit else np.zeros((0, 3), np.float32)
        self._points = Places(view, scene.material_table)
        lights = shining(transport.lights)
        direct = direct_of(self._points.surface(scene.material_table), lights, transport.seen)
        no_light = np.zeros((0, 1, 3), np.float32)
        self._arriving = Arriving(
            patterns(settings), scene.camera.width, transport.sample, no_light,
            no_second(cloud, lights), Apart(no_light, no_light[None]), no_light[:, 0], beyond,
            lights, transport.seen, direct,
        )  # fmt: skip
        self._texture = self._cloud_texture()

    def __call__(self, material: int, table: MaterialTable) -> Hand:
        """A material of a table in hand, -1 for none."""
        s = self._settings
        matt, gloss = albedos = albedos_of(table, s)
        of = self._cloud.points.material
        albedo = (self._texture * matt[of] + gloss[of]).astype(np.float32)
        mine = of == material
        whole = (matt[of] + gloss[of]).astype(np.float32)
        # How much of the albedo in hand each sample has: 1 but for textures.
        share = np.where(whole > 0, albedo / np.maximum(whole, 1e-6), 1).astype(np.float32)
        edited = np.where(mine[:, None], share, 0).astype(np.float32)
        fixed = np.where(mine[:, None], 0, albedo).astype(np.float32)
        later, sent = self._within.powers(self._first, fixed, edited, s.bounces)
        if material < 0:
            later = Later(*(np.ascontiguousarray(a[:, :1]) for a in later))
        surface = self._points.surface(table)
        arriving = self._arriving._replace(powers=later.radiance)
        if self._second is not None and s.bounces:
            came = Incoming(
                later, (self._texture * matt[of]).astype(np.float32), self._texture,
                (matt + gloss)[material], arriving.beyond,
            )  # fmt: skip
            second = second_bounce(
                self._cloud, self._second, table, material, came, arriving.lights, s
            )
            arriving = arriving._replace(second=second, matt=_even_albedos(table))
            arriving = arriving._replace(apart=shared(surface, arriving, material))
        slots, pixels = Slots(0, 0, s.bands, s.basis == "tents"), np.zeros(0, np.int32)
        if material >= 0:
            layers = LAYERS[table.model[material]]
            assert layers is not None
            slots = slots._replace(constants=layers.constants, curves=layers.curves)
            pixels = self._points.showing(material)
        folded = fold(surface, arriving, pixels, material, slots)
        limits = limits_of(
            self._scene.material_names, table, material, s, albedos, of, surface,
            arriving, sent,
        )  # fmt: skip
        others, behind = reflect(surface, arriving, material)
        return Hand(material, table, pixels, folded, others, behind, limits)

    def _cloud_texture(self) -> NDArray[np.float32]:
        """(n_g, 3): what textures make of the diffuse part of gather samples' albedos."""
        table, of = self._scene.material_table, self._cloud.points.material
        matt, gloss = albedos_of(table, self._settings)
        found = (self._cloud.albedo - gloss[of]) / np.maximum(matt[of], 1e-6)
        textured = (table.maps[of, 0] >= 0)[:, None] & (matt[of] > 1e-3)
        return np.where(textured, np.maximum(found, 0), 1).astype(np.float32)

    def _irradiance(self, transport: Transport) -> NDArray[np.float32]:
        """(n_g, 3): what the lights and the environment send to the cloud."""
        scene, cloud = self._scene, self._cloud
        row = cloud.points.row.copy()
        row[:, :3] = 1
        white = replace(cloud.points, row=row)
        first = np.zeros((len(cloud), 3), np.float32)
        if scene.environment is not None:
            first += transport.environment.gather
        for light in transport.lights:
            if light.enabled:
                first += light_on_points(scene.rays, white, light)
        return first * np.float32(np.pi)


def _even_albedos(table: MaterialTable) -> NDArray[np.float32]:
    """(m, 3): colours of what is matt of each material, -1 where nothing is; see `Arriving`."""
    found = np.full((len(table.model), 3), -1, np.float32)
    for m, model in enumerate(table.model):
        layers = LAYERS[model]
        if layers is not None and layers.even:
            found[m] = layers.colours(table.row[m])[0]
    return found
