"""Fixtures that every part of the tests shares."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

# A GL context belongs to the thread that made it, so only the tests of GL may make one.
os.environ.setdefault("RELIGHT_BACKEND", "cpu")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real meshes, maps and BRDFs beside the checkout; skips where it is absent."""
    folder = Path(__file__).resolve().parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the shared data folder is not beside this checkout")
    return folder
