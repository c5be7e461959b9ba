"""Measured materials by name: their pictures, files that are sent in, and what is refused."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import FastAPI
from numpy.typing import NDArray
from PIL import Image

from engine.brdf.acquisition.csv_table import COLUMNS
from engine.brdf.thumbnail import SIZE
from server.app import MAX_MEASURED, create_app
from server.intake import Intake
from server.measured import KEPT, Samples, stem_of

Serving = Callable[[FastAPI], AbstractContextManager[str]]
ANGLES = (10, 40, 70)
SCENE = {
    "camera": {"position": [0, 0, 3], "target": [0, 0, 0], "width": 16, "height": 16,
               "fov_y_degrees": 40},
    "environment": {"map": [1, 1, 1]},
    "lights": [{"id": "key", "type": "point", "position": [1, 1, 3], "intensity": [20, 20, 20]}],
    "materials": {"ball": {"type": "measured", "file": "below/green.csv"}},
    "objects": [{"name": "ball", "mesh": {"shape": "sphere", "radius": 1, "rings": 8},
                 "material": "ball"}],
}  # fmt: skip


def table(colour: tuple[float, float, float]) -> str:
    """An even material that was measured in few places."""
    values = ",".join(map(str, colour))
    rows = [f"{i},0,{o},{p},{values}" for i in ANGLES for o in ANGLES for p in (0, 90, 180)]
    return "\n".join([",".join(COLUMNS), *rows])


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory, serving: Serving) -> Iterator[httpx.Client]:
    """A service over a ball with measured materials beside it, and a store of its own."""
    folder = tmp_path_factory.mktemp("scene")
    (folder / "ball.json").write_text(json.dumps(SCENE))
    (folder / "below").mkdir()
    for name, colour in (("below/green.csv", (0.02, 0.2, 0.02)), ("red.csv", (0.2, 0.02, 0.02)),
                         ("below/deep.csv", (0.1, 0.1, 0.1))):  # fmt: skip
        (folder / name).write_text(table(colour))
    (folder / "cut.csv").write_text(table((1, 1, 1))[:-3])
    (folder / "notes.txt").write_text("nothing")
    (folder.parent / "outside.csv").write_text(table((1, 1, 1)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RELIGHT_STORE", str(tmp_path_factory.mktemp("store")))
        app = create_app([str(folder / "ball.json")], precompute_at_start=False)
        with serving(app) as address, httpx.Client(base_url=address, timeout=300) as client:
            yield client


@pytest.fixture(scope="module")
def ready(client: httpx.Client) -> httpx.Client:
    """The same with the method's product."""
    job = client.post("/api/scenes/ball/precompute", json={"method": "wavelet_brdf"}).json()
    while (state := client.get(f"/api/jobs/{job['id']}").json())["status"] in ("queued", "running"):
        time.sleep(0.1)
    assert state["status"] == "done", state
    return client


def send(client: httpx.Client, data: str | bytes, name: str = "blue.csv") -> httpx.Response:
    return client.post("/api/measured", content=data, params={"name": name})


def thumbnail(client: httpx.Client, material: Any, **headers: str) -> httpx.Response:
    query = {"material": json.dumps(material)}
    return client.get("/api/scenes/ball/materials/thumbnail", params=query, headers=headers)


def picture(response: httpx.Response) -> NDArray[np.float64]:
    assert response.status_code == 200, response.text
    return np.asarray(Image.open(io.BytesIO(response.content)), float)


def frame(client: httpx.Client, edits: Any, settings: Any = None) -> httpx.Response:
    query = {"method": "wavelet_brdf", "settings": json.dumps(settings or {})}
    headers = {"Accept": "image/png"}
    return client.post("/api/scenes/ball/frame", json=edits, params=query, headers=headers)


def measured(file: str) -> Any:
    return {"type": "measured", "file": file}


