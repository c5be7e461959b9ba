"""Every example of /openapi.json, sent for real."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from httpx import Client, Response
from pydantic import TypeAdapter

from engine.methods.base import Progress
from server import wire
from server.app import create_app
from server.examples import BYTES, EXAMPLES, JSON
from server.precompute import Task
from server.work import do

# Fits codes to a material; opens a scene that was sent in a process of its own.
SLOW = [("post", "/api/measured"), ("post", "/api/scenes"), ("delete", "/api/scenes/{scene}")]


def here(task: Task, progress: Progress) -> None:
    """References in this process; other jobs wait to be stopped."""
    while task.work != "reference":
        progress("waiting", 0, 1)
        time.sleep(0.01)
    do(task, progress)


@pytest.fixture(scope="module")
def client(
    tiny_scene: Path, serving: Callable[[FastAPI], AbstractContextManager[str]]
) -> Iterator[Client]:
    app = create_app([str(tiny_scene)], precompute=here, precompute_at_start=False)
    with serving(app) as address, Client(base_url=address, timeout=60) as client:
        yield client


def operations(client: Client) -> dict[tuple[str, str], dict[str, Any]]:
    paths = client.get("/openapi.json").json()["paths"]
    return {(m, path): op for path, found in paths.items() for m, op in found.items()}


def send(
    client: Client, method: str, path: str, operation: dict[str, Any], job: str, scene: str
) -> Response:
    """The request that the schema describes, of the scene and the job that there are."""
    query, places = {}, {"scene": scene, "job": job}
    for parameter in operation.get("parameters", ()):
        if parameter["in"] == "path":
            assert parameter["example"], parameter
            places.setdefault(parameter["name"], parameter["example"])
        elif "example" in parameter:
            query[parameter["name"]] = parameter["example"]
        else:
            assert not parameter["required"], f"{path}: {parameter['name']} has no example"
    more: dict[str, Any] = {}
    for media, content in operation.get("requestBody", {"content": {}})["content"].items():
        more = {"content": content["example"]} if media == BYTES else {"json": content["example"]}
    return client.request(method, path.format(**places), params=query, **more)


def shape(value: Any) -> Any:
    """Keys of an object, or of the first in a list of them."""
    if isinstance(value, list):
        return [shape(each) for each in value[:1]]
    return sorted(value) if isinstance(value, dict) else None


def check(
    client: Client,
    method: str,
    path: str,
    operation: dict[str, Any],
    job: str,
    scene: str = "tiny-box",
) -> Response:
    """The answer to an example, which is as the schema says."""
    answer = send(client, method, path, operation, job, scene)
    (status,) = [status for status in operation["responses"] if status.startswith("2")]
    assert answer.status_code == int(status), f"{method} {path}: {answer.text}"
    documented = operation["responses"][status].get("content", {}).get(JSON, {})
    if documented:
        assert "example" in documented, f"{method} {path} has no example of its answer"
        assert shape(answer.json()) == shape(documented["example"]), path
    return answer


@pytest.mark.sweep
def test_slow_examples_do_what_they_say(client: Client) -> None:
    found, scene = operations(client), "tiny-box"
    for method, path in SLOW:
        answer = check(client, method, path, found[method, path], "", scene)
        if (method, path) == ("post", "/api/scenes"):
            scene = answer.json()["name"]


def test_every_example_does_what_it_says(client: Client) -> None:
    found = operations(client)
    assert found.keys() == EXAMPLES.keys(), "every route has an example"
    for key in SLOW:
        del found[key]
    # First what a job is needed for.
    job = ""
    order = sorted(found, key=lambda key: ("{job}" in key[1], key[0] == "delete", key))
    reference = ("post", "/api/scenes/{scene}/reference")
    order.remove(reference)
    for method, path in [reference, *order]:
        answer = check(client, method, path, found[method, path], job)
        if (method, path) == reference:
            job = answer.json()["id"]
            state = {"status": "queued"}
            while state["status"] in ("queued", "running"):
                time.sleep(0.02)
                state = client.get(f"/api/jobs/{job}").json()
            assert state["status"] == "done", state


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        (("get", "/api/scenes"), list[wire.SceneSummary]),
        (("get", "/api/scenes/{scene}"), wire.SceneDetail),
        (("post", "/api/scenes/{scene}/materials"), list[wire.MaterialDetail]),
        (("get", "/api/jobs/{job}"), wire.JobState),
        (("get", "/api/scenes/{scene}/chart"), wire.Chart),
        (("get", "/api/jobs/{job}/reference"), wire.ReferenceResult),
        (("post", "/api/maps"), wire.MapSummary),
        (("post", "/api/measured"), wire.MeasuredSent),
    ],
)
def test_answers_are_of_their_types(path: tuple[str, str], kind: Any) -> None:
    TypeAdapter(kind).validate_python(EXAMPLES[path].answer)
