"""Another page, or a foreign name for this machine, cannot drive the service."""

from __future__ import annotations

from pathlib import Path

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from server.origin import LOOPBACK, OwnPageOnly, names_of

LIVE = "/api/scenes/tiny-box/live"


def port(client: httpx.Client) -> int:
    assert client.base_url.port is not None
    return client.base_url.port


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1.evil.example"},
        {"Host": "[::"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
    ],
)
def test_strangers_are_refused(client: httpx.Client, headers: dict[str, str]) -> None:
    answer = client.post("/api/scenes/tiny-box/frame", json={}, headers=headers)
    assert answer.status_code == 403
    assert answer.headers["content-type"] == "application/problem+json"
    assert client.get("/", headers=headers).status_code == 403


def test_the_own_page_and_programs_are_let_in(client: httpx.Client) -> None:
    for name in ("127.0.0.1", "localhost"):
        own = f"{name}:{port(client)}"
        headers = {"Host": own, "Origin": f"http://{own}"}
        assert client.get("/api/scenes", headers=headers).status_code == 200
    assert client.get("/api/scenes").status_code == 200


def test_the_live_socket_refuses_other_pages(client: httpx.Client) -> None:
    address = f"ws://127.0.0.1:{port(client)}{LIVE}"
    with connect(address, origin=f"http://127.0.0.1:{port(client)}", proxy=None):  # type: ignore[arg-type]
        pass
    for origin in ("http://evil.example", "https://127.0.0.1", "null"):
        with pytest.raises(InvalidStatus) as refused:
            connect(address, origin=origin, proxy=None)  # type: ignore[arg-type]
        assert refused.value.response.status_code == 403


def test_names_follow_the_address() -> None:
    assert names_of("127.0.0.1") == LOOPBACK
    assert names_of("Desk.local") == LOOPBACK | {"desk.local"}
    assert names_of("0.0.0.0") is None
    anywhere = OwnPageOnly(lambda *_: None, None)  # type: ignore[arg-type, return-value]
    assert anywhere._wrong("desk:8000", "http://desk:8000") is None
    assert anywhere._wrong("desk:8000", "http://evil.example") is not None
    here = OwnPageOnly(lambda *_: None)  # type: ignore[arg-type, return-value]
    assert here._wrong("[::1]:8000", "http://[::1]:8000") is None


@pytest.mark.parametrize("name", ["/etc/hostname", "../secret.exr", "sky.exr", "upload:0"])
def test_edits_name_no_files_elsewhere(client: httpx.Client, tmp_path: Path, name: str) -> None:
    edits = {"environment": {"map": name}}
    answer = client.post("/api/scenes/tiny-box/frame", json=edits)
    assert answer.status_code == 422
    assert answer.json()["field"] == "environment.map"
    assert "can be asked for here" in answer.json()["detail"]
    for fine in ("studio", [1, 1, 1], {"sun_direction": [0, -1, 0]}):
        answer = client.post("/api/scenes/tiny-box/frame", json={"environment": {"map": fine}})
        assert answer.status_code == 200
