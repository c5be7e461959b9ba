"""A case in which a method fails, or must not: its scene, what is bound, and how it is measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from engine.measure.edges import pixels_that_count
from engine.measure.metrics import Image, Mask, relative_l2, resolution
from engine.measure.settings import settings_from
from engine.measure.truth import Truth, truth
from engine.methods import METHODS, prepare
from engine.methods.base import Frame, Progress, silent
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Store

BUDGET = 0.05  # relative L2 error of which nothing need be said
NOISE = 0.06  # of references, which is taken out again
AS_IT_IS = Edits()

MakeScene = Callable[[int], Scene]


@dataclass(frozen=True)
class Mend:
    """What mends a regime: other settings, or another method, mesh or light. Absent is the same.

    words  for the table
    """

    words: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    method: str | None = None
    scene: MakeScene | None = None
    edit: Edits | None = None


@dataclass(frozen=True)
class Regime:
    """A case that a method finds hard, or, without a code and with a small bound, easy.

    name     plain words, its own
    words    what breaks and why, in a sentence
    scene    (side of the picture in pixels) -> scene
    bound    largest relative L2 error, edges left out, against the path tracer with all light
    settings that differ from the method's own
    edit     what is drawn
    codes    of the warnings that must come with the picture
    mend     what mends it; None where nothing does but the reference
    small    settings that differ as well where pictures are small, so that tests are quick
    seen_as  lights that shine just as those of `edit` do, where the path tracer cannot find those
    noise    relative L2 error of the reference
    """

    name: str
    method: str
    words: str
    scene: MakeScene
    bound: float
    settings: Mapping[str, Any] = field(default_factory=dict)
    edit: Edits = AS_IT_IS
    codes: tuple[str, ...] = ()
    mend: Mend | None = None
    small: Mapping[str, Any] = field(default_factory=dict)
    seen_as: Edits | None = None
    noise: float = NOISE


@dataclass(frozen=True)
class Outcome:
    """What a regime gave.

    settings      that differ from the method's own
    error         relative L2, edges left out, the reference's noise taken out
    floor         the smallest error that this noise lets one see
    sizes         of the warnings by their code
    sentences     what they say
    mended        the error under the regime's mend, None where there is none
    mended_codes  of the warnings that are left
    ours          (side, side, 3) linear radiance
    reference     the same
    kept          (side, side) bool: pixels that count
    """

    regime: Regime
    settings: Mapping[str, Any]
    error: float
    floor: float
    sizes: dict[str, float]
    sentences: tuple[str, ...]
    mended: float | None
    mended_codes: tuple[str, ...]
    ours: Image
    reference: Image
    kept: Mask


def run(
    regime: Regime, side: int, store: Store, progress: Progress = silent, small: bool = False
) -> Outcome:
    """Draw a regime and its mend in pictures of so many pixels along a side, and judge them.

    small  whether its settings for small pictures hold
    """
    fewer = regime.small if small else {}
    case = _Case(regime.scene(side), store, regime.noise, progress)
    settings = {**regime.settings, **fewer}
    frame = case.frame(regime.method, settings, regime.edit)
    true = case.truth(regime.edit if regime.seen_as is None else regime.seen_as)
    kept = case.kept(regime.edit)
    mended, left = _mended(regime, settings, side, case)
    return Outcome(
        regime,
        settings,
        relative_l2(frame.image, true.image, kept, true.variance),
        resolution(true.image, true.variance, kept),
        {w.code: w.size for w in frame.warnings},
        tuple(w.message for w in frame.warnings),
        mended,
        left,
        frame.image,
        true.image,
        kept,
    )


@dataclass(frozen=True)
class _Case:
    """A scene, and what its pictures are made with."""

    scene: Scene
    store: Store
    noise: float
    progress: Progress

    def frame(self, method: str, settings: Mapping[str, Any], edit: Edits) -> Frame:
        chosen = settings_from(METHODS[method].settings, settings)
        product = prepare(self.scene, method, chosen, self.progress, store=self.store)
        return product.relight(edit, backend="cpu")

    def truth(self, edit: Edits) -> Truth:
        return truth(self.scene, edit, self.noise, self.store, self.progress)

    def kept(self, edit: Edits) -> Mask:
        return pixels_that_count(apply(self.scene, edit))


def _mended(
    regime: Regime, settings: Mapping[str, Any], side: int, case: _Case
) -> tuple[float | None, tuple[str, ...]]:
    """(error, codes that are left) under the regime's mend."""
    mend = regime.mend
    if mend is None:
        return None, ()
    if mend.scene is not None:
        case = _Case(mend.scene(side), case.store, case.noise, case.progress)
    edit = regime.edit if mend.edit is None else mend.edit
    another = mend.method is not None
    frame = case.frame(
        mend.method or regime.method, {**({} if another else settings), **mend.settings}, edit
    )
    same = mend.edit is None and regime.seen_as is not None
    true = case.truth(regime.seen_as if same and regime.seen_as is not None else edit)
    error = relative_l2(frame.image, true.image, case.kept(edit), true.variance)
    return error, tuple(w.code for w in frame.warnings)
