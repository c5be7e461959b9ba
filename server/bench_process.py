"""The service in a process of its own, for `relight bench --service`."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.errors import BackendError

STOP_SECONDS = 20.0


@dataclass(frozen=True)
class Process:
    """A service that runs; `started` is when it was begun, on `time.perf_counter`'s clock."""

    address: str
    pid: int
    started: float

    def ask(self, path: str, body: Any = None) -> Any:
        """GET a JSON answer, or POST where there is a body."""
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"}
        request = urllib.request.Request(self.address + path, data, headers)
        with urllib.request.urlopen(request) as answer:
            return json.load(answer)

    def gauge(self, name: str) -> float:
        """A value of /metrics."""
        with urllib.request.urlopen(f"{self.address}/metrics") as answer:
            text = answer.read().decode()
        found = re.search(rf"^relight_{name} (\S+)$", text, re.MULTILINE)
        assert found is not None, name
        return float(found[1])

    def memory(self) -> float | None:
        """MB of memory that the process holds; None where the system does not say."""
        try:
            status = Path(f"/proc/{self.pid}/status").read_text()
        except OSError:
            return None
        found = re.search(r"VmRSS:\s+(\d+) kB", status)
        return int(found[1]) * 1024 / 1e6 if found else None


@contextlib.contextmanager
def service(scene: str) -> Iterator[Process]:
    """`relight serve SCENE` on a free port of this machine."""
    environment = {key: value for key, value in os.environ.items() if key != "RELIGHT_TOKEN"}
    started = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "engine.cli", "serve", scene, "--port", "0"],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        address = re.search(r"http://[^\s/]+", process.stdout.readline())
        if address is None:
            raise BackendError("the service did not start; what it says is above")
        yield Process(address[0], process.pid, started)
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()
