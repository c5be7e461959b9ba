"""The pictures of lights, one by one, while they are of use.

Light is additive, so every light has a picture of its own. The pictures of lights that did not
change are kept (§5 of Hašan et al. 2006 caches all lights but the moving one).
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.light.base import Light

KEPT_BYTES = 256e6
# Of each kind and light, as it was before. Nobody comes again to where a drag passed, and memory
# that is given back costs the next picture less than fresh memory.
KEPT_BEFORE = 3
KEPT_LAMPS = 24
FEW = 16  # lights of which none is remembered as a part of a sum alone

Lamp = tuple[NDArray[np.intp], NDArray[np.float32], NDArray[np.float32]]
"""Pixels (m,) that a lamp covers, how much of each (m, 1), and its radiance there (m, 3)."""


class HasBytes(Protocol):
    """A picture, wherever it lies."""

    @property
    def nbytes(self) -> int:
        """Its size."""


Key = tuple[int | str, Light]
Picture = TypeVar("Picture", bound=HasBytes)


class LightPictures(Generic[Picture]):
    """Remembers what each light did, so that only lights that changed are computed again."""

    def __init__(self) -> None:
        self._pictures: OrderedDict[Key, Picture] = OrderedDict()
        self._bytes = 0
        self._sums: dict[int | str, tuple[frozenset[Light], NDArray[np.float64]]] = {}
        self._lamps: OrderedDict[tuple[int, Light], Lamp] = OrderedDict()

    def total(
        self: LightPictures[NDArray[np.float32]],
        what: int | str,
        lights: tuple[Light, ...],
        compute: Callable[[Light], NDArray[np.float32]],
        n: int,
    ) -> NDArray[np.float32]:
        """Sum over enabled lights of compute(light) (n, 3); see `each`."""
        on = [light for light in lights if light.enabled]
        # The room is for three kinds: of whole and of coarse pixels, and of gather samples.
        if len(on) > FEW and len(on) * 12 * n > KEPT_BYTES / 3:
            return self._changed_total(what, on, compute, n)
        out = np.zeros((n, 3), np.float32)
        for picture in self.each(what, lights, compute):
            out += picture
        return out

    def each(
        self,
        what: int | str,
        lights: tuple[Light, ...],
        compute: Callable[[Light], Picture],
    ) -> Iterator[Picture]:
        """compute(light) of the enabled lights; `what` names the kind of picture."""
        keys = {(what, light) for light in lights if light.enabled}
        for light in lights:
            if light.enabled:
                yield self._picture((what, light), compute, keys)

    def _changed_total(
        self,
        what: int | str,
        on: list[Light],
        compute: Callable[[Light], NDArray[np.float32]],
        n: int,
    ) -> NDArray[np.float32]:
        """The same for more lights than there is room for: their last sum, and what changed in it.

        Kept in double precision, from which a light can be taken away again without a trace.
        """
        wanted = frozenset(on)
        had, total = self._sums.get(what, (frozenset[Light](), np.zeros((n, 3))))
        if len(wanted ^ had) > len(wanted):
            had, total = frozenset(), np.zeros((n, 3))
        new = {(what, light) for light in wanted - had}
        for light in [light for light in on if light not in had]:
            total += self._picture((what, light), compute, new)
        for light in sorted(had - wanted, key=lambda light: light.id):
            total -= self._picture((what, light), compute, new)
        self._sums[what] = wanted, total
        return np.maximum(total, 0).astype(np.float32)

    def _picture(self, key: Key, compute: Callable[[Light], Any], wanted: set[Key]) -> Any:
        if key in self._pictures:
            self._pictures.move_to_end(key)
            return self._pictures[key]
        picture = compute(key[1])
        self._keep(key, picture, wanted)
        return picture

    def _keep(self, key: Key, picture: Picture, wanted: set[Key]) -> None:
        """Remember a picture, in place of the oldest but not of one that is wanted now."""
        what, light = key
        before = [k for k in self._pictures if k[0] == what and k[1].id == light.id]
        for other in [k for k in before if k not in wanted][:-KEPT_BEFORE]:
            self._bytes -= self._pictures.pop(other).nbytes
        while self._pictures and self._bytes + picture.nbytes > KEPT_BYTES:
            oldest = next(iter(self._pictures))
            if oldest in wanted:
                return
            self._bytes -= self._pictures.pop(oldest).nbytes
        self._pictures[key] = picture
        self._bytes += picture.nbytes

    def lamp(self, scale: int, light: Light, compute: Callable[[], Lamp]) -> Lamp:
        """The picture of a light itself."""
        key = (scale, light)
        if key not in self._lamps:
            self._lamps[key] = compute()
        self._lamps.move_to_end(key)
        while len(self._lamps) > KEPT_LAMPS:
            self._lamps.popitem(last=False)
        return self._lamps[key]
