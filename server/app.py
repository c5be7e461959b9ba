"""The app: routes, page, limits, errors."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Iterable, Mapping, Sequence
from typing import Any

from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from engine.errors import RelightError
from engine.resources import resource
from server import accuracy_routes, examples, measured_routes, problems, upload_routes
from server.origin import LOOPBACK, OwnPageOnly
from server.precompute import run_in_process
from server.products import Precompute
from server.rates import Limited, Rates
from server.routes import router
from server.service import Service
from server.stages import MEMORY, stages
from server.token import HoldersOnly

MAX_BODY = 1 << 20
MAX_SCENE, MAX_MAP, MAX_MEASURED = 1 << 27, 1 << 27, 1 << 26
MAX_FILE = {"/api/scenes": MAX_SCENE, "/api/maps": MAX_MAP, "/api/measured": MAX_MEASURED}

# The page needs nothing but itself: images come as blobs over the live socket.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


def create_app(
    scenes: Sequence[str] = (),
    *,
    precompute: Precompute = run_in_process,
    precompute_at_start: bool = True,
    settings: Mapping[str, Any] | None = None,
    names: Iterable[str] | None = LOOPBACK,
    token: str | None = None,
    memory: float = MEMORY,
    rates: Rates | None = Rates(),  # noqa: B008 - frozen
) -> FastAPI:
    """The service for these scenes (built-in names or files) and all built-in ones.

    precompute           fills the store with the product of a task
    precompute_at_start  begin with the default scene before anybody asks
    settings             of the method, in place of its defaults
    names                that the service may be called by, None for any
    token                that everybody has to send, None for nobody
    memory               bytes that products may take; the one used last may take more
    rates                what one client may ask for, None for anything
    Raises NotFound where a name is neither a built-in scene nor a file.
    """
    service = Service(stages(scenes, memory), precompute, settings)

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        start = asyncio.create_task(asyncio.to_thread(_start_default, service))
        if not precompute_at_start:
            start.cancel()
        yield
        await asyncio.gather(start, return_exceptions=True)
        await asyncio.to_thread(service.close)

    # The pages that show the API would come from another host; /openapi.json is enough.
    app = FastAPI(title="Relight", lifespan=lifespan, docs_url=None, redoc_url=None)
    app.state.service = service
    problems.install(app)
    app.include_router(router)
    app.include_router(measured_routes.router)
    app.include_router(accuracy_routes.router)
    app.include_router(upload_routes.router)
    examples.install(app)
    app.mount("/", StaticFiles(directory=resource("web"), html=True))
    app.add_middleware(Limits)
    if token is not None:
        app.add_middleware(HoldersOnly, token=token)
    if rates is not None:
        app.add_middleware(Limited, rates=rates)
    app.add_middleware(OwnPageOnly, names=names)
    return app


def _start_default(service: Service) -> None:
    """Begin the default scene's precompute; a scene that cannot be opened says so when asked."""
    stage = service.stages.default
    with contextlib.suppress(RelightError):
        service.jobs.start(service.task(stage, stage.scene().camera), "start")
        service.jobs.forget("start")


class Limits:
    """Refuse bodies over MAX_BODY bytes, or MAX_FILE; send the page's security policy along."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See the ASGI specification."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        most = MAX_FILE.get(scope["path"], MAX_BODY)
        error = problems.TooLarge(f"the body is over {most} bytes")
        length = dict(scope["headers"]).get(b"content-length", b"0")
        if not length.isdigit() or int(length) > most:
            await problems.response(problems.describe(error))(scope, receive, send)
            return
        received = 0

        async def counted() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > most:
                raise error
            return message

        async def with_policy(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = message.setdefault("headers", [])
                headers += [
                    (b"content-security-policy", POLICY.encode()),
                    (b"x-content-type-options", b"nosniff"),
                    (b"referrer-policy", b"no-referrer"),
                ]
            await send(message)

        await self.app(scope, counted, with_policy)
