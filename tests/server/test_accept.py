"""Content negotiation after RFC 9110 §12.5.1."""

from __future__ import annotations

import pytest

from server.accept import negotiate
from server.problems import NotAcceptable


@pytest.mark.parametrize(
    ("accept", "format"),
    [
        ("*/*", "jpeg"),
        ("", "jpeg"),
        ("image/*", "jpeg"),
        ("image/png", "png"),
        ("IMAGE/PNG", "png"),
        ("image/webp, image/png", "png"),
        ("image/png;q=0.5, image/webp", "webp"),
        ("image/png;q=0.5, image/webp;q=0.4", "png"),
        ("text/html, */*;q=0.1", "jpeg"),
        ("image/jpeg;q=0, */*", "png"),
        ("image/x-exr", "exr"),
        ("image/*;q=0.2, image/x-exr;q=0.3", "exr"),
    ],
)
def test_takes_the_best(accept: str, format: str) -> None:
    assert negotiate(accept)[1] == format


@pytest.mark.parametrize("accept", ["text/html", "image/gif", "image/png;q=0", "image/png;q=nan"])
def test_refuses_what_it_cannot_make(accept: str) -> None:
    with pytest.raises(NotAcceptable, match="image/png"):
        negotiate(accept)
