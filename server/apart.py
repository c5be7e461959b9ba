"""Have a file that somebody sent read in a process of its own.

Readers are libraries for files that mean well. Whatever a file does to one ends that process, by
its own limits or by the service's patience, and not the service. The process writes a line of
JSON: what it found, or {"error"} and the {"field"} that is to blame.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from engine.errors import InputError, RelightError

SECONDS = 120.0
MEMORY = 8 << 30  # bytes of address space
MAX_WRITTEN = 1 << 30  # bytes of one file
NICENESS = 5  # frames go first


def read_apart(module: str, room: Path, *arguments: str) -> dict[str, Any]:
    """What `python -m MODULE ARGUMENTS` reports; InputError where the file cannot be used.

    room  the folder that has the file, for whatever the process writes
    """
    paths = os.pathsep.join([*filter(None, sys.path)])
    try:
        done = subprocess.run(
            [sys.executable, "-m", module, *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            env={**os.environ, "PYTHONPATH": paths, "TMPDIR": str(room)},
            text=True,
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"it could not be read within {SECONDS:g} seconds") from None
    with contextlib.suppress(IndexError, json.JSONDecodeError):
        report: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
        if "error" in report:
            raise InputError(report["error"], field=report.get("field", ""))
        return report
    raise InputError("it is so damaged that reading it ended the reader")


def report_from(read: Callable[[], dict[str, Any]]) -> None:
    """The body of such a process: limit it, read, and report."""
    limit()
    try:
        found = read()
    except InputError as error:
        found = {"error": error.message, "field": error.field}
    except (RelightError, MemoryError) as error:
        found = {"error": str(error) or "it needs more memory than there is"}
    print(json.dumps(found))


def limit() -> None:
    """From here on this process can do no harm by taking much."""
    if os.name == "posix":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_WRITTEN, MAX_WRITTEN))
        os.nice(NICENESS)
    # Where memory runs out all the same, this process is to go and not the service.
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")
