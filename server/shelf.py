"""What the service keeps at hand: products of all scenes, as far as memory allows."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from engine.methods.base import Product

Name = TypeVar("Name")
Value = TypeVar("Value")

KEPT_TUNED = 4


class Recent(Generic[Name, Value]):
    """The entries used last: `limit` of them, or of all their sizes together. The newest stays."""

    def __init__(self, limit: float, size: Callable[[Value], int] = lambda value: 1) -> None:
        self._limit, self._size = limit, size
        self._entries: OrderedDict[Name, Value] = OrderedDict()

    def get(self, key: Name) -> Value | None:
        """The entry; None where there is none."""
        return self._entries.get(key)

    def use(self, key: Name) -> Value | None:
        """The entry, now the newest; None where there is none."""
        if key in self._entries:
            self._entries.move_to_end(key)
        return self._entries.get(key)

    def keep(self, key: Name, value: Value) -> None:
        """Add an entry, let the oldest go."""
        self._entries[key] = value
        self._entries.move_to_end(key)
        while len(self._entries) > 1 and self.total > self._limit:
            self._entries.popitem(last=False)

    def let_go(self, key: Name) -> None:
        """The entry goes, if it is here."""
        self._entries.pop(key, None)

    @property
    def total(self) -> int:
        """All sizes together."""
        return sum(map(self._size, self._entries.values()))


@dataclass(frozen=True)
class Shelved:
    """A product, and the same with some other settings of its method's `run_time`.

    beside  bytes that it takes beside its transport
    """

    product: Product
    beside: int = 0
    tuned: Recent[Any, Product] = field(default_factory=lambda: Recent(KEPT_TUNED))

    @property
    def bytes(self) -> int:
        """All that it takes."""
        return self.product.bytes + self.beside


class Shelf:
    """Products by name; those used last stay, in so many bytes. For any thread.

    The newest stays in any case. One that is let go while a frame is made with it lives until that
    is done, for whoever makes the frame holds it.
    """

    def __init__(self, most: float) -> None:
        self._lock = threading.Lock()
        self._kept: Recent[Any, Shelved] = Recent(most, lambda shelved: shelved.bytes)

    def get(self, name: Any) -> Product | None:
        """The product; None where it is not here."""
        with self._lock:
            found = self._kept.get(name)
        return None if found is None else found.product

    def use(self, name: Any) -> Shelved | None:
        """The same with what belongs to it, and now the newest."""
        with self._lock:
            return self._kept.use(name)

    def keep(self, name: Any, product: Product, beside: int = 0) -> None:
        """Add a product, and let go what there is no room for any more."""
        with self._lock:
            self._kept.keep(name, Shelved(product, beside))

    def let_go(self, name: Any) -> None:
        """The product is needed no more, if it is here."""
        with self._lock:
            self._kept.let_go(name)

    @property
    def bytes(self) -> int:
        """Of all that is here."""
        with self._lock:
            return self._kept.total
