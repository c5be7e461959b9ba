"""Which image format the client wants: RFC 9110 §12.5.1, for the four that can be made."""

from __future__ import annotations

from server.problems import NotAcceptable
from server.wire import ImageFormat

# In the order of preference where the client has none.
MEDIA_TYPES: dict[str, ImageFormat] = {
    "image/jpeg": "jpeg",
    "image/png": "png",
    "image/webp": "webp",
    "image/x-exr": "exr",
}


def negotiate(accept: str) -> tuple[str, ImageFormat]:
    """(media type, format) with the highest quality in an Accept header; raises NotAcceptable."""
    ranges = [_parse(part) for part in accept.split(",") if part.strip()] or [("*/*", 1.0)]
    best, best_quality = "", 0.0
    for media_type in MEDIA_TYPES:
        quality = _quality(media_type, ranges)
        if quality > best_quality:
            best, best_quality = media_type, quality
    if not best:
        raise NotAcceptable(f"only {', '.join(MEDIA_TYPES)} can be made")
    return best, MEDIA_TYPES[best]


def _parse(part: str) -> tuple[str, float]:
    media_range, *parameters = (piece.strip().lower() for piece in part.split(";"))
    quality = 1.0
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name.strip() == "q":
            try:
                quality = float(value)
            except ValueError:
                quality = 0.0
    return media_range, quality if 0.0 <= quality <= 1.0 else 0.0


def _quality(media_type: str, ranges: list[tuple[str, float]]) -> float:
    """The most specific range that matches decides."""
    for wanted in (media_type, "image/*", "*/*"):
        for media_range, quality in ranges:
            if media_range == wanted:
                return quality
    return 0.0
