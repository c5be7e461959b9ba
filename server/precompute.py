"""Long work in a process of its own, so that frames stay quick and cancelling is certain.

`python -m server.precompute` reads one `Task` as a line of JSON on its standard input and writes
lines of JSON: {"phase", "done", "total"} as it goes, {"error": {...}} where it failed. What it made
lies in the store afterwards, where the service finds it; see `server.work`. It ends when its input
closes, so it never outlives the service; it leads its own process group, so that its helpers end
with it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO, Any, cast

from pydantic import BaseModel, ConfigDict

import engine.errors
from engine.errors import Cancelled, InputError, RelightError, StoreError
from engine.methods.base import EDITS, Progress
from engine.scene.camera import Camera
from engine.scene.edits import Edits
from engine.store import Store
from server.wire import Work

Materials = dict[str, dict[str, Any]]
"""Edits of materials by name, see `engine.scene.edits.Edits`."""
Key = tuple[str, str, str]

# Phases of a preview begin with this; the last of them says that it can be loaded.
PREVIEW = "preview: "
PREVIEW_READY = PREVIEW + "ready"

NICENESS = 10
POLL_SECONDS = 0.1


class Task(BaseModel):
    """What to make; `source` as `engine.scene.open.open_scene` takes it.

    work      a method's product for a camera and materials; what its settings cost on the scene; or
              a reference picture under edits
    edits     of a reference
    error     that a reference may have, relative L2
    seconds   that a reference may take
    preview   whether to make a quick version of a product before, where it is worth it
    """

    model_config = ConfigDict(frozen=True)

    scene: str
    source: str
    camera: Camera
    materials: Materials = {}
    method: str
    settings: dict[str, Any] = {}
    work: Work = "product"
    edits: Edits = Edits()
    error: float = 0.0
    seconds: float = 0.0
    preview: bool = False

    @property
    def key(self) -> tuple[Work, str, Key]:
        """Equal for two tasks that make the same product."""
        return self.work, self.scene, key_of(self.method, self.camera, self.materials)


def key_of(method: str, camera: Camera, materials: Materials | None) -> Key:
    """(method, what its product has in it of the camera, and of the edits of materials).

    Nothing of what the method takes any of.
    """
    free = EDITS[method]
    return (
        method,
        "" if "camera" in free else camera.model_dump_json(),
        "" if "materials" in free or not materials else json.dumps(materials, sort_keys=True),
    )


def preview_store(task: Task) -> Store:
    """Where the preview of a task lies, apart from all else, until the service has loaded it."""
    made = task.model_copy(update={"preview": False}).model_dump_json()
    digest = hashlib.blake2b(made.encode(), digest_size=16).hexdigest()
    return Store(Store().root / "previews" / digest)


def run_in_process(task: Task, progress: Progress) -> None:
    """Precompute `task` into the store; what `progress` raises stops the process at once.

    Raises the process's own error, or RelightError where it ended without a word.
    """
    process = subprocess.Popen(
        [sys.executable, "-m", "server.precompute"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": _python_path()},
        text=True,
        start_new_session=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    lines: queue.Queue[str | None] = queue.Queue()
    reader = threading.Thread(target=_forward, args=(process.stdout, lines), daemon=True)
    reader.start()
    try:
        process.stdin.write(task.model_dump_json() + "\n")
        process.stdin.flush()
        _follow(lines, progress)
        if process.wait() != 0:
            raise RelightError(f"the precompute process ended with status {process.returncode}")
    finally:
        _end(process)
        reader.join()
        process.stdout.close()
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()


def _python_path() -> str:
    """The search path of this process with the folder of this package first."""
    here = str(Path(__file__).resolve().parents[1])
    return os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])


def _forward(stream: IO[str], lines: queue.Queue[str | None]) -> None:
    for line in stream:
        lines.put(line)
    lines.put(None)


def _follow(lines: queue.Queue[str | None], progress: Progress) -> None:
    """Hand every report to `progress`, and call it in between so that it can stop the work."""
    phase, done, total = "start", 0.0, 1.0
    while True:
        try:
            line = lines.get(timeout=POLL_SECONDS)
        except queue.Empty:
            progress(phase, done, total)
            continue
        if line is None:
            return
        report = json.loads(line)
        if "error" in report:
            raise _as_error(report["error"])
        phase, done, total = report["phase"], report["done"], report["total"]
        progress(phase, done, total)


def _end(process: subprocess.Popen[str]) -> None:
    """Kill the whole group, if any of it is left."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _as_error(report: dict[str, str]) -> RelightError:
    kind = getattr(engine.errors, report["kind"], RelightError)
    details = {name: report[name] for name in ("field", "file") if name in report}
    return cast(RelightError, kind(report["message"], **details))


def _as_report(error: RelightError) -> dict[str, str]:
    if isinstance(error, InputError):
        return {
            "kind": type(error).__name__,
            "message": error.message,
            "field": error.field,
            "file": error.file,
        }
    if isinstance(error, StoreError):
        return {"kind": type(error).__name__, "message": error.message, "file": error.file}
    return {"kind": type(error).__name__, "message": str(error)}


def _end_with_parent(stream: IO[str]) -> None:
    """Wait for the end of the input, then end this process and its helpers."""
    stream.read()
    if os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def main() -> None:
    """The process's body."""
    # Whatever a library prints must not get between the reports.
    reports, sys.stdout = sys.stdout, sys.stderr
    os.nice(NICENESS)
    task = Task.model_validate_json(sys.stdin.readline())
    threading.Thread(target=_end_with_parent, args=(sys.stdin,), daemon=True).start()

    def report(message: dict[str, Any]) -> None:
        print(json.dumps(message), file=reports, flush=True)

    def progress(phase: str, done: float, total: float) -> None:
        report({"phase": phase, "done": done, "total": total})

    from server.work import do

    try:
        do(task, progress)
    except Cancelled:
        pass
    except RelightError as error:
        report({"error": _as_report(error)})


def settings_of(method: str, values: dict[str, Any]) -> Any:
    """The method's settings with some values replaced; InputError names a wrong one."""
    from engine.measure.settings import settings_from
    from engine.methods import METHODS

    try:
        return settings_from(METHODS[method].settings, values)
    except InputError as error:
        raise InputError(error.message, field=f"settings.{error.field}".rstrip(".")) from None


if __name__ == "__main__":
    main()
    # Threads of the engine's pools have nothing more to do.
    sys.stderr.flush()
    os._exit(0)
