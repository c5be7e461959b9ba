"""Light that stays when lights move: what surfaces emit, and the environment.

It falls evenly, where lights are small and close: culling takes little from it, and what would give
back to a spot what that loses made a room 6 % too bright under a glowing panel, and more under the
sky. So its bounces are taken by themselves, with gains of their own, and kept.
"""

from __future__ import annotations

from engine.light.environment import Environment
from engine.methods.direct_to_indirect.bounces import Bounced, Bounces
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.environment_light import EnvironmentLight
from engine.numerics import haar


class StandingLight:
    """All bounces of emission and environment on the gather cloud."""

    def __init__(self, bounces: Bounces, cloud: GatherCloud, environment: EnvironmentLight) -> None:
        """How the environment's light fades is told by a white one, the same for all of them."""
        self._bounces, self._environment = bounces, environment
        emission = haar.forward(cloud.emission)
        self._emitted = bounces(emission, bounces.fading([cloud.emission]))
        self._fading = bounces.fading([environment.white])
        self._last: tuple[object, Bounced] = (None, self._emitted)

    def __call__(self, environment: Environment | None) -> Bounced:
        """Under an environment that `EnvironmentLight` uses, or none."""
        if environment is None:
            return self._emitted
        gather = self._environment.gather
        if self._last[0] is not gather:
            light = self._bounces(haar.forward(gather), self._fading)
            self._last = (gather, both(light, self._emitted))
        return self._last[1]


def both(a: Bounced, b: Bounced) -> Bounced:
    """The sum of two."""
    return Bounced(
        a.total + b.total,
        a.unsure + b.unsure,
        a.power + b.power,
        a.first + b.first,
        a.whole + b.whole,
    )
