"""The device that all tests of this folder share; an error of GL fails the test that makes it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from engine.backend.gl.context import Device, device


@pytest.fixture
def gpu() -> Iterator[Device]:
    made = device()
    made.check()
    yield made
    made.check()
    made.context.gc()
