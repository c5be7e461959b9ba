"""When the reference may stop."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.errors import InputError

FIRST_PASS = 16  # samples per pixel before the error is believed at all
LEAST_SAMPLES = 64  # before a requested error may end the work


@dataclass(frozen=True)
class Limits:
    """The first that is reached ends the work; None is no limit.

    samples      per pixel
    error        estimated relative L2 error of the picture
    max_seconds  wall-clock, kept between passes over the picture; at least one pass is made
    """

    samples: int | None
    error: float | None
    max_seconds: float | None

    def check(self) -> None:
        """Raise InputError for a limit that cannot be reached."""
        if self.samples is not None and self.samples < 1:
            raise InputError(f"{self.samples} is below 1", field="samples")
        if self.error is not None and not 0 < self.error < math.inf:
            raise InputError(f"{self.error} is not a positive number", field="error")
        if self.max_seconds is not None and not self.max_seconds > 0:
            raise InputError(f"{self.max_seconds} is not above 0", field="max_seconds")

    def next_pass(self, done: int, error: float, spent: float) -> int:
        """Samples per pixel to take next, 0 to stop; `error` after `done` samples, in seconds."""
        more = FIRST_PASS if done == 0 else done
        if self.error is not None and done >= FIRST_PASS:
            if error <= self.error and done >= LEAST_SAMPLES:
                return 0
            # Error falls as one over the root of the samples; a guess beyond fourfold is a guess.
            growth = min(4.0, (error / self.error) ** 2)
            more = max(math.ceil(done * growth), LEAST_SAMPLES, done + done // 8 + 1) - done
        if self.max_seconds is not None:
            if done == 0:
                more = 1
            elif spent >= self.max_seconds:
                return 0
            else:
                more = min(more, max(1, int(done * (self.max_seconds - spent) / spent)))
        if self.samples is not None:
            more = min(more, self.samples - done)
        return more

    def expected(self, done: int, error: float, spent: float) -> float:
        """Samples per pixel after which the work will probably end."""
        ends = [math.inf]
        if self.samples is not None:
            ends.append(self.samples)
        if self.error is not None and done >= FIRST_PASS and math.isfinite(error):
            ends.append(max(LEAST_SAMPLES, done * (error / self.error) ** 2))
        if self.max_seconds is not None and done > 0:
            ends.append(done * self.max_seconds / max(spent, 1e-9))
        return min(ends)
