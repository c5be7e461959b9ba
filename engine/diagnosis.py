"""What a scene, a method or the planner has to say about its own picture, in plain words."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Diagnosis:
    """One thing the user should know.

    code      a stable name such as `albedo_above_one`
    message   a sentence: what is wrong, how large it is, which setting or method would mend it
    size      the measured or estimated relative error or excess, 0 where it has no number
    """

    code: str
    message: str
    size: float = 0.0
