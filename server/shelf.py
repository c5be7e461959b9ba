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

    def __init__(self, limit: int, size: Callable[[Value], int] = lambda value: 1) -> None:
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
        while len(self._entries) > 1 and sum(map(self._size, self._entries.values())) > self._limit:
            self._entries.popitem(last=False)


@dataclass(frozen=True)
class Shelved:
    """A product, and the same with some other settings of its method's `run_time`.

    beside  bytes that it takes beside its transport
    """

    product: Product
    beside: int = 0
    tuned: Recent[Any, Product] = field(default_factory=lambda: Recent(KEPT_TUNED))


class Shelf:
    """Products by name; those used last stay, in so many bytes. For any thread.

    The newest stays in any case. One that is let go while a frame is made with it lives until that
    is done, for whoever makes the frame holds it.
    """

    def __init__(self, most: float) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._kept: OrderedDict[Any, Shelved] = OrderedDict()

    def get(self, name: Any) -> Product | None:
        """The product; None where it is not here."""
        with self._lock:
            found = self._kept.get(name)
        return None if found is None else found.product

    def use(self, name: Any) -> Shelved | None:
        """The same with what belongs to it, and now the newest."""
        with self._lock:
            if name in self._kept:
                self._kept.move_to_end(name)
            return self._kept.get(name)

    def keep(self, name: Any, product: Product, beside: int = 0) -> None:
        """Add a product, and let go what there is no room for any more."""
        with self._lock:
            self._kept[name] = Shelved(product, beside)
            self._kept.move_to_end(name)
            while len(self._kept) > 1 and self._bytes() > self._most:
                self._kept.popitem(last=False)

    def let_go(self, name: Any) -> None:
        """The product is needed no more, if it is here."""
        with self._lock:
            self._kept.pop(name, None)

    @property
    def bytes(self) -> int:
        """Of all that is here."""
        with self._lock:
            return self._bytes()

    def _bytes(self) -> int:
        return sum(shelved.product.bytes + shelved.beside for shelved in self._kept.values())
