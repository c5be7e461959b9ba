"""Scenes that are sent in: what is taken, what is refused and why, and what is left of either."""

from __future__ import annotations

import asyncio
import contextlib
import io
import os
import socket
import struct
import zipfile
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import hostile
import httpx
import pytest
from fastapi import FastAPI
from starlette.requests import ClientDisconnect

from engine.errors import Cancelled, InputError
from server import read_scene, scenes
from server.app import MAX_SCENE, create_app
from server.intake import MOST, OLD_SECONDS, Intake, sweep
from server.problems import Busy
from server.unpack import MAX_ENTRIES, unpack

Serving = Callable[[FastAPI], AbstractContextManager[str]]
BILLION = 1_000_000_000


def glb(**changes: Any) -> bytes:
    return hostile.glb(*hostile.gltf(**changes))


def scene(**changes: Any) -> bytes:
    return hostile.zipped(hostile.files(**changes))


def quad(mesh: str) -> dict[str, Any]:
    return {"objects": [{"name": "quad", "mesh": mesh}]}


def with_mode(name: str, mode: int) -> bytes:
    """A zip whose entry is something else than a plain file."""
    file, entry = io.BytesIO(), zipfile.ZipInfo(name)
    entry.external_attr = mode << 16
    with zipfile.ZipFile(file, "w") as packed:
        packed.writestr(entry, "/etc/passwd")
    return file.getvalue()


def patched(data: bytes, signature: bytes, at: int, *words: int) -> bytes:
    """A zip with other numbers in its last record of a kind."""
    place = data.rindex(signature) + at
    return data[:place] + struct.pack(f"<{len(words)}I", *words) + data[place + 4 * len(words) :]


