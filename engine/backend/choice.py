"""Which backend draws: asked for by name, or by what this machine has."""

from __future__ import annotations

import os
from typing import Literal, get_args

from engine.backend.gl.context import Device, device
from engine.diagnosis import Diagnosis
from engine.errors import BackendError, InputError

Backend = Literal["auto", "cpu", "gl"]
VARIABLE = "RELIGHT_BACKEND"


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
        return None, (instead_of_gl(error),) if name == "gl" else ()
    return (None if name == "auto" and found.software else found), ()


def instead_of_gl(error: BackendError) -> Diagnosis:
    """Why the CPU draws."""
    return Diagnosis("gl_unavailable", f"The CPU draws, because GL does not: {error}")
