"""How much one client may ask for: 429 with Retry-After beyond that, 503 where all is full.

A client is an address; of IPv6 the network that a household is given. Behind a proxy it is the
address that the proxy passes on in X-Forwarded-For: see `server.main.configure`. A live socket
needs no rate, since no more than two of its frames are under way: sockets are counted.
"""

from __future__ import annotations

import contextlib
import ipaddress
import math
import re
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from starlette.types import ASGIApp, Receive, Scope, Send

from engine.errors import RelightError
from server.problems import Busy, TooMany, describe, response

SOCKET_WAIT_SECONDS = 5
MOST_KEPT = 4096  # clients that are remembered before those who have been quiet are forgotten


@dataclass(frozen=True)
class Rate:
    """So many at once, and so many a second from then on."""

    burst: int
    per_second: float


@dataclass(frozen=True)
class Rates:
    """What one client may have.

    requests  of any kind: a dragging hand asks for a frame at every refresh of its screen
    uploads   files sent
    jobs      precomputes, charts and references begun
    at_once   frames under way that were asked for by POST
    sessions  live sockets open; `all_sessions` those of all clients
    """

    requests: Rate = Rate(240, 120.0)
    uploads: Rate = Rate(60, 1.0)
    jobs: Rate = Rate(30, 0.5)
    at_once: int = 8
    sessions: int = 24
    all_sessions: int = 48


_KINDS = re.compile(
    r"/api/(?P<uploads>maps|measured|scenes)/?$"
    r"|/api/scenes/[^/]+/(?:(?P<jobs>precompute|chart|reference)|(?P<frames>frame))$"
)


class Ledger:
    """Who has asked for how much of late, by client and kind; used from one thread."""

    def __init__(self) -> None:
        self._due: dict[tuple[str, str], float] = {}
        self._open: Counter[tuple[str, str]] = Counter()

    def wait(self, client: str, kind: str, rate: Rate, now: float) -> float:
        """Seconds until the client may ask again; 0 where it may now, which is counted."""
        if len(self._due) > MOST_KEPT:
            self._due = {key: due for key, due in self._due.items() if due > now}
        # Each request takes 1 / per_second; `due` is when all so far would be over at that pace.
        due = max(self._due.get((client, kind), 0.0), now) + 1 / rate.per_second
        wait = due - now - rate.burst / rate.per_second
        if wait > 1e-9:
            return wait
        self._due[client, kind] = due
        return 0.0

    def count(self, client: str, kind: str) -> int:
        """How many are under way."""
        return self._open[client, kind]

    @contextlib.contextmanager
    def under_way(self, client: str, kind: str) -> Iterator[None]:
        """One more, until the end of the block."""
        self._open[client, kind] += 1
        try:
            yield
        finally:
            self._open[client, kind] -= 1
            if not self._open[client, kind]:
                del self._open[client, kind]  # or all clients that ever came would be kept


def client_of(scope: Scope) -> str:
    """The client's address; that of IPv6 without the half that a machine chooses by itself."""
    host: str = (scope.get("client") or ("", 0))[0]
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    if isinstance(address, ipaddress.IPv4Address):
        return host
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ipaddress.ip_network((int(address), 64), strict=False))


class Limited:
    """Refuse what is over the rates, live sockets before they are opened."""

    def __init__(self, app: ASGIApp, rates: Rates) -> None:
        self.app, self.rates = app, rates
        self._ledger = Ledger()
        self._sessions = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See the ASGI specification."""
        if scope["type"] == "websocket":
            await self._socket(client_of(scope), scope, receive, send)
        elif scope["type"] == "http" and scope["path"].startswith("/api/"):
            await self._request(client_of(scope), scope, receive, send)
        else:
            await self.app(scope, receive, send)

    async def _request(self, client: str, scope: Scope, receive: Receive, send: Send) -> None:
        rates, now = self.rates, time.monotonic()
        found = _KINDS.match(scope["path"]) if scope["method"] == "POST" else None
        kind = found.lastgroup if found else None
        wanted = {"requests": rates.requests}
        if kind in ("uploads", "jobs"):
            wanted[kind] = getattr(rates, kind)
        for name, rate in wanted.items():
            wait = self._ledger.wait(client, name, rate, now)
            if wait > 0:
                said = f"{rate.burst} {name}, and {rate.per_second:g} more a second"
                await _refuse(TooMany(f"your address may have {said}"), wait, scope, receive, send)
                return
        if kind != "frames":
            await self.app(scope, receive, send)
            return
        if self._ledger.count(client, kind) >= rates.at_once:
            error = TooMany(f"your address has {rates.at_once} frames under way")
            await _refuse(error, 1, scope, receive, send)
            return
        with self._ledger.under_way(client, kind):
            await self.app(scope, receive, send)

    async def _socket(self, client: str, scope: Scope, receive: Receive, send: Send) -> None:
        rates = self.rates
        if self._ledger.count(client, "live") >= rates.sessions:
            error: RelightError = TooMany(f"your address has {rates.sessions} live sockets open")
        elif self._sessions >= rates.all_sessions:
            error = Busy(f"{self._sessions} live sockets are open, and there is room for no more")
        else:
            self._sessions += 1
            try:
                with self._ledger.under_way(client, "live"):
                    await self.app(scope, receive, send)
            finally:
                self._sessions -= 1
            return
        await _refuse(error, SOCKET_WAIT_SECONDS, scope, receive, send)


async def _refuse(
    error: RelightError, wait: float, scope: Scope, receive: Receive, send: Send
) -> None:
    problem = describe(error)
    scope["app"].state.service.metrics.problem(problem.status)
    await response(problem, math.ceil(wait))(scope, receive, send)
