"""Precomputed data on disk: one folder per entry, one checksummed, memory-mapped file per name."""

from engine.store.format import Stored
from engine.store.store import Entry, Store

__all__ = ["Entry", "Store", "Stored"]
