"""Who may ask a service that others can reach: those who hold its token.

Programs send it as `Authorization: Bearer TOKEN`. A person opens `/?token=TOKEN` once; the service
answers with a cookie that no script can read and no other site's page sends along.
"""

from __future__ import annotations

import hmac
from collections.abc import Iterator
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlencode

from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from engine.errors import InputError
from server.origin import LOOPBACK
from server.problems import Unknown, describe, response

COOKIE = "relight_token"
LEAST = 16  # characters of a token
OPEN = {"/healthz"}
MONTH_SECONDS = 30 * 24 * 3600


def checked(host: str, token: str | None) -> str | None:
    """The token that a service at `host` asks for, None for none.

    Raises InputError where others can reach it and there is none, or a short one.
    """
    if token is None:
        if host.lower() not in LOOPBACK:
            raise InputError(
                f"others can reach {host}, so a token is required: say --token or RELIGHT_TOKEN, "
                f"{LEAST} characters or more that nobody can guess, such as those of "
                "`python3 -c 'import secrets; print(secrets.token_urlsafe())'`",
                field="token",
            )
        return None
    if len(token) < LEAST or not token.isascii() or not token.isprintable() or " " in token:
        raise InputError(
            f"a token has {LEAST} printable ASCII characters or more, and no spaces", field="token"
        )
    return token


class HoldersOnly:
    """Refuse requests and sockets without the token."""

    def __init__(self, app: ASGIApp, token: str) -> None:
        self.app, self._token = app, token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See the ASGI specification."""
        if scope["type"] not in ("http", "websocket") or scope["path"] in OPEN:
            await self.app(scope, receive, send)
            return
        query = parse_qsl(scope["query_string"].decode("latin-1"))
        if scope.get("method") == "GET" and self._in_query(query):
            await self._remembered(scope, query)(scope, receive, send)
        elif any(self._is_token(given) for given in _given(scope)):
            await self.app(scope, receive, send)
        elif scope["type"] == "http":
            await response(describe(Unknown("this service asks for its token")))(
                scope, receive, send
            )
        else:
            await send({"type": "websocket.close", "code": 1008, "reason": "no token"})

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode("latin-1", "replace"), self._token)

    def _in_query(self, query: list[tuple[str, str]]) -> bool:
        return any(name == "token" and self._is_token(value) for name, value in query)

    def _remembered(self, scope: Scope, query: list[tuple[str, str]]) -> RedirectResponse:
        """The same address without the token, which the browser keeps from now on."""
        rest = urlencode([(name, value) for name, value in query if name != "token"])
        # A path of two slashes would be another host's.
        path = "/" + scope["path"].lstrip("/")
        answer = RedirectResponse(f"{path}?{rest}" if rest else path, 303)
        answer.set_cookie(
            COOKIE, self._token.decode(), max_age=MONTH_SECONDS, httponly=True, samesite="strict",
            secure=scope["scheme"] == "https",
        )  # fmt: skip
        return answer


def _given(scope: Scope) -> Iterator[str]:
    """What a request offers as the token."""
    for name, value in scope["headers"]:
        text = value.decode("latin-1")
        if name == b"authorization" and text[:7].lower() == "bearer ":
            yield text[7:].strip()
        if name == b"cookie":
            try:
                found = SimpleCookie(text).get(COOKIE)
            except CookieError:
                continue
            if found is not None:
                yield found.value
