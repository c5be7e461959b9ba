"""The finished transport and the frames that it makes: `brdf_editing` §5.2."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend
from engine.brdf import hemispherical_albedo
from engine.brdf.base import GRAIN
from engine.brdf.curve_basis import coefficients
from engine.brdf.equivalent_albedo import shares
from engine.brdf.layers import LAYERS
from engine.errors import EditNotSupported
from engine.light.base import Light
from engine.methods.base import Frame, MaterialFit, require_supported
from engine.methods.brdf_editing.arriving import Apart, Arriving
from engine.methods.brdf_editing.evaluate import evaluate
from engine.methods.brdf_editing.fold import Folded, Slots, fold
from engine.methods.brdf_editing.interleaved import shared
from engine.methods.brdf_editing.light_seen import shining
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
from engine.methods.clock import Clock
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.environment_light import EnvironmentLight
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.view import View
from engine.scene.edits import Edits, edited_materials
from engine.scene.scene import MaterialTable
from engine.scene.tables import changed_table

NAME = "brdf_editing"


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
    """

    material: int
    table: MaterialTable
    pixels: NDArray[np.int32]
    folded: Folded
    others: NDArray[np.float32]
    behind: Folded


class Polynomial:
    """B(x) = Σ_n dⁿ Σ_j c_j F_jn(x), eq. 28."""

    def __init__(
        self, view: View, settings: Settings, cloud: GatherCloud, transport: Transport
    ) -> None:
        self.view, self._settings, self.cloud, self.transport = view, settings, cloud, transport
        scene = view.scene
        self._within = CloudLight(cloud, transport.bounce)
        self._first = self._irradiance()
        lit = scene.environment is not None
        beyond = transport.environment.radiance if lit else np.zeros((0, 3), np.float32)
        self._points = Places(view, scene.material_table)
        lights = shining(transport.lights)
        direct = direct_of(self._points.surface(scene.material_table), lights, transport.seen)
        no_light = np.zeros((0, 1, 3), np.float32)
        self._arriving = Arriving(
            patterns(settings), scene.camera.width, transport.sample,
            no_light, no_second(cloud, lights), Apart(no_light, no_light[None]),
            np.zeros((0, 3), np.float32), beyond, lights, transport.seen, direct,
        )  # fmt: skip
        self._texture = self._cloud_texture()
        self._hand: Hand | None = None

    @property
    def method(self) -> str:
        """`brdf_editing`."""
        return NAME

    @property
    def settings(self) -> Settings:
        """What it was made with."""
        return self._settings

    @property
    def bytes(self) -> int:
        """Bytes of the transport."""
        t = self.transport
        arrays = (t.sample, t.seen, *t.bounce, *(t.second or ()))
        return int(sum(a.nbytes for a in arrays))

    @property
    def bytes_in_hand(self) -> int:
        """Bytes that a frame reads: F and V of the material in hand."""
        hand = self._hand
        if hand is None:
            return 0
        return sum(a.nbytes for a in (*hand.folded, *hand.behind, hand.others))

    @property
    def fits(self) -> tuple[MaterialFit, ...]:
        """None: materials are taken as they are."""
        return ()

    def relight(self, edits: Edits, scale: int = 1, backend: Backend | None = None) -> Frame:
        """See `engine.methods.base.Product.relight`."""
        require_supported(NAME, edits)
        scene, clock = self.view.scene, Clock()
        materials = edited_materials(scene, edits.materials)
        table = changed_table(scene.material_table, materials)
        with clock("freeze"):
            hand = self._take(table)
        with clock("evaluate"):
            image = self._evaluate(hand, table, scale)
        with clock("sources"):
            self.view.add_sources(image, scene.lights, scale, scene.environment)
        height, width = self.view.shape(scale)
        return Frame(image.reshape(height, width, 3), clock.timings(), ())

    def _evaluate(self, hand: Hand, table: MaterialTable, scale: int) -> NDArray[np.float32]:
        s, m = self._settings, hand.material
        colours, lobes = np.zeros((0, 3)), np.zeros((0, 1, 3))
        albedo, second = np.zeros(3), np.zeros((3, 0), np.float32)
        if m >= 0:
            layers = LAYERS[table.model[m]]
            assert layers is not None
            colours, lobes = coefficients(layers, table.row[m], s.bands, s.basis)
            known = shares(int(table.model[m]), hand.table.row[m], s.bands, s.basis)
            albedo = known.albedo(colours, lobes)
            if hand.behind.steps.size:
                second = _row_by_row(*coefficients(layers, table.row[m], s.second_bands, s.basis))
        image = evaluate(
            hand.others, hand.pixels, hand.folded, hand.behind, albedo.astype(np.float32),
            _row_by_row(colours, lobes), second,
        )  # fmt: skip
        return np.ascontiguousarray(self.view.every(image, scale))

    def _take(self, table: MaterialTable) -> Hand:
        """The hand that holds what differs in the table; another one where it has to be."""
        hand = self._hand
        before = hand.table if hand is not None else self.view.scene.material_table
        self._require_editable(table)
        changed = np.flatnonzero(
            (table.row != before.row).any(axis=1) | (table.model != before.model)
        )
        if hand is not None and _holds(hand, table, changed):
            return hand
        others = [m for m in changed if hand is None or m != hand.material]
        material = int((*changed, *others)[-1]) if len(changed) else self._most_seen()
        self._hand = None  # its arrays make room for the new ones
        self._hand = self._freeze(material, table)
        return self._hand

    def _most_seen(self) -> int:
        """The editable material that most pixels show: in hand before anything is; -1 for none."""
        table = self.view.scene.material_table
        shown = self.view.buffer.centre.material
        seen = np.bincount(shown[shown >= 0], minlength=len(table.model))
        seen[[LAYERS[model] is None for model in table.model]] = 0
        return int(seen.argmax()) if seen.any() else -1

    def _require_editable(self, table: MaterialTable) -> None:
        scene = self.view.scene
        old = scene.material_table
        for m, name in enumerate(scene.material_names):
            if (table.emission[m] != old.emission[m]).any():
                raise EditNotSupported(
                    f"{NAME} holds the light fixed, and so what {name!r} emits",
                    field=f"materials.{name}.emission",
                )
            changed = table.model[m] != old.model[m] or (table.row[m] != old.row[m]).any()
            if changed and LAYERS[table.model[m]] is None:
                raise EditNotSupported(
                    f"{NAME} cannot edit materials of this type: it can those of types diffuse, "
                    "phong, blinn_phong, cook_torrance, ggx and ashikhmin_shirley",
                    field=f"materials.{name}",
                )
            if table.row[m, GRAIN:].any() and not old.row[m, GRAIN:].any():
                raise EditNotSupported(
                    f"the grain of {name!r} is not known: give it this type in the scene",
                    field=f"materials.{name}.type",
                )

    def _freeze(self, material: int, table: MaterialTable) -> Hand:
        s = self._settings
        matt, gloss = self._albedos(table)
        of = self.cloud.points.material
        albedo = (self._texture * matt[of] + gloss[of]).astype(np.float32)
        mine = of == material
        whole = (matt[of] + gloss[of]).astype(np.float32)
        # How much of the albedo in hand each sample has: 1 but for textures.
        share = np.where(whole > 0, albedo / np.maximum(whole, 1e-6), 1).astype(np.float32)
        edited = np.where(mine[:, None], share, 0).astype(np.float32)
        fixed = np.where(mine[:, None], 0, albedo).astype(np.float32)
        later = self._within.powers(self._first, fixed, edited, s.bounces)
        if material < 0:
            later = Later(*(np.ascontiguousarray(a[:, :1]) for a in later))
        arriving, surface = (
            self._arriving._replace(powers=later.radiance),
            self._points.surface(table),
        )
        if self.transport.second is not None and s.bounces:
            came = Incoming(
                later, (self._texture * matt[of]).astype(np.float32), self._texture,
                (matt + gloss)[material], self._arriving.beyond,
            )  # fmt: skip
            second = second_bounce(
                self.cloud, self.transport.second, table, material, came, arriving.lights, s
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
        return Hand(material, table, pixels, folded, *reflect(surface, arriving, material))

    def _albedos(self, table: MaterialTable) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(m, 3) each: equivalent albedos of the constants, and of the curves."""
        s = self._settings
        matt, gloss = np.zeros((2, len(table.model), 3))
        for m, model in enumerate(table.model):
            layers = LAYERS[model]
            if layers is None:
                gloss[m] = hemispherical_albedo(int(model), table.row[m])[0]
                continue
            colours, lobes = coefficients(layers, table.row[m], s.bands, s.basis)
            known = shares(int(model), table.row[m], s.bands, s.basis)
            matt[m] = known.albedo(colours, 0 * lobes)
            gloss[m] = known.albedo(0 * colours, lobes)
        return matt, gloss

    def _cloud_texture(self) -> NDArray[np.float32]:
        """(n_g, 3): what textures make of the diffuse part of gather samples' albedos."""
        table, of = self.view.scene.material_table, self.cloud.points.material
        matt, gloss = self._albedos(table)
        found = (self.cloud.albedo - gloss[of]) / np.maximum(matt[of], 1e-6)
        textured = (table.maps[of, 0] >= 0)[:, None] & (matt[of] > 1e-3)
        return np.where(textured, np.maximum(found, 0), 1).astype(np.float32)

    def _irradiance(self) -> NDArray[np.float32]:
        """(n_g, 3): what the lights and the environment send to the cloud."""
        scene, cloud = self.view.scene, self.cloud
        row = cloud.points.row.copy()
        row[:, :3] = 1
        white = replace(cloud.points, row=row)
        first = np.zeros((len(cloud), 3), np.float32)
        if scene.environment is not None:
            first += self.transport.environment.gather
        for light in self.transport.lights:
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


def _row_by_row(colours: NDArray[np.float64], lobes: NDArray[np.float64]) -> NDArray[np.float32]:
    """(3, slots): coefficients as F has them."""
    return np.ascontiguousarray(np.concatenate([colours, lobes.reshape(-1, 3)]).T, np.float32)


def _holds(hand: Hand, table: MaterialTable, changed: NDArray[np.intp]) -> bool:
    """Whether a hand has all that changed."""
    m = hand.material
    if len(changed) == 0:
        return True
    layers = LAYERS[table.model[m]]
    return (
        list(changed) == [m]
        and table.model[m] == hand.table.model[m]
        and layers is not None
        and layers.covers(hand.table.row[m], table.row[m])
    )
