"""Environment maps by name: from the scene's folder, sent in, and what is refused."""

from __future__ import annotations

import io
import json
import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import httpx
import imagecodecs
import numpy as np
import pytest
from fastapi import FastAPI
from numpy.typing import NDArray
from PIL import Image

from engine.errors import BackendError
from engine.images import encode_exr, read_image
from engine.methods.base import Progress
from engine.scene.builtin import cornell_box
from server.app import MAX_MAP, create_app
from server.decode import MAX_PIXELS
from server.intake import Intake
from server.maps import KEPT, LABEL, Uploads, label_of
from server.precompute import Task

Serving = Callable[[FastAPI], AbstractContextManager[str]]
RED, BLUE = (0.8, 0.1, 0.1), (0.1, 0.1, 0.8)


def even(colour: tuple[float, float, float], shape: tuple[int, int] = (8, 16)) -> NDArray:
    return np.broadcast_to(np.float32(colour), (*shape, 3)).copy()


def refused(task: Task, progress: Progress) -> None:
    """Frames stay direct."""
    raise BackendError("no precompute in this test")


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory, serving: Serving) -> Iterator[httpx.Client]:
    """A service over a small box with a map beside it, and a store of its own."""
    folder = tmp_path_factory.mktemp("scene")
    document = cornell_box.document()
    document["camera"] |= {"width": 24, "height": 18}
    (folder / "box.json").write_text(json.dumps(document))
    (folder / "beside.exr").write_bytes(encode_exr(even(BLUE)))
    (folder / "notes.txt").write_text("nothing")
    (folder / "below").mkdir()
    (folder / "below" / "deep.exr").write_bytes(encode_exr(even(BLUE)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RELIGHT_STORE", str(tmp_path_factory.mktemp("store")))
        app = create_app([str(folder / "box.json")], precompute=refused, precompute_at_start=False)
        with serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
            yield client


def send(client: httpx.Client, data: bytes, name: str = "sunset.exr") -> httpx.Response:
    return client.post("/api/maps", content=data, params={"name": name})


def lit(client: httpx.Client, name: str) -> NDArray[np.float64]:
    """The mean colour of the box under a map, without its lamps."""
    off = [{"id": light, "enabled": False} for light in ("key", "ceiling")]
    response = client.post(
        "/api/scenes/box/frame",
        json={"lights": off, "environment": {"map": name, "background": False}},
        headers={"Accept": "image/png"},
    )
    assert response.status_code == 200, response.text
    return np.asarray(Image.open(io.BytesIO(response.content)), float).mean(axis=(0, 1))


def test_maps_beside_the_scene_can_be_chosen(client: httpx.Client) -> None:
    detail = client.get("/api/scenes/box").json()["environment"]
    assert detail["maps"] == ["studio", "beside.exr"]
    red, _, blue = lit(client, "beside.exr")
    assert blue > 2 * red
    # A built-in scene has no folder, and nothing is read from below one.
    assert client.get("/api/scenes/cornell-box").json()["environment"]["maps"] == ["studio"]
    for name in ("below/deep.exr", "notes.txt", "below"):
        answer = client.post("/api/scenes/box/frame", json={"environment": {"map": name}})
        assert (answer.status_code, answer.json()["field"]) == (422, "environment.map")


@pytest.mark.parametrize("kind", ["exr", "hdr"])
def test_a_map_that_was_sent_lights_the_scene(client: httpx.Client, kind: str) -> None:
    data = encode_exr(even(RED)) if kind == "exr" else imagecodecs.rgbe_encode(even(RED))
    answer = send(client, data, f"C:\\pictures\\sunset.{kind}")
    assert answer.status_code == 201, answer.text
    sent = answer.json()
    assert (sent["label"], sent["width"], sent["height"]) == (f"sunset.{kind}", 16, 8)
    red, _, blue = lit(client, sent["name"])
    assert red > 2 * blue
    listed = client.get("/api/scenes/cornell-box").json()["environment"]["uploads"]
    assert sent in listed
    # Sent again it is the same.
    assert send(client, data).json()["name"] == sent["name"]


def test_a_cube_map_comes_in_as_a_map(client: httpx.Client) -> None:
    sent = send(client, encode_exr(even(RED, (12, 16)))).json()
    assert (sent["width"], sent["height"]) == (16, 8)


def huge(data: bytes, width: int, height: int) -> bytes:
    """An EXR file that says to have so many pixels."""
    window = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    return data[:window] + struct.pack("<4i", 0, 0, width - 1, height - 1) + data[window + 16 :]


BAD = {
    "empty": (b"", "neither an OpenEXR"),
    "text": (b"hello", "neither an OpenEXR"),
    "picture": (b"\x89PNG\r\n", "neither an OpenEXR"),
    "cut": (encode_exr(even(RED))[:200], "not a readable EXR"),
    "noise": (b"\x76\x2f\x31\x01" + bytes(range(256)) * 8, "not a readable EXR"),
    "no size": (b"#?RADIANCE\n\n", "no size"),
    "cut hdr": (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n\x02", "not a readable"),
    "square": (encode_exr(even(RED, (8, 8))), "twice as wide as high"),
    "nan": (encode_exr(even((np.nan, 1, 1))), "NaN or infinite"),
    "infinite": (encode_exr(even((np.inf, 1, 1))), "NaN or infinite"),
    "huge": (huge(encode_exr(even(RED)), 2 * 60_000, 60_000), f"{MAX_PIXELS >> 20} million"),
    "huge hdr": (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 40000 +X 80000\n", "million"),
    "turned round": (huge(encode_exr(even(RED)), -5, 5), ""),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_problems_and_leave_nothing(client: httpx.Client, name: str) -> None:
    data, words = BAD[name]
    before = client.get("/api/scenes/box").json()["environment"]["uploads"]
    answer = send(client, data, "../../etc/bad.exr")
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert (problem["field"], problem["file"]) == ("map", "bad.exr")
    assert words in problem["detail"]
    assert "/" not in problem["detail"].replace("/api/", "")
    assert client.get("/api/scenes/box").json()["environment"]["uploads"] == before


def test_too_much_is_refused_before_it_is_read(client: httpx.Client) -> None:
    """By what the request says of its length; elsewhere bodies stay small."""
    with socket.create_connection((client.base_url.host, client.base_url.port or 80)) as raw:
        lines = ("POST /api/maps HTTP/1.1", "Host: 127.0.0.1", f"Content-Length: {MAX_MAP + 1}")
        raw.sendall("\r\n".join([*lines, "", ""]).encode())
        assert raw.recv(64).startswith(b"HTTP/1.1 413")
    assert client.post("/api/scenes/box/frame", content=b" " * (2 << 20)).status_code == 413


def test_no_answer_has_a_path_of_this_machine(client: httpx.Client) -> None:
    sent = send(client, encode_exr(even(RED)))
    name = sent.json()["name"]
    edits = {"environment": {"map": name, "rotation_degrees": "much"}}
    answers = [
        sent,
        client.get("/api/scenes/box"),
        client.post("/api/scenes/box/frame", json=edits),
        client.post("/api/scenes/box/frame", json={"environment": {"map": "upload:" + 32 * "0"}}),
    ]
    assert [answer.status_code for answer in answers] == [201, 200, 422, 422]
    for answer in answers:
        for part in ("/tmp", "store", str(Path.home()), "maps/"):
            assert part not in answer.text.replace("sent", "")


def picture(client: httpx.Client, edits: object, scene: str = "box") -> NDArray[np.float64]:
    answer = client.post(f"/api/scenes/{scene}/environment", json=edits)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "image/png"
    return np.asarray(Image.open(io.BytesIO(answer.content)), float)


def test_a_small_picture_of_the_map(client: httpx.Client) -> None:
    """As bright as shows it well, not turned, whatever else the edits say."""
    studio = picture(client, {"environment": {"map": "studio"}})
    assert studio.shape == (128, 256, 3)
    more = {"map": "studio", "intensity": 9, "rotation_degrees": 50, "background": False,
            "area_light": {"direction": [0, 0, 1]}}  # fmt: skip
    np.testing.assert_array_equal(picture(client, {"environment": more}), studio)
    sky = picture(client, {"environment": {"map": {"sun_direction": [0, -1, 1]}}})
    assert sky[10].mean(axis=0)[2] > sky[10].mean(axis=0)[0]  # blue
    sent = send(client, encode_exr(even(RED))).json()["name"]
    red = picture(client, {"environment": {"map": sent}})
    assert red[..., 0].min() > 2 * red[..., 2].max()
    assert client.post("/api/scenes/box/environment", json={}).status_code == 404


def test_a_sun_does_not_blacken_the_rest_of_the_picture(client: httpx.Client) -> None:
    image = even((0.2, 0.2, 0.2), (64, 128))
    image[20, 30] = 1e5
    sent = send(client, encode_exr(image)).json()["name"]
    assert np.median(picture(client, {"environment": {"map": sent}})) > 100


def test_the_oldest_go(tmp_path: Path) -> None:
    uploads = Uploads(tmp_path, Intake())
    for k in range(KEPT + 3):
        stem = f"{k:032x}"
        (tmp_path / f"{stem}.exr").write_bytes(b"")
        (tmp_path / f"{stem}.json").write_text(
            json.dumps({"name": f"upload:{stem}", "label": "m", "width": 2, "height": 1})
        )
    received = tmp_path / "room" / "map"
    received.parent.mkdir()
    received.write_bytes(encode_exr(even(RED)))
    newest = uploads._take(received, "f" * 32, "new")
    assert uploads.all()[0] == newest
    assert len(uploads.all()) == KEPT
    assert len(list(tmp_path.glob("*.exr"))) == KEPT
    path = uploads.path(newest.name)
    assert path is not None
    np.testing.assert_array_equal(read_image(path), even(RED))


def test_labels() -> None:
    assert label_of("/a/b\\c.exr") == "c.exr"
    assert label_of("\x00\n") == "map"
    assert label_of("") == "map"
    assert len(label_of("x" * 500)) == LABEL
