"""Try a measured material that somebody sent; see `server.apart`.

`python -m server.acquire FILE` reports {"samples", "diagnoses"} of it.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from server.apart import read_apart, report_from
from server.wire import Notice


def acquire(path: Path) -> list[Notice]:
    """What its user should know of the material in a file; InputError where it cannot be used."""
    report = read_apart("server.acquire", path.parent, str(path))
    return [Notice.model_validate(diagnosis) for diagnosis in report["diagnoses"]]


def read(path: Path) -> dict[str, Any]:
    """The process's body."""
    from engine.brdf.acquisition import read

    found = read(path).report
    notices = [Notice.of(diagnosis).model_dump() for diagnosis in found.diagnoses()]
    return {"samples": found.samples, "diagnoses": notices}


if __name__ == "__main__":
    report_from(lambda: read(Path(sys.argv[1])))