def test_what_there_is_to_choose(client: httpx.Client) -> None:
    detail = client.get("/api/scenes/ball").json()
    names = [(m["name"], m["kind"]) for m in detail["measured"]]
    assert names == [
        *((name, "built_in") for name in ("plastic", "brushed", "threads")),
        ("cut.csv", "beside"), ("red.csv", "beside"),
    ]  # fmt: skip
    methods = {method["name"]: method for method in detail["methods"]}
    assert "measured" in methods["wavelet_brdf"]["models"]
    assert "measured" not in methods["brdf_editing"]["models"]
    assert methods["wavelet_brdf"]["settings"]["show"] == "radiance"
    assert methods["glossy_prt"]["settings"] == {}
    # A built-in scene has no folder.
    other = client.get("/api/scenes/cornell-box").json()["measured"]
    assert {m["kind"] for m in other} == {"built_in"}


def test_a_thumbnail_is_a_ball_of_the_material(client: httpx.Client) -> None:
    red = thumbnail(client, measured("red.csv"))
    image = picture(red)
    assert image.shape == (SIZE, SIZE, 3)
    assert image[0, 0].max() == 0
    middle = image[SIZE // 2, SIZE // 2]
    assert middle[0] > 2 * middle[1] > 0
    known = thumbnail(client, measured("red.csv"), **{"If-None-Match": red.headers["etag"]})
    assert known.status_code == 304
    own = thumbnail(client, measured("below/green.csv"))  # the scene's own, wherever it is
    assert own.headers["etag"] != red.headers["etag"]
    model = thumbnail(client, {"type": "ward", "roughness": 0.05})
    assert picture(model).max() == 255


def test_thumbnails_are_quick_once_encoded(client: httpx.Client) -> None:
    thumbnail(client, {"type": "ward"})
    start = time.perf_counter()
    for k in range(10):
        thumbnail(client, measured("red.csv") | {"specular": [1, 1, 0.5 + 0.05 * k]})
    assert (time.perf_counter() - start) / 10 < 0.2  # a good part of which is the network's


@pytest.mark.parametrize(
    ("material", "field"),
    [
        (measured("../outside.csv"), "material.file"),
        (measured("/etc/passwd"), "material.file"),
        (measured("below/deep.csv"), "material.file"),
        (measured("notes.txt"), "material.file"),
        (measured("a\0.csv"), "material.file"),
        (measured("upload:" + "0" * 32), "material.file"),
        (measured("cut.csv"), "material.file"),
        ({"type": "velvet"}, "material"),
        ({"type": "ward", "roughness": 7}, "material.ward.roughness"),
        ("no material", "material"),
    ],
)
def test_what_has_no_thumbnail(client: httpx.Client, material: Any, field: str) -> None:
    answer = thumbnail(client, material)
    assert (answer.status_code, answer.json()["field"]) == (422, field)
    assert answer.headers["content-type"] == "application/problem+json"
    assert "/" not in answer.json()["file"]


def test_no_edit_reads_elsewhere(client: httpx.Client) -> None:
    edits = {"materials": {"ball": {"file": "../outside.csv"}}}
    for path in ("frame", "materials", "precompute"):
        body = {"edits": edits} if path == "precompute" else edits
        answer = client.post(f"/api/scenes/ball/{path}", json=body)
        assert (answer.status_code, answer.json()["field"]) == (422, "materials.ball.file"), path


def test_before_its_product_a_frame_has_the_material_and_no_sky(client: httpx.Client) -> None:
    own = frame(client, {})
    red = frame(client, {"materials": {"ball": measured("red.csv")}})
    header = json.loads(red.headers["relight-frame"])
    if header["method"] == "wavelet_brdf":
        pytest.fail("the product is there already: this test comes too late")
    assert [w["code"] for w in header["warnings"]] == ["codes_pending"]
    for image, channel in ((picture(own), 1), (picture(red), 0)):
        assert image[8, 8].argmax() == channel
        assert image[8, 8, 2] < 0.6 * image[8, 8, channel]


def test_materials_are_switched_without_a_precompute(ready: httpx.Client) -> None:
    sent = send(ready, table((0.02, 0.02, 0.2)), "C:\\lab\\my blue.csv")
    assert sent.status_code == 201, sent.text
    name = sent.json()["material"]["name"]
    assert sent.json()["material"]["label"] == "my blue.csv"
    assert "'my blue'" in sent.json()["diagnoses"][0]["message"]
    for file, channel in (("below/green.csv", 1), ("red.csv", 0), (name, 2)):
        edits = {"materials": {"ball": measured(file)}, "camera": {"position": [0, 1, 3]}}
        drawn = frame(ready, edits)
        header = json.loads(drawn.headers["relight-frame"])
        assert (header["method"], header["job"]) == ("wavelet_brdf", None)
        assert picture(drawn)[8, 8].argmax() == channel
        asked = {"method": "wavelet_brdf"}
        told = ready.post("/api/scenes/ball/materials", json=edits, params=asked).json()[0]
        assert told["description"]["file"] == file
        assert told["bytes"] > 1000
        assert 0 <= told["error"] < 0.05
    assert name in [m["name"] for m in ready.get("/api/scenes/ball").json()["measured"]]


def test_a_frame_asks_for_levels(ready: httpx.Client) -> None:
    usual = picture(frame(ready, {}))
    levels = picture(frame(ready, {}, {"show": "levels", "detail": "finest"}))
    assert levels[8, 8].argmax() == 2
    assert usual[8, 8].argmax() == 1
    np.testing.assert_array_equal(picture(frame(ready, {})), usual)


@pytest.mark.parametrize(
    ("settings", "field"),
    [
        ('{"cells": 8}', "settings.cells"),
        ('{"show": "nothing"}', "settings.show"),
        ('{"alpha": -1}', "settings.alpha"),
        ("[]", "settings"),
        ("{", "settings"),
    ],
)
def test_settings_that_no_frame_may_ask_for(ready: httpx.Client, settings: str, field: str) -> None:
    query = {"method": "wavelet_brdf", "settings": settings}
    answer = ready.post("/api/scenes/ball/frame", json={}, params=query)
    assert (answer.status_code, answer.json()["field"]) == (422, field)


BAD = {
    "unknown kind": ("bad.exe", b"MZ", "name", ".csv"),
    "no name": ("", b"", "name", ".csv"),
    "empty": ("bad.csv", b"", "line 1", "missing"),
    "cut short": ("bad.csv", table((1, 1, 1))[:-3].encode(), "line 28", "cells"),
    "no text": ("bad.csv", bytes(range(256)), "", ""),
    "words": ("bad.brdf", b"12 samples", "line 1", "not a number"),
    "short MERL": ("bad.binary", b"\x5a\0\0\0" * 3, "", ""),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_problems_and_leave_nothing(client: httpx.Client, case: str) -> None:
    name, data, field, words = BAD[case]
    before = client.get("/api/scenes/ball").json()["measured"]
    answer = send(client, data, f"../../etc/{name}" if name else "")
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert words in problem["detail"]
    assert "/" not in problem["detail"] + problem["file"]
    if field:
        assert problem["field"] == field
    assert client.get("/api/scenes/ball").json()["measured"] == before


def test_too_large_a_file(client: httpx.Client) -> None:
    def chunks() -> Iterator[bytes]:
        for _ in range((MAX_MEASURED >> 20) + 1):
            yield bytes(1 << 20)

    answer = client.post("/api/measured", params={"name": "a.csv"}, content=chunks())
    assert answer.status_code == 413
    assert client.get("/healthz").status_code == 200


def test_the_oldest_go(tmp_path: Path) -> None:
    samples = Samples(tmp_path, Intake())
    for k in range(KEPT + 3):
        digest = f"{k:032x}"
        (tmp_path / digest).mkdir()
        (tmp_path / digest / "m.csv").write_text("")
        note = {"name": f"upload:{digest}", "label": "m", "kind": "upload"}
        (tmp_path / f"{digest}.json").write_text(json.dumps(note))
    received = tmp_path / "new-room" / "new.csv"
    received.parent.mkdir()
    received.write_text(table((0.1, 0.1, 0.1)))
    newest = samples._take(received, "f" * 32, "new.csv").material
    assert samples.all()[0] == newest
    assert len(samples.all()) == KEPT
    path = samples.path(newest.name)
    assert path is not None
    assert samples.name_of(str(path)) == newest.name
    assert len(list(tmp_path.glob("*/*.csv"))) == KEPT


def test_names_for_any_disk() -> None:
    assert stem_of("a b-c.csv") == "a b-c"
    assert stem_of("..\\x/y.csv") == "y"
    assert stem_of("é:*.csv") == "___"
    assert stem_of(" .csv") == "sample"
