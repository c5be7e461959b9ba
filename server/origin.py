"""Only this machine's own page may drive the service.

Any web page that a browser has open can send requests to a loopback address. Two headers, which
pages cannot forge, tell them apart: `Host` is the name by which the browser found the service (a
foreign name that resolves to this machine is refused), and `Origin` is the page that asks (one that
the service did not serve itself is refused). Programs send no `Origin` and are let through.
"""

from __future__ import annotations

from collections.abc import Iterable
from urllib.parse import urlsplit

from starlette.types import ASGIApp, Receive, Scope, Send

from server.problems import Forbidden, describe, response

LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
EVERYWHERE = frozenset({"0.0.0.0", "::"})


def names_of(host: str) -> frozenset[str] | None:
    """The names by which a service that listens at `host` may be called; None for any."""
    return None if host in EVERYWHERE else LOOPBACK | {host.lower()}


class OwnPageOnly:
    """Refuse requests and sockets that come by another name or from another page."""

    def __init__(self, app: ASGIApp, names: Iterable[str] | None = LOOPBACK) -> None:
        self.app = app
        self.names = None if names is None else frozenset(names)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See the ASGI specification."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        wrong = self._wrong(headers.get(b"host", ""), headers.get(b"origin"))
        if wrong is None:
            await self.app(scope, receive, send)
        elif scope["type"] == "http":
            await response(describe(Forbidden(wrong)))(scope, receive, send)
        else:
            await send({"type": "websocket.close", "code": 1008, "reason": wrong})

    def _wrong(self, host: str, origin: str | None) -> str | None:
        """What is wrong with the two headers."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            name = ""
        if self.names is not None and name not in self.names:
            return f"this service is not called {name!r}"
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return "only the service's own page may ask"
        return None
