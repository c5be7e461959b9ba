"""Files that are not Python: the page and the shaders, in a checkout and once installed."""

from __future__ import annotations

from pathlib import Path

from engine.errors import NotFound


def resource(name: str) -> Path:
    """The folder `web` or `shaders`: inside this package in a wheel, beside it in a checkout."""
    package = Path(__file__).parent
    for folder in (package / "_shipped" / name, package.parent / name):
        if folder.is_dir():
            return folder
    raise NotFound(f"the folder {name!r} is missing from this installation; install relight anew")
