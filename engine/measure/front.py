"""What the settings of a method cost on one scene, measured once and kept: the page's chart.

Every step of the method's ladder and its usual settings get a pilot each (`pilots`), carried on to
the whole picture. All light of the scene shines, so what a method leaves out counts as error.
"""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from engine.errors import InputError
from engine.measure.held_out import kind_of_edits
from engine.measure.ladders import rung, rungs, settings_at
from engine.measure.pilots import Cost, Pilots
from engine.measure.survey import STALLED, kinds_of
from engine.measure.truth import picture_digest
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.scene.scene import Scene
from engine.store import Store

VERSION = 2  # part of every key: raise it when pilots tell something else
NOISE = 0.03  # relative L2 error of the references, which is taken out again
LONGEST = 120.0  # seconds of a precompute of the whole picture, after which nothing dearer is tried
USUAL = "usual settings"
_WHOLE = "front"  # the file of all points, beside one of each while they are measured


@dataclass(frozen=True)
class FrontPoint:
    """Settings, and what they cost.

    label  USUAL, or which step of the ladder
    cost   for the whole picture
    best   whether no other point has both less error and quicker frames
    """

    label: str
    settings: dict[str, Any]
    cost: Cost
    best: bool = False


@dataclass(frozen=True)
class Front:
    """What was measured of a method on a scene, under edits of these kinds."""

    method: str
    kinds: tuple[str, ...]
    points: tuple[FrontPoint, ...]


def judged_by(scene: Scene, method: str) -> tuple[str, ...]:
    """What is edited to judge a method: what it is made for, or else what the scene has.

    InputError where the scene has nothing that the method edits.
    """
    usual = kind_of_edits([method])
    there = [kind for (kind,) in kinds_of(scene) if kind in METHODS[method].edits]
    if not there:
        able = ", ".join(sorted(METHODS[method].edits))
        raise InputError(f"{method} edits {able}; there is none in this scene", field="method")
    return (usual if usual in there else there[0],)


def known_front(scene: Scene, method: str, usual: Any, store: Store) -> Front | None:
    """The front, where it was measured."""
    found = store.entry(_key(scene, method, usual)).read(_WHOLE)
    if found is None:
        return None
    points = tuple(
        FrontPoint(**{**point, "cost": Cost(**point["cost"])}) for point in found.meta["points"]
    )
    return Front(method, tuple(found.meta["kinds"]), points)


def front(
    scene: Scene, method: str, usual: Any, store: Store, progress: Progress = silent
) -> Front:
    """What the steps of a method's ladder and its `usual` settings cost; from the store if it can.

    What was measured before somebody stopped the work is not measured again.
    """
    known = known_front(scene, method, usual, store)
    if known is not None:
        return known
    kinds = judged_by(scene, method)
    key = _key(scene, method, usual)
    bench = _Bench(scene, method, kinds, key, store, progress)
    points = _marked([bench.point(0, USUAL, usual), *_climbed(bench, method)])
    bench.clear()
    found = Front(method, kinds, tuple(points))
    store.entry(key).write(_WHOLE, {}, asdict(found))
    return found


def _climbed(bench: _Bench, method: str) -> Iterator[FrontPoint]:
    """The ladder as far as it is worth it."""
    before, steps = float("inf"), rungs(method)
    for k in range(steps):
        step = bench.point(k + 1, f"step {k + 1} of {steps}", settings_at(method, rung(method, k)))
        yield step
        # What one step does not mend the next will not either.
        if step.cost.error > STALLED * before or step.cost.precompute > LONGEST:
            return
        before = step.cost.error


class _Bench:
    """Measures one point after the other; each is kept as soon as it is there."""

    def __init__(
        self,
        scene: Scene,
        method: str,
        kinds: Sequence[str],
        key: str,
        store: Store,
        progress: Progress,
    ) -> None:
        self._scene, self._method, self._kinds = scene, method, kinds
        self._entry, self._progress = store.entry(key), progress
        self._pilots: Pilots | None = None
        self._number = 0
        # What pilots precompute is thrown away again: were it there before, it would take no time.
        self._scratch = Store(store.root / f"pilots-{key}")
        for left in self._scratch.root.glob("*"):
            if not left.name.startswith("reference-"):
                shutil.rmtree(left)

    def point(self, number: int, label: str, settings: Any) -> FrontPoint:
        """The point of some settings, which is the same under the same number."""
        kept = self._entry.read(f"point-{number}")
        if kept is not None:
            return FrontPoint(label, asdict(settings), Cost(**kept.meta))
        if self._pilots is None:
            self._pilots = Pilots(self._scene, self._kinds, NOISE, self._scratch, self._report)
        self._number = number
        small = self._pilots.run(self._method, settings)
        cost = self._pilots.whole(self._method, settings, small)
        self._entry.write(f"point-{number}", {}, asdict(cost))
        return FrontPoint(label, asdict(settings), cost)

    def clear(self) -> None:
        """Remove what the pilots have left."""
        self._scratch.remove()

    def _report(self, phase: str, done: float, total: float) -> None:
        """Of all that pilots tell, how many references or points are done."""
        if self._pilots is not None:
            self._progress("settings", self._number, rungs(self._method) + 1)
        elif phase == "references":
            self._progress(phase, done, total)


def _marked(points: list[FrontPoint]) -> list[FrontPoint]:
    """The same, the best marked."""

    def beaten(cost: Cost, other: Cost) -> bool:
        no_worse = other.error <= cost.error and other.frame <= cost.frame
        return no_worse and (other.error, other.frame) != (cost.error, cost.frame)

    return [
        replace(point, best=not any(beaten(point.cost, other.cost) for other in points))
        for point in points
    ]


def _key(scene: Scene, method: str, usual: Any) -> str:
    text = f"{VERSION} {method} {usual!r} {picture_digest(scene, NOISE)}"
    return f"front-{hashlib.blake2b(text.encode(), digest_size=16).hexdigest()}"
