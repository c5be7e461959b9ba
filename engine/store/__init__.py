"""Precomputed data: one folder per entry, one checksummed, memory-mapped file per name."""

from engine.store.entry import Entry
from engine.store.format import Stored
from engine.store.store import Store

__all__ = ["Entry", "Store", "Stored"]
