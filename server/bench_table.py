"""The document of `server.bench` as lines of text, each figure beside what is asked of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

TRANSPORT_MS = 8.0
SLOWEST = 0.5
GROWTH_MB = 10.0
DROPPED_SECONDS = 20.0
UNAFFECTED = 0.75  # of the rate without the client that stops, which has a share while it reads
START_SECONDS = 3.0


def lines(document: dict[str, Any]) -> Iterator[str]:
    """What was measured, what was asked, and whether it holds."""
    size = document["transport"]["socket"]
    yield (
        f"{document['scene']}, {size['width']} x {size['height']}, service and clients on "
        f"{document['cores']} cores"
    )
    for what, measured, asked, holds in rows(document):
        yield f"{what:<56} {measured:>14}   {asked:<22} {'' if holds else 'MISSED'}".rstrip()


def rows(document: dict[str, Any]) -> Iterator[tuple[str, str, str, bool]]:
    """(what, measured, asked, whether it holds)."""
    for way, found in document["transport"].items():
        p95 = found["over_p95_ms"]
        yield (
            f"encode + transport on top of drawing, {way}, p95",
            f"{p95:.1f} ms",
            f"under {TRANSPORT_MS:g} ms",
            p95 < TRANSPORT_MS,
        )
    clients = document["clients"]
    many = f"{len(clients['frames'])} clients"
    slowest = clients["slowest_over_mean"]
    yield f"{many}, frames a second of all", f"{clients['per_second']:.0f}", "", True
    yield f"{many}, edit to frame, p95", f"{clients['answer_p95_ms']:.0f} ms", "", True
    yield (
        f"{many}, slowest over mean",
        f"{slowest:.2f}",
        f"at least {SLOWEST:g}",
        slowest >= SLOWEST,
    )
    yield from _memory(many, clients)
    yield from _faults(many, clients)
    for how, found in document["stopped"].items():
        dropped, share = found["dropped_after_s"], found["per_second_beside"] / found["per_second"]
        yield (
            f"stops {how}: dropped after",
            "never" if dropped is None else f"{dropped:.0f} s",
            f"within {DROPPED_SECONDS:g} s",
            dropped is not None and dropped <= DROPPED_SECONDS,
        )
        yield (
            "  rate of the others, of that without it",
            f"{share:.0%}",
            f"at least {UNAFFECTED:.0%}",
            share >= UNAFFECTED,
        )
        yield from _memory("  beside it", found)
        yield from _faults("  beside it", found)
    start = document["start"]
    first = start["first_pixels"]
    yield (
        "cold start until first pixels",
        f"{first:.1f} s",
        f"under {START_SECONDS:g} s",
        first < START_SECONDS,
    )
    yield "cold start until pixels with the product", f"{start['with_product']:.1f} s", "", True


def _memory(who: str, found: dict[str, Any]) -> Iterator[tuple[str, str, str, bool]]:
    if found["memory_mb"] is None:
        return
    growth = found["memory_end_mb"] - found["memory_mb"]
    yield (
        f"{who}, memory of the service grows by",
        f"{growth:.1f} of {found['memory_mb']:.0f} MB",
        f"at most {GROWTH_MB:g} MB",
        growth <= GROWTH_MB,
    )


def _faults(who: str, found: dict[str, Any]) -> Iterator[tuple[str, str, str, bool]]:
    stale, errors = found["stale"], len(found["errors"])
    yield f"{who}, stale frames and errors", f"{stale} and {errors}", "none", stale + errors == 0
