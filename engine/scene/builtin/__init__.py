"""The scenes that come with Relight: one file each, one line in BUILTIN.

Each is written in the vocabulary of scene files, so that it is also an example of one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from engine.scene.builtin import cornell_box, knot, ring, room, teatray, vase

BUILTIN: dict[str, tuple[str, Callable[[], dict[str, Any]]]] = {
    "cornell-box": (cornell_box.SUMMARY, cornell_box.document),
    "knot": (knot.SUMMARY, knot.document),
    "ring": (ring.SUMMARY, ring.document),
    "room": (room.SUMMARY, room.document),
    "teatray": (teatray.SUMMARY, teatray.document),
    "vase": (vase.SUMMARY, vase.document),
}
