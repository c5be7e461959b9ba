"""Errors as RFC 9457 problem documents.

Every error that leaves the service is `application/problem+json` with type, title, status, detail
and, where one is to blame, the dotted path of the field. Nothing else leaks: neither a path of this
machine nor a traceback.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any, TypeVar

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import TypeAdapter, ValidationError
from starlette.exceptions import HTTPException

from engine.errors import (
    REFUSED,
    BackendError,
    Cancelled,
    EditError,
    InputError,
    NotFound,
    RelightError,
    StoreError,
)
from server.wire import Problem

T = TypeVar("T")

log = logging.getLogger("relight.server")

MEDIA_TYPE = "application/problem+json"

TITLES = {
    400: "The request cannot be read",
    401: "Who asks?",
    403: "Not allowed",
    404: "Not found",
    405: "Method not allowed",
    406: "No such image format",
    409: "The work was stopped",
    413: "The request is too large",
    415: "No such kind of file",
    422: "The input cannot be used",
    429: "Too much at a time",
    500: "The service failed",
    503: "The service is busy",
}


class Busy(RelightError):
    """Too much is waiting already; come back later."""


class TooMany(RelightError):
    """The client has asked for more than is its share; come back later."""


class Forbidden(RelightError):
    """Not for this asker."""


class Unknown(RelightError):
    """Nobody knows the asker."""


class TooLarge(RelightError):
    """The body is over the limit."""


class UnknownKind(RelightError):
    """A file of a kind that is not taken."""


class NotAcceptable(RelightError):
    """None of the image formats that the client accepts can be made."""


STATUS: tuple[tuple[type[RelightError], int], ...] = (
    (InputError, 422),
    (NotFound, 404),
    (Unknown, 401),
    (Forbidden, 403),
    (Cancelled, 409),
    (BackendError, 503),
    (Busy, 503),
    (TooMany, 429),
    (TooLarge, 413),
    (NotAcceptable, 406),
    (UnknownKind, 415),
    (StoreError, 500),
)


def invalid(error: ValidationError | RequestValidationError, skip: Sequence[str] = ()) -> EditError:
    """The first problem of a pydantic error; leading parts of its path named in `skip` are left."""
    first = error.errors()[0]
    tag = first.get("ctx", {}).get("tag")
    path = [str(part) for part in first["loc"] if part != tag]
    while path and path[0] in skip:
        path.pop(0)
    return EditError(str(first["msg"]), field=".".join(path))


def in_json(kind: TypeAdapter[T], text: str, field: str) -> T:
    """What a text of a query holds; EditError, with the path of the field, where it is not that."""
    try:
        return kind.validate_json(text)
    except ValidationError as error:
        found = invalid(error)
        path = ".".join(part for part in (field, found.field) if part)
        raise EditError(found.message, field=path) from None


def describe(error: Exception) -> Problem:
    """The problem document of any error; an unexpected one is logged and not shown."""
    if isinstance(error, RequestValidationError):
        if error.errors()[0]["type"] == "json_invalid":
            return Problem(title=TITLES[400], status=400, detail="the body is not valid JSON")
        error = invalid(error, skip=("body", "query", "path"))
    if isinstance(error, HTTPException) and isinstance(error.__cause__, RelightError):
        error = error.__cause__  # raised while the framework was reading the body
    if isinstance(error, OSError) and error.errno in REFUSED:
        log.error("%s", error)
        error = StoreError(f"the service cannot write to its disk: {error.strerror}")
    if isinstance(error, HTTPException):
        title = TITLES.get(error.status_code, "Error")
        return Problem(title=title, status=error.status_code, detail=str(error.detail))
    for kind, status in STATUS:
        if isinstance(error, kind):
            if isinstance(error, InputError):
                return Problem(
                    title=TITLES[status],
                    status=status,
                    detail=error.message,
                    field=error.field,
                    file=PurePath(error.file).name,
                )
            detail = error.message if isinstance(error, StoreError) else str(error)
            return Problem(title=TITLES[status], status=status, detail=detail)
    log.error("unexpected error", exc_info=error)
    if isinstance(error, MemoryError):
        detail = "the memory of the service does not suffice for this; a smaller picture takes less"
        return Problem(title=TITLES[503], status=503, detail=detail)
    return Problem(
        title=TITLES[500],
        status=500,
        detail=f"an unexpected {type(error).__name__}; the log of the service has the details",
    )


def response(problem: Problem, retry_seconds: int = 1) -> Response:
    """The problem as an HTTP answer; when to come back, where that may help."""
    later = {"Retry-After": str(retry_seconds)}
    headers = {401: {"WWW-Authenticate": "Bearer"}, 429: later, 503: later}
    return Response(
        problem.model_dump_json(exclude_defaults=False),
        status_code=problem.status,
        media_type=MEDIA_TYPE,
        headers=headers.get(problem.status, {}),
    )


def install(app: FastAPI) -> None:
    """Answer every error of the app with a problem document."""

    async def answer(request: Request, error: Any) -> Response:
        problem = describe(error)
        request.app.state.service.metrics.problem(problem.status)
        kind = request.headers.get("content-type", "")
        if isinstance(error, RequestValidationError) and "json" not in kind:
            problem = problem.model_copy(
                update={"detail": "send the body as JSON, with Content-Type: application/json"}
            )
        return response(problem)

    for kind in (RelightError, RequestValidationError, HTTPException, Exception):
        app.add_exception_handler(kind, answer)
