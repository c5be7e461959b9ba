"""Where others can reach the service, nobody gets anything without its token."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from engine.cli import main
from engine.errors import BackendError, InputError
from engine.methods.base import Progress
from server.app import create_app
from server.precompute import Task
from server.token import COOKIE, checked

TOKEN = "a-token-that-nobody-guesses"
LIVE = "/api/scenes/tiny-box/live"


def nothing(task: Task, progress: Progress) -> None:
    raise BackendError("no precompute in this test")


@pytest.fixture(scope="module")
def guarded(
    serving: Callable[[FastAPI], AbstractContextManager[str]], tiny_scene: Path
) -> Iterator[str]:
    """The address of a service with a token."""
    app = create_app([str(tiny_scene)], precompute=nothing, precompute_at_start=False, token=TOKEN)
    with serving(app) as address:
        yield address


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Authorization": "Bearer wrong"},
        {"Authorization": f"Basic {TOKEN}"},
        {"Authorization": f"Bearer {TOKEN}x"},
        {"Cookie": f"{COOKIE}=wrong"},
        {"Cookie": f"other={TOKEN}"},
        {"Cookie": "=;;\x7f"},
    ],
)
def test_without_the_token_there_is_nothing(guarded: str, headers: dict[str, str]) -> None:
    for path in ("/", "/main.js", "/api/scenes", "/openapi.json", "/metrics", "/?token=wrong"):
        answer = httpx.get(guarded + path, headers=headers)
        assert answer.status_code == 401
        assert answer.headers["www-authenticate"] == "Bearer"
        assert TOKEN not in answer.text
    assert httpx.post(guarded + "/api/scenes/tiny-box/frame", json={}).status_code == 401


def test_whether_it_lives_is_no_secret(guarded: str) -> None:
    assert httpx.get(guarded + "/healthz").json() == {"status": "ok"}


def test_programs_send_it(guarded: str) -> None:
    headers = {"Authorization": f"Bearer {TOKEN}"}
    assert httpx.get(guarded + "/api/scenes", headers=headers).status_code == 200
    assert httpx.get(guarded + "/", headers=headers).status_code == 200


def test_a_browser_opens_it_once_and_remembers(guarded: str) -> None:
    with httpx.Client(base_url=guarded, follow_redirects=False) as browser:
        opened = browser.get("/", params={"token": TOKEN, "scene": "tiny box"})
        assert opened.status_code == 303
        assert opened.headers["location"] == "/?scene=tiny+box"
        kept = opened.headers["set-cookie"].lower()
        assert "httponly" in kept
        assert "samesite=strict" in kept
        page = browser.get(opened.headers["location"])
        assert page.status_code == 200
        assert TOKEN not in page.text


def test_no_address_leads_elsewhere(guarded: str) -> None:
    for path in ("//evil.example/", "///evil.example", "/\\evil.example"):
        answer = httpx.get(f"{guarded}{path}?token={TOKEN}")
        assert not answer.headers.get("location", "/").startswith(("//", "/\\", "http"))


def test_the_live_socket_asks_for_it(guarded: str) -> None:
    address = guarded.replace("http://", "ws://") + LIVE
    with pytest.raises(InvalidStatus) as refused:
        connect(address, proxy=None)
    assert refused.value.response.status_code == 403
    for headers in ({"Authorization": f"Bearer {TOKEN}"}, {"Cookie": f"{COOKIE}={TOKEN}"}):
        with connect(address, additional_headers=headers, proxy=None):
            pass


def test_elsewhere_than_on_loopback_there_has_to_be_one() -> None:
    assert checked("127.0.0.1", None) is None
    assert checked("localhost", TOKEN) == TOKEN
    assert checked("0.0.0.0", TOKEN) == TOKEN
    with pytest.raises(InputError, match=r"others can reach 0\.0\.0\.0, so a token is required"):
        checked("0.0.0.0", None)
    for bad in ("short", "with spaces in the middle", "nøt-ascii-nøt-ascii"):
        with pytest.raises(InputError, match="16 printable ASCII characters"):
            checked("127.0.0.1", bad)


def test_the_command_says_so_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("RELIGHT_TOKEN", raising=False)
    monkeypatch.setattr("sys.argv", ["relight", "serve", "--host", "0.0.0.0"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert "a token is required" in " ".join(capsys.readouterr().err.split())
