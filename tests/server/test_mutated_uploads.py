"""Two thousand damaged files: each is refused in words or read, and nothing else happens."""

from __future__ import annotations

import collections
import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import hostile
import httpx
import numpy as np
import pytest
from fastapi import FastAPI

from server.app import create_app

pytestmark = pytest.mark.sweep
COUNT, SENT = 2000, 200
SECONDS = 60.0  # for one file
READER = Path(__file__).with_name("mutant_reader.py")


def mutants(count: int, seed: int) -> Iterator[tuple[str, bytes]]:
    """(name, damaged bytes), every kind in its turn."""
    rng = np.random.default_rng(seed)
    seeds = {name: make() for name, make in hostile.SEEDS.items()}
    for k in range(count):
        name = list(seeds)[k % len(seeds)]
        yield name, hostile.mutated(name, seeds[name], rng)


class Reader:
    """A reading process, and another one when it dies."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def read(self, file: Path, room: Path) -> dict[str, object]:
        process = self._process or self._started()
        assert process.stdin is not None
        process.stdin.write(json.dumps({"file": str(file), "room": str(room)}) + "\n")
        process.stdin.flush()
        line = self._line(process, SECONDS)
        if line is None:
            self.close()
            return {"died": f"no answer, status {process.returncode}"}
        answer: dict[str, object] = json.loads(line)
        return answer

    def _started(self) -> subprocess.Popen[str]:
        self._process = subprocess.Popen(
            [sys.executable, str(READER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join([*filter(None, sys.path)])},
            text=True,
        )
        assert self._line(self._process, 120) == "ready\n"
        return self._process

    @staticmethod
    def _line(process: subprocess.Popen[str], seconds: float) -> str | None:
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], seconds)
        return (process.stdout.readline() or None) if ready else None

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
        self._process = None


def test_damaged_files_are_refused_or_read(tmp_path: Path) -> None:
    (tmp_path / "secret.ply").write_bytes(hostile.ply())
    reader, found = Reader(), collections.Counter[str]()
    wrong: list[str] = []
    begun = time.monotonic()
    for k, (name, data) in enumerate(mutants(COUNT, seed=1)):
        room = tmp_path / str(k)
        room.mkdir()
        file = room / name
        file.write_bytes(data)
        answer = reader.read(file, room)
        touched = answer.pop("touched", [])
        (what,) = answer
        found[what] += 1
        if what in ("crashed", "died") or touched:
            wrong.append(f"{k} {name}: {answer} {touched}")
    reader.close()
    print(dict(found), f"{time.monotonic() - begun:.0f} s")
    assert sorted(path.name for path in tmp_path.iterdir() if not path.name.isdigit()) == [
        "secret.ply"
    ]
    assert wrong == []
    assert found["accepted"] > COUNT / 10
    assert found["refused"] > COUNT / 10


def test_damaged_files_do_the_service_no_harm(
    tmp_path: Path, serving: Callable[[FastAPI], AbstractContextManager[str]]
) -> None:
    """The same over HTTP, and each scene that is taken is looked at."""
    store = tmp_path / "store"
    found = collections.Counter[int]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RELIGHT_STORE", str(store))
        app = create_app(precompute_at_start=False)
        with serving(app) as address, httpx.Client(base_url=address, timeout=180) as client:
            for name, data in mutants(SENT, seed=2):
                kind = "maps" if name.startswith("sky") else "scenes"
                kind = "measured" if name.startswith("paint") else kind
                answer = client.post(f"/api/{kind}", content=data, params={"name": name})
                found[answer.status_code] += 1
                assert answer.status_code in (201, 422), (name, answer.text)
                assert str(tmp_path) not in answer.text
                if kind == "scenes" and answer.status_code == 201:
                    scene = answer.json()["name"]
                    assert client.get(f"/api/scenes/{scene}").status_code == 200
            assert client.get("/healthz").status_code == 200
            assert len(client.get("/api/scenes").json()) < 40
        assert [path.name for path in tmp_path.iterdir()] == ["store"]
        assert not list(store.glob("*/new-*"))
    print(dict(found))
