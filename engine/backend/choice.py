"""Which backend draws: asked for by name, or by what this machine has."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Literal, TypeVar, get_args

from engine.backend.gl.context import Device, device, gl_errors
from engine.diagnosis import Diagnosis
from engine.errors import BackendError, InputError

Backend = Literal["auto", "cpu", "gl"]
VARIABLE = "RELIGHT_BACKEND"
T = TypeVar("T")


def wanted(asked: str | None = None) -> Backend:
    """What was asked for, else what the environment variable says, else `auto`.

    Raises InputError for a name that is no backend.
    """
    name = asked or os.environ.get(VARIABLE) or "auto"
    if name not in get_args(Backend):
        known = ", ".join(get_args(Backend))
        field = "backend" if asked else VARIABLE
        raise InputError(f"{name!r} is no backend; there are {known}", field=field)
    return name  # type: ignore[return-value]


def chosen_device(asked: Backend | None = None) -> tuple[Device | None, tuple[Diagnosis, ...]]:
    """The GL device to draw with, None for the CPU; and what the user should know about it.

    `auto` takes GL where the renderer is hardware. GL that was asked for and is not there is
    replaced by the CPU with a notice.
    """
    name = wanted(asked)
    if name == "cpu":
        return None, ()
    try:
        found = device()
    except BackendError as error:
        return None, (_instead_of_gl(error),) if name == "gl" else ()
    return (None if name == "auto" and found.software else found), ()


class GlFirst:
    """Draws with GL where that is chosen; from its first failure on the CPU does.

    failed  why, then
    """

    def __init__(self) -> None:
        self.failed: Diagnosis | None = None

    def draw(
        self, asked: Backend | None, on_gl: Callable[[Device], T], on_cpu: Callable[[], T]
    ) -> tuple[T, tuple[Diagnosis, ...]]:
        """(what one of both made, what the user should know); GL may be lost in on_gl."""
        device, notices = chosen_device(asked)
        if device is None:
            return on_cpu(), notices
        if self.failed is None:
            try:
                with gl_errors():
                    return on_gl(device), notices
            except BackendError as error:
                self.failed = _instead_of_gl(error)
        return on_cpu(), (self.failed,)


def _instead_of_gl(error: BackendError) -> Diagnosis:
    return Diagnosis("gl_unavailable", f"The CPU draws, because GL does not: {error}")
