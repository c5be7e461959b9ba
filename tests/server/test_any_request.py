"""Ten thousand requests that nobody means well with: as the API's own description allows, and not.

A request may be refused in many ways, but none may break the service or keep it busy for good.
"""

from __future__ import annotations

import collections
import contextlib
import copy
import json
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import hostile
import httpx
import numpy as np
import pytest
from fastapi import FastAPI

from engine.errors import BackendError
from engine.methods.base import Progress
from server import acquire, decode, maps, measured, read_scene, scenes
from server.app import create_app
from server.precompute import Task
from server.wire import Notice

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import schemathesis
    from hypothesis import HealthCheck, Phase, given, settings
    from hypothesis.errors import Unsatisfiable
    from schemathesis import GenerationMode
    from schemathesis.core import NOT_SET

pytestmark = [pytest.mark.sweep, pytest.mark.filterwarnings("default")]
COUNT = 10_000
MORE = 1.4  # to ask for, as some strategies run out of requests
SECONDS = 120.0  # for one request
ALMOST = 2_000
PNG = {"Accept": "image/png", "Content-Type": "application/json"}
EDITS: dict[str, Any] = {
    "camera": {"position": [0.2, 0.3, -0.6], "fov_y_degrees": 40, "width": 24, "height": 18},
    "environment": {
        "map": {"sun_direction": [1, -1, 0.3], "turbidity": 3, "ground": [0.2, 0.2, 0.2]},
        "rotation_degrees": 10, "intensity": 2, "background": True,
        "area_light": {"direction": [1, -1, 0], "radius_degrees": 10, "radiance": [9, 8, 7]},
    },
    "lights": [
        {"id": "key", "position": [0.2, 0.4, 0.1], "intensity": [0.3, 0.2, 0.1]},
        {"id": "ceiling", "enabled": False, "width": 0.2},
        {"id": "new", "type": "spot", "position": [0.2, 0.4, 0.1], "target": [0, 0, 0],
         "intensity": [1, 1, 1], "cone_degrees": 30, "penumbra_degrees": 5},
        {"id": "beam", "type": "projector", "position": [0.2, 0.4, 0.1], "target": [0, 0, 0],
         "intensity": [1, 1, 1], "image": "window", "fov_y_degrees": 30},
    ],
}  # fmt: skip
KINDS = {"/api/scenes": (".glb", ".gltf", ".obj", ".ply", ".stl", ".zip"),
         "/api/maps": (".exr", ".hdr"), "/api/measured": (".csv", ".brdf", ".binary")}  # fmt: skip


def nothing(task: Task, progress: Progress) -> None:
    raise BackendError("no precompute in this test")


@pytest.fixture
def address(
    tmp_path: Path,
    tiny_scene: Path,
    serving: Callable[[FastAPI], AbstractContextManager[str]],
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[tuple[str, dict[str, Any]]]:
    """A service that reads what is sent in its own process, and what it says of itself."""

    def decoded(source: Path, target: Path) -> tuple[int, int]:
        found = decode.read(source, target)
        return found["width"], found["height"]

    def acquired(path: Path) -> list[Notice]:
        return [Notice.model_validate(each) for each in acquire.read(path)["diagnoses"]]

    monkeypatch.setattr(maps, "decode", decoded)
    monkeypatch.setattr(measured, "acquire", acquired)
    monkeypatch.setattr(scenes, "read_scene", lambda a, b: Path(read_scene.read(a, b)["scene"]))
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path / "store"))
    app = create_app([str(tiny_scene)], precompute=nothing, precompute_at_start=False)
    with serving(app) as address:
        yield address, app.openapi()


def strategies(operation: Any) -> Iterator[Any]:
    """Requests as described, and others; mostly of the scene that there is."""
    names = {parameter.name for parameter in operation.path_parameters}
    for mode in (GenerationMode.POSITIVE, GenerationMode.NEGATIVE):
        yield operation.as_strategy(generation_mode=mode)
        if "scene" in names:
            known = {"path_parameters": {"scene": "tiny-box"}}
            yield from [operation.as_strategy(generation_mode=mode, **known)] * 3
        for kind in KINDS.get(operation.path, ()) if operation.method == "post" else ():
            yield operation.as_strategy(generation_mode=mode, query={"name": f"a{kind}"})


def for_some(strategy: Any, count: int, send: Callable[[Any], None]) -> None:
    """Send so many requests of a strategy, the same ones every time."""

    @given(case=strategy)
    @settings(
        max_examples=count, database=None, deadline=None, derandomize=True,
        suppress_health_check=list(HealthCheck), phases=[Phase.generate],
    )  # fmt: skip
    def sent(case: Any) -> None:
        send(case)

    # Nothing is wrong with a request that has nothing in it.
    with contextlib.suppress(Unsatisfiable):
        sent()


def test_no_request_does_harm(address: tuple[str, dict[str, Any]], tmp_path: Path) -> None:
    base, described = address
    schema = schemathesis.openapi.from_dict(described)
    operations = [found.ok() for found in schema.get_all_operations()]
    plain = [each for each in operations if not each.query and not each.path_parameters]
    usual = MORE * COUNT // (len(operations) - len(plain))
    found: collections.Counter[tuple[str, int]] = collections.Counter()
    wrong: list[str] = []
    slowest: dict[str, float] = collections.defaultdict(float)

    def send(case: Any) -> None:
        label, begun = case.operation.label, time.monotonic()
        answer = case.call(base_url=base, timeout=SECONDS)
        slowest[label] = max(slowest[label], time.monotonic() - begun)
        found[label, answer.status_code] += 1
        if answer.status_code >= 500 and answer.status_code != 503:
            body = "" if case.body is NOT_SET else str(case.body)[:2000]
            asked = f"{label} {case.path_parameters} {case.query} {body}"
            wrong.append(f"{asked}: {answer.text}")
        assert str(tmp_path).encode() not in answer.content

    for operation in operations:
        ways = list(strategies(operation))
        for strategy in ways:
            for_some(strategy, 5 if operation in plain else 1 + int(usual / len(ways)), send)
    print(*sorted(found.items()), *slowest.items(), sep="\n")
    assert wrong == []
    assert found.total() >= COUNT
    assert httpx.get(f"{base}/healthz").status_code == 200
    assert [path.name for path in tmp_path.iterdir()] == ["store"]
    assert not list((tmp_path / "store").glob("*/new-*"))


def test_edits_that_are_almost_right_do_no_harm(address: tuple[str, dict[str, Any]]) -> None:
    """Those of a person, but for one value that is none, or far too large, or of another kind."""
    base, _ = address
    rng = np.random.default_rng(3)
    found: collections.Counter[int] = collections.Counter()
    wrong: list[str] = []
    drawn = 0
    with httpx.Client(base_url=f"{base}/api/scenes/tiny-box", timeout=SECONDS) as client:
        for k in range(ALMOST):
            edits = copy.deepcopy(EDITS)
            hostile.change_tree(edits, rng)
            route = ("frame", "frame", "environment", "materials", "pick?x=0.5&y=0.5")[k % 5]
            text = json.dumps(edits)
            answer = client.post(f"/{route}", content=text, headers=PNG)
            found[answer.status_code] += 1
            drawn += route == "frame" and answer.status_code == 200
            if answer.status_code >= 500 and answer.status_code != 503:
                wrong.append(f"{route} {text}: {answer.text}")
    print(sorted(found.items()))
    assert wrong == []
    assert drawn > ALMOST / 20
