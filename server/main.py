"""Start the service: on loopback unless told otherwise, one process."""

from __future__ import annotations

import contextlib
import socket
import webbrowser
from collections.abc import Iterable, Sequence
from urllib.parse import quote

import uvicorn
from fastapi import FastAPI

from engine.errors import RelightError
from server.app import MAX_BODY, create_app
from server.origin import names_of
from server.stages import MEMORY
from server.token import checked

TRIES = 20
UNREAD_SECONDS = 20  # that a client may leave unread what was sent to it, or be away
SEND_BUFFER = 1 << 18  # bytes of a connection that the system keeps: a frame or two


def serve(
    scenes: Sequence[str] = (),
    host: str = "127.0.0.1",
    port: int = 8000,
    *,
    open_browser: bool = False,
    names: Iterable[str] = (),
    token: str | None = None,
    memory: float = MEMORY,
) -> None:
    """Serve the scenes until interrupted; prints the address once it can be opened.

    names  by which a proxy calls the service, beside the host's own
    token  that everybody has to send; where others can reach the host there has to be one
    memory bytes that products may take, see `create_app`

    Where the port is taken the next free one is used; port 0 takes any. Raises RelightError where
    none can be had, InputError for a lacking token, NotFound for a scene that is neither built in
    nor a file.
    """
    token, known = checked(host, token), names_of(host)
    if known is not None:
        known |= {name.lower() for name in names}
    app = create_app(scenes, names=known, token=token, memory=memory)
    listener = listen(host, port)
    address = f"http://{host}:{listener.getsockname()[1]}/"
    address += "" if token is None else f"?token={quote(token)}"
    print(f"Relight is at {address}  (Ctrl-C ends it)", flush=True)
    if open_browser:
        webbrowser.open(address)
    with contextlib.suppress(KeyboardInterrupt):  # uvicorn has closed everything by then
        uvicorn.Server(configure(app)).run(sockets=[listener])


def configure(app: FastAPI) -> uvicorn.Config:
    """How the app is served: frames are compressed already, and an edit is small.

    The address of a client behind a proxy is the one that the proxy passes on, where uvicorn trusts
    the proxy: on this machine, or in FORWARDED_ALLOW_IPS.
    """
    return uvicorn.Config(
        app,
        log_level="warning",
        ws="websockets-sansio",
        ws_max_size=MAX_BODY,
        ws_per_message_deflate=False,
        ws_ping_interval=UNREAD_SECONDS / 2,
        ws_ping_timeout=0.4 * UNREAD_SECONDS,
        timeout_graceful_shutdown=2,
    )


def listen(host: str, port: int) -> socket.socket:
    """A listening socket at the port, or at the first free one after it."""
    error: OSError | None = None
    for candidate in range(port, port + TRIES) if port else [0]:
        listener = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        for_connections(listener)
        try:
            listener.bind((host, candidate))
            listener.listen(128)
        except OSError as problem:
            listener.close()
            error = problem
            continue
        return listener
    raise RelightError(f"cannot listen on {host} from port {port} on: {error}")


def for_connections(listener: socket.socket) -> None:
    """Options that connections take over from the socket that listens for them."""
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
    # The end of a frame is sent at once, not when its beginning has arrived.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    # Who does not read is cut off, with what waits for it; elsewhere than on Linux the memory of a
    # frame or two is lost to it until it goes.
    if hasattr(socket, "TCP_USER_TIMEOUT"):
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 1000 * UNREAD_SECONDS)
