"""How long frames took, and how many there were, in the text format that Prometheus reads."""

from __future__ import annotations

import threading
from collections import Counter, deque
from collections.abc import Iterator, Mapping

import numpy as np

from server.wire import FrameHeader

WINDOW = 1024  # frames that quantiles are taken of
QUANTILES = 0.5, 0.95
MEDIA_TYPE = "text/plain; version=0.0.4; charset=utf-8"
# Of a frame's timings, those that every method has, and `answer`: from the edit's arrival until its
# frame was handed to the socket.
PARTS = "buffer", "relight", "encode", "answer"


class Metrics:
    """Durations of the last frames and counts of all of them; for any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: dict[str, deque[float]] = {part: deque(maxlen=WINDOW) for part in PARTS}
        self._sum: dict[str, float] = dict.fromkeys(PARTS, 0.0)
        self._frames: Counter[tuple[str, str]] = Counter()
        self._problems: Counter[int] = Counter()

    def frame(self, header: FrameHeader, way: str, answer: float) -> None:
        """A frame was sent by `live` or `http`, so many seconds after it was asked for."""
        seconds = {name: header.timings.get(name, 0.0) / 1000 for name in PARTS}
        seconds["answer"] = answer
        with self._lock:
            self._frames[header.method, way] += 1
            for name, value in seconds.items():
                self._last[name].append(value)
                self._sum[name] += value

    def problem(self, status: int) -> None:
        """Something was refused, or failed."""
        with self._lock:
            self._problems[status] += 1

    def text(self, now: Mapping[str, float]) -> str:
        """All of it, and some values as they are now, by name."""
        with self._lock:
            last = {name: list(values) for name, values in self._last.items()}
            sums, frames, problems = dict(self._sum), dict(self._frames), dict(self._problems)
        count = sum(frames.values())

        def lines() -> Iterator[str]:
            yield "# HELP relight_frame_seconds Parts of frames; quantiles of the last ones."
            yield "# TYPE relight_frame_seconds summary"
            for name, values in last.items():
                for q in QUANTILES if values else ():
                    found = float(np.quantile(values, q))
                    yield f'relight_frame_seconds{{part="{name}",quantile="{q}"}} {found:.6g}'
                yield f'relight_frame_seconds_sum{{part="{name}"}} {sums[name]:.6g}'
                yield f'relight_frame_seconds_count{{part="{name}"}} {count}'
            yield "# TYPE relight_frames_total counter"
            for (method, way), number in sorted(frames.items()):
                yield f'relight_frames_total{{method="{method}",way="{way}"}} {number}'
            yield "# TYPE relight_problems_total counter"
            for status, number in sorted(problems.items()):
                yield f'relight_problems_total{{status="{status}"}} {number}'
            for name, value in now.items():
                yield f"# TYPE relight_{name} gauge"
                yield f"relight_{name} {value:g}"

        return "\n".join(lines()) + "\n"
