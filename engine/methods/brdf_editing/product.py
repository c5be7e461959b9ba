"""The finished transport and the frames that it makes: `brdf_editing` §5.2."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend
from engine.brdf.base import GRAIN
from engine.brdf.curve_basis import coefficients
from engine.brdf.equivalent_albedo import shares
from engine.brdf.layers import LAYERS, cut_for
from engine.errors import EditNotSupported
from engine.light.base import Light
from engine.methods.base import Frame, MaterialFit, require_supported
from engine.methods.brdf_editing.albedos import averaged
from engine.methods.brdf_editing.evaluate import evaluate
from engine.methods.brdf_editing.hand import Freezer, Hand, Transport, changed_materials
from engine.methods.brdf_editing.limits import warnings
from engine.methods.brdf_editing.settings import Settings
from engine.methods.clock import Clock
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.view import View
from engine.scene.edits import Edits, edited_lights, edited_materials
from engine.scene.scene import MaterialTable
from engine.scene.tables import changed_table

NAME = "brdf_editing"


class Polynomial:
    """B(x) = Σ_n dⁿ Σ_j c_j F_jn(x), eq. 28."""

    def __init__(
        self, view: View, settings: Settings, cloud: GatherCloud, transport: Transport
    ) -> None:
        self.view, self._settings, self.cloud, self.transport = view, settings, cloud, transport
        self._freeze = Freezer(view, settings, cloud, transport)
        self._hand: Hand | None = None
        self._shown = view.scene.material_table  # the materials of the last frame
        self._named = -1  # the material that the last frame's edits named last

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
        second = 0 if t.second is None else t.second.nbytes
        return t.sample.nbytes + second + sum(array.nbytes for array in t.bounce)

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
        lights = scene.lights
        if edits.lights:
            lights = edited_lights(lights, edits.lights, scene.folder)
        with clock("freeze"):
            hand = self._take(table, lights, scale, self._picked(edits, table))
        self._shown = table
        with clock("evaluate"):
            image = self._evaluate(hand, table, scale)
        with clock("sources"):
            self.view.add_sources(image, lights, scale, scene.environment)
        with clock("limits"):
            said = warnings(hand.limits, hand.material, table, self._settings, image)
        height, width = self.view.shape(scale)
        return Frame(image.reshape(height, width, 3), clock.timings(), said)

    def _evaluate(self, hand: Hand, table: MaterialTable, scale: int) -> NDArray[np.float32]:
        s, m = self._settings, hand.material
        colours, lobes = np.zeros((0, 3)), np.zeros((0, 1, 3))
        albedo, second = np.zeros(3), np.zeros((3, 0), np.float32)
        if m >= 0:
            layers = LAYERS[hand.cut]
            assert layers is not None
            colours, lobes = coefficients(layers, table.row[m], s.bands, s.basis)
            known = shares(hand.cut, hand.table.row[m], s.bands, s.basis)
            albedo = known.albedo(colours, averaged(lobes, hand.limits.gloss))
            if hand.behind.steps.size:
                second = _row_by_row(*coefficients(layers, table.row[m], s.second_bands, s.basis))
        image = evaluate(
            hand.others, hand.pixels, hand.folded, hand.behind, albedo.astype(np.float32),
            _row_by_row(colours, lobes), second,
        )  # fmt: skip
        return np.ascontiguousarray(self.view.every(image, scale))

    def _picked(self, edits: Edits, table: MaterialTable) -> int:
        """The editable material that these edits name last and the last ones did not, or -1.

        Who names another one, changed or not, is about to change it: `{"floor": {}}` will do.
        """
        before = self._named if self._hand is not None else -1
        names = list(edits.materials or {})
        now = self._named = self.view.scene.material_names.index(names[-1]) if names else -1
        if now in (-1, before) or LAYERS[table.model[now]] is None:
            return -1
        return now

    def _take(
        self, table: MaterialTable, lights: tuple[Light, ...], scale: int, picked: int
    ) -> Hand:
        """The hand that holds what differs; another one where it has to be, or is picked.

        While the hand moves it is one of a quarter of the pixels, and so is there at once, and
        follows a roughness that quotients know for as long as they nearly do.
        """
        self._require_editable(table)
        hand = self._hand
        if (
            hand is not None
            and hand.scale in (1, scale)
            and picked in (-1, hand.material)
            and hand.holds(table, lights, loosely=scale > 1)
        ):
            return hand
        if hand is None:
            changed = changed_materials(self.view.scene.material_table, table)
            last = self._most_seen()
        else:
            changed, last = hand.changed(table), hand.material
        others = [m for m in changed if m != last]
        material = picked if picked >= 0 else int((last, *changed, *others)[-1])
        cut = self._cut(material, table)
        if not (
            hand is not None
            and hand.scale > scale
            and hand.material == material
            and hand.holds(table, lights, loosely=True)
        ):
            self._hand = None  # its arrays make room for the new ones
        # Else it is a small one, which is there still if nobody waits for the whole one.
        self._hand = self._freeze(material, cut, table, lights, scale)
        return self._hand

    def _cut(self, material: int, table: MaterialTable) -> int:
        """Which of LAYERS a material is to be taken in hand with, for the edit that it is in."""
        if material < 0:
            return material
        hand, before, model = self._hand, self._shown, int(table.model[material])
        if before.model[material] != model:
            return model
        liked = hand.cut if hand is not None and hand.material == material else -1
        return cut_for(model, before.row[material], table.row[material], liked)

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
                    f"{NAME} holds the light fixed, and so what {name!r} emits: change the "
                    "emission in the scene, or edit its lights with direct_to_indirect",
                    field=f"materials.{name}.emission",
                )
            changed = table.model[m] != old.model[m] or (table.row[m] != old.row[m]).any()
            if changed and LAYERS[table.model[m]] is None:
                raise EditNotSupported(
                    f"{NAME} cannot edit materials of this type: it can those of types diffuse, "
                    "phong, lewis, blinn_phong, cook_torrance, ggx, ashikhmin_shirley and "
                    "half_angle_curve; change others in the scene",
                    field=f"materials.{name}",
                )
            if table.row[m, GRAIN:].any() and not old.row[m, GRAIN:].any():
                raise EditNotSupported(
                    f"which way {name!r} is brushed is not known: give it the type "
                    "ashikhmin_shirley in the scene, or take blinn_phong or ggx here",
                    field=f"materials.{name}.type",
                )


def _row_by_row(colours: NDArray[np.float64], lobes: NDArray[np.float64]) -> NDArray[np.float32]:
    """(3, slots): coefficients as F has them."""
    return np.ascontiguousarray(np.concatenate([colours, lobes.reshape(-1, 3)]).T, np.float32)