START, ENTRY, END = b"PK\3\4", b"PK\1\2", b"PK\5\6"
PLAIN = hostile.zipped({"quad.ply": hostile.ply()}, zipfile.ZIP_STORED)
NAN = struct.pack("<f", float("nan"))
REFUSED: dict[str, tuple[str, bytes, str]] = {
    # What zips say of themselves.
    "above": ("a.zip", hostile.zipped({"../quad.ply": hostile.ply()}), "leads out"),
    "above, backslash": ("a.zip", hostile.zipped({"a\\..\\..\\b.ply": b""}), "leads out"),
    "absolute": ("a.zip", hostile.zipped({"/tmp/quad.ply": hostile.ply()}), "absolute"),
    "drive": ("a.zip", hostile.zipped({"C:\\quad.ply": hostile.ply()}), "absolute"),
    "link": ("a.zip", with_mode("quad.ply", 0o120777), "link"),
    "device": ("a.zip", with_mode("quad.ply", 0o020666), "no plain file"),
    # Its name's one byte becomes something else, which nobody reads.
    "nameless": ("a.zip", patched(patched(hostile.zipped({"a": b"x"}), ENTRY, 28, 1 << 16),
                 START, 26, 1 << 16), "neither a scene.json"),
    "deep": ("a.zip", hostile.zipped({"a/" * 20 + "quad.ply": b""}), "too deep"),
    "long": ("a.zip", hostile.zipped({"q" * 200 + ".ply": b""}), "no name for a file"),
    "nested": ("a.zip", hostile.zipped({"inner.zip": PLAIN}), "packed in itself"),
    "twice": ("a.zip", hostile.zipped({"a.ply": b"", "A.PLY": b""}), "twice"),
    "below a file": ("a.zip", hostile.zipped({"a.obj": b"", "a.obj/b.ply": b""}), "below a file"),
    "bomb": ("a.zip", hostile.zipped({"a.bin": bytes(4 << 20)}), "grows more than"),
    "large": ("a.zip", patched(PLAIN, ENTRY, 20, 3 << 28, 3 << 28), "more than 512 MB"),
    "short": ("a.zip", patched(PLAIN, ENTRY, 24, 900), "not a readable zip|shorter"),
    "many": ("a.zip", hostile.zipped({f"{k}": b"" for k in range(MAX_ENTRIES + 1)}), "entries"),
    "very many": ("a.zip", patched(PLAIN, END, 8, 0xFFFFFFFF, 0xFFFFFFF), "entries"),
    "encrypted": ("a.zip", patched(PLAIN, ENTRY, 8, 1), "encrypted"),
    "packed by lzma": ("a.zip", hostile.zipped({"a.ply": b""}, zipfile.ZIP_LZMA), "deflate"),
    "no zip": ("a.zip", hostile.ply(), "not a zip"),
    "cut zip": ("a.zip", PLAIN[:-30], "not a zip"),
    "no scene": ("a.zip", hostile.zipped({"seen.png": hostile.picture()}), "neither a scene.json"),
    "two": ("a.zip", hostile.zipped({"a.ply": b"", "b.ply": b""}), "which is the scene"),
    # What descriptions name.
    "mesh above": ("a.zip", scene(**quad("../secret.ply")), "objects.0.mesh: .*not in its folder"),
    "mesh elsewhere": ("a.zip", scene(**quad("/etc/passwd")), "not in its folder"),
    "mesh on a drive": ("a.zip", scene(**quad("C:\\a.ply")), "not in its folder"),
    "map above": ("a.zip", scene(environment={"map": "maps/../../a.exr"}), "not in its folder"),
    "no mesh": ("a.zip", scene(**quad("none.ply")), "no such file"),
    "no JSON": ("a.zip", hostile.zipped({"scene.json": b"{"}), "not JSON"),
    "deep JSON": ("a.zip", hostile.zipped({"scene.json": b"[" * 9**6}), "cannot be read"),
    # What glTF files say of themselves.
    "own child": ("a.glb", glb(nodes__1__children=[1]), "circle"),
    "circle": ("a.glb", glb(nodes__1__children=[0]), "circle"),
    "elsewhere": ("a.gltf", hostile.in_one(*hostile.gltf(images__0={"uri": "http://x/y.png"})),
                  "nothing is fetched"),
    "buffer elsewhere": ("a.glb", glb(buffers__0__uri="file:///etc/passwd"), "nothing is fetched"),
    "side file": ("a.glb", glb(buffers__0__uri="quad.bin"), "not beside the file"),
    "buffer": ("a.glb", glb(buffers__0__byteLength=BILLION), "says to have 1,000,000,000 bytes"),
    "view": ("a.glb", glb(bufferViews__1__byteOffset=170), "ends at byte 182"),
    "negative": ("a.glb", glb(bufferViews__1__byteOffset=-4), "is -4"),
    "accessor": ("a.glb", glb(accessors__1__count=BILLION), "counts 1,000,000,000"),
    "nothing behind": ("a.glb", glb(accessors__0={"componentType": 5126, "type": "VEC3",
                       "count": BILLION}), "has no bytes"),
    "corner": ("a.glb", glb(accessors__0__count=3), "refers to vertex 3"),
    "far": ("a.glb", glb(nodes__1__scale=[1e30, 1, 1]), "reaches beyond"),
    "flat": ("a.glb", glb(nodes__1__scale=[1, 0, 1]), "no inverse"),
    "hidden": ("a.glb", glb(nodes__1__scale=[0, 0, 0]), "no triangles"),
    "cut glb": ("a.glb", glb()[:-40], "says to have"),
    # What other meshes say of themselves.
    "ply faces": ("a.ply", hostile.ply(face_2=f"face {BILLION}"), "promises 1,000,000,000"),
    "ply text": ("a.ply", hostile.ply("ascii", vertex_4=f"vertex {BILLION}"), "promises"),
    "ply header": ("a.ply", hostile.ply().replace(b"end_header", b""), "does not end"),
    "stl": ("a.stl", hostile.stl(BILLION), "counts 1,000,000,000 triangles"),
    "nan": ("a.stl", hostile.stl().replace(struct.pack("<f", -1), NAN, 1), "not a finite place"),
    "infinite": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1e999 1 0\nf 1 2 3\n", "not a finite place"),
    "no corner": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "vertex"),
    "empty": ("a.obj", b"", "no triangles"),
    "line": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "zero area"),
    "another kind": ("a.glb", hostile.ply(), "cannot be read as glTF"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_hostile_files_are_refused_in_words(tmp_path: Path, name: str) -> None:
    """In this process, so that each takes milliseconds; `read` is all that the other one runs."""
    file_name, data, words = REFUSED[name]
    (tmp_path / "secret.ply").write_bytes(hostile.ply())
    folder = tmp_path / "room" / "files"
    folder.mkdir(parents=True)
    source = folder.parent / file_name
    source.write_bytes(data)
    with pytest.raises(InputError, match=words) as caught:
        read_scene.read(source, folder)
    assert str(tmp_path) not in str(caught.value)
    assert {path.name for path in tmp_path.iterdir()} == {"secret.ply", "room"}
    assert {path.name for path in folder.parent.iterdir()} <= {file_name, "files"}


@pytest.mark.parametrize(
    "name", [name for name in hostile.SEEDS if name.endswith(read_scene.KINDS)]
)
def test_files_that_mean_well_are_taken(tmp_path: Path, name: str) -> None:
    source = tmp_path / name
    source.write_bytes(hostile.SEEDS[name]())
    (tmp_path / "files").mkdir()
    found = read_scene.read(source, tmp_path / "files")
    assert (tmp_path / "files" / found["scene"]).is_file()


def test_a_zip_may_have_a_folder_and_litter(tmp_path: Path) -> None:
    inside = {f"my scene/{name}": data for name, data in hostile.files().items()}
    litter = {"__MACOSX/my scene/._quad.ply": b"x", "my scene/notes.txt": b"x", "a/.DS_Store": b""}
    source = tmp_path / "a.zip"
    source.write_bytes(hostile.zipped({**inside, **litter}))
    unpack(source, tmp_path / "files")
    written = [path for path in (tmp_path / "files").rglob("*") if path.is_file()]
    assert len(written) == len(inside)
    assert read_scene.the_scene(tmp_path / "files") == tmp_path / "files/my scene/scene.json"


def test_what_is_too_much_for_a_service(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "scene.zip"
    source.write_bytes(scene())
    limits = {"MAX_TRIANGLES": "2 triangles", "MAX_TEXELS": "4 texels", "MAX_PIXELS": "its map"}
    for limit, words in limits.items():
        folder = tmp_path / limit
        folder.mkdir()
        with monkeypatch.context() as patch:
            patch.setattr(read_scene, limit, 1)
            with pytest.raises(InputError, match=words):
                read_scene.read(source, folder)


@contextlib.contextmanager
def started(store: Path, serving: Serving, patch: pytest.MonkeyPatch) -> Iterator[httpx.Client]:
    """A client of a new service over a store."""
    patch.setenv("RELIGHT_STORE", str(store))
    app = create_app(precompute_at_start=False)
    with serving(app) as address, httpx.Client(base_url=address, timeout=120) as client:
        yield client


def send(client: httpx.Client, data: bytes, name: str) -> httpx.Response:
    return client.post("/api/scenes", content=data, params={"name": name})


def test_a_scene_that_was_sent_is_one_like_others(tmp_path: Path, serving: Serving) -> None:
    """Read in its own process, shown, there again after a restart, and gone when it is removed."""
    lamp = {"id": "key", "type": "point", "position": [0, 0, 3], "intensity": [9, 9, 9]}
    data, sent_files = scene(lights=[lamp]), tmp_path / "scenes"
    with pytest.MonkeyPatch.context() as patch:
        with started(tmp_path, serving, patch) as client:
            answer = send(client, data, "C:\\art\\my scene.zip")
            assert answer.status_code == 201, answer.text
            sent = answer.json()
            assert (sent["description"], sent["sent"]) == ("my scene.zip", True)
            assert answer.headers["location"] == f"/api/scenes/{sent['name']}"
            assert sent in client.get("/api/scenes").json()
            detail = client.get(f"/api/scenes/{sent['name']}").json()
            assert (detail["triangles"], detail["objects"]) == (2, ["quad"])
            # Sent again it is the same, and is not read again.
            assert send(client, data, "again.zip").json() == sent
            assert len([*sent_files.iterdir()]) == 2
        with started(tmp_path, serving, patch) as client:
            assert sent in client.get("/api/scenes").json()
            frame = client.post(f"/api/scenes/{sent['name']}/frame?scale=2")
            assert frame.status_code == 200, frame.text
            assert client.delete("/api/scenes/cornell-box").status_code == 403
            assert client.delete(f"/api/scenes/{sent['name']}").status_code == 204
            assert client.get(f"/api/scenes/{sent['name']}").status_code == 404
            assert [*sent_files.iterdir()] == []


@pytest.fixture
def quick(tmp_path: Path, serving: Serving, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A client of a service that reads in its own process."""

    def read_here(source: Path, folder: Path) -> Path:
        return Path(read_scene.read(source, folder)["scene"])

    monkeypatch.setattr(scenes, "read_scene", read_here)
    with started(tmp_path, serving, monkeypatch) as client:
        yield client


def test_problems_say_what_is_wrong_and_leave_nothing(quick: httpx.Client, tmp_path: Path) -> None:
    for name, data, status, words in (
        ("a.fbx", b"x", 415, ".glb"),
        ("", b"x", 415, ".glb"),
        ("../../a.glb", glb(nodes__1__children=[0]), 422, "circle"),
        ("a.zip", scene(**quad("/etc/passwd")), 422, "/etc/passwd, which is not in its folder"),
    ):
        answer = send(quick, data, name)
        problem = answer.json()
        assert (answer.status_code, problem["status"]) == (status, status)
        assert answer.headers["content-type"] == "application/problem+json"
        assert words in problem["detail"]
        assert str(tmp_path) not in answer.text
    assert [*(tmp_path / "scenes").rglob("*")] == []
    with socket.create_connection((quick.base_url.host, quick.base_url.port or 80)) as raw:
        lines = ("POST /api/scenes HTTP/1.1", "Host: 127.0.0.1", f"Content-Length: {MAX_SCENE + 1}")
        raw.sendall("\r\n".join([*lines, "", ""]).encode())
        assert raw.recv(64).startswith(b"HTTP/1.1 413")


def test_the_oldest_scenes_go(
    quick: httpx.Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scenes, "KEPT", 2)
    names = [send(quick, glb(nodes__1__translation=[k, 0, 0]), f"{k}.glb").json()["name"]
             for k in range(3)]  # fmt: skip
    listed = [each["name"] for each in quick.get("/api/scenes").json() if each["sent"]]
    assert listed == names[1:]
    assert len(list((tmp_path / "scenes").iterdir())) == 4
    # Their own files may be gone as well, and no answer says where they were.
    for path in (tmp_path / "scenes").rglob("*.glb"):
        path.unlink()
    answer = quick.get(f"/api/scenes/{names[1]}")
    assert (answer.status_code, answer.json()["detail"]) == (
        404, f"the file of scene {names[1]!r} is gone")  # fmt: skip


async def no_end(started: asyncio.Event) -> AsyncIterator[bytes]:
    started.set()
    yield b"x"
    await asyncio.Event().wait()


async def leaving() -> AsyncIterator[bytes]:
    yield b"x"
    raise ClientDisconnect


def test_no_more_than_some_come_in_at_a_time(tmp_path: Path) -> None:
    async def tried() -> None:
        intake = Intake()

        async def one(chunks: AsyncIterator[bytes]) -> None:
            async with intake.received(chunks, tmp_path, "a.glb"):
                pass

        events = [asyncio.Event() for _ in range(MOST)]
        tasks = [asyncio.create_task(one(no_end(event))) for event in events]
        await asyncio.gather(*(event.wait() for event in events))
        with pytest.raises(Busy, match="coming in already"):
            await one(leaving())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        with pytest.raises(Cancelled):
            await one(leaving())

    asyncio.run(tried())
    assert list(tmp_path.iterdir()) == []


def test_rooms_of_a_killed_service_are_removed(tmp_path: Path) -> None:
    for name, age in (("new-old", OLD_SECONDS + 60), ("new-young", 0.0)):
        room = tmp_path / name
        room.mkdir()
        (room / "a.glb").write_bytes(b"x")
        now = room.stat().st_mtime
        os.utime(room, (now - age, now - age))
    sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["new-young"]
