"""The method contract: precompute once, relight at once.

method.name, method.paper, method.edits
method.precompute(scene, settings, executor, progress) -> Product
product.relight(edits, scale) -> Frame
product.bytes, product.settings; save and load are the store's, by content hash
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend
from engine.brdf.base import Material
from engine.diagnosis import Diagnosis
from engine.errors import EditNotSupported, InputError
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

Progress = Callable[[str, float, float], None]
"""progress(phase, done, total); it may raise `Cancelled` to stop the work."""


def silent(phase: str, done: float, total: float) -> None:
    """Progress that goes nowhere."""


@dataclass(frozen=True)
class Frame:
    """A picture.

    image     (height, width, 3) float32, linear radiance
    timings   seconds by part, `total` among them
    warnings  what the user should know about this very picture
    """

    image: NDArray[np.float32]
    timings: dict[str, float] = field(default_factory=dict)
    warnings: tuple[Diagnosis, ...] = ()


@dataclass(frozen=True)
class MaterialFit:
    """How a method models one of a scene's materials.

    terms     of its BRDF; of a code its tiles
    channels  1 where its transport is grey, else 3
    error     of the BRDF, cosine-weighted root mean square as a part of the BRDF's own, or of a
              code its mean relative error; 0 is exact
    bytes     of a code
    """

    name: str
    terms: int
    channels: int
    error: float
    bytes: int = 0


class Product(Protocol):
    """A finished precompute: holds the transport, makes frames."""

    @property
    def method(self) -> str:
        """Name of the method that made it."""

    @property
    def settings(self) -> Any:
        """The frozen settings it was made with."""

    @property
    def bytes(self) -> int:
        """Size of the transport data."""

    @property
    def fits(self) -> tuple[MaterialFit, ...]:
        """How well it models the scene's materials; empty where it takes them as they are."""

    def relight(self, edits: Edits, scale: int = 1, backend: Backend | None = None) -> Frame:
        """The picture under the edits; scale 2 gives every second pixel of every second row.

        `backend` None leaves the choice to RELIGHT_BACKEND; see `engine.backend.choice`. Raises
        EditNotSupported where the product cannot take an edit.
        """


def take_declared_types(settings: Any) -> None:
    """Give the numbers of new settings the types of their fields: 0 becomes 0.0, and 200.0 200.

    A kernel is compiled for each type that it is called with, and a product looked for by its
    settings. Raises InputError for a part of a whole number.
    """
    for each in fields(settings):
        value, kind = getattr(settings, each.name), {"int": int, "float": float}.get(str(each.type))
        if kind is None or isinstance(value, (kind, bool)):
            continue
        if kind(value) != value:
            raise InputError(f"{value} is no whole number", field=each.name)
        object.__setattr__(settings, each.name, kind(value))


@dataclass(frozen=True)
class Method:
    """One published method.

    name        as in the design's table, and as its package
    paper       authors, year, title
    edits       subset of {camera, environment, lights, materials}
    settings    frozen dataclass; its defaults are the paper's values
    precompute  (scene, settings, executor, progress, store) -> Product; chunks of work land in the
                store as they finish
    lamps_alone whether environments do not shine and nothing is reflected twice
    run_time    names of settings that a product takes later too
    retuned     (product, settings) -> the same with other settings of `run_time`; it shares the
                transport
    refitted    (product, materials) -> its fits where the scene is made of these; a method whose
                products take edits of materials may have it
    """

    name: str
    paper: str
    edits: frozenset[str]
    settings: type
    precompute: Callable[[Scene, Any, Executor, Progress, Store], Product]
    lamps_alone: bool = False
    run_time: frozenset[str] = frozenset()
    retuned: Callable[[Any, Any], Product] | None = None
    refitted: Callable[[Any, tuple[Material, ...]], tuple[MaterialFit, ...]] | None = None


# Which method takes which edit: said to the user by the method that does not.
EDITS = {
    "glossy_prt": frozenset({"camera", "environment"}),
    "direct_to_indirect": frozenset({"lights", "environment"}),
    "brdf_editing": frozenset({"materials", "lights"}),
    "wavelet_brdf": frozenset({"camera", "lights", "materials"}),
}


def require_supported(method: str, edits: Edits) -> None:
    """Raise EditNotSupported if `edits` touches what the method holds fixed."""
    for key in sorted(edits.touched() - EDITS[method]):
        able = [name for name, takes in EDITS.items() if key in takes]
        raise EditNotSupported(
            f"{method} takes edits of {', '.join(sorted(EDITS[method]))} only; "
            f"{key} can be edited with {' or '.join(able)}",
            field=key,
        )
