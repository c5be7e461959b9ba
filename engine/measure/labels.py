"""Words beside the points of a chart, where none stand yet."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

FARTHER = [sign * (14 + 12 * k) for k in range(8) for sign in (-1, 1)]  # points, for labels


def place_labels(
    figure: Figure, axes: Axes, labels: Sequence[tuple[float, float, str, str]]
) -> None:
    """Write every label beside its point, at the first place where none stands yet."""
    figure.draw_without_rendering()
    points = [axes.transData.transform((x, y)) for x, y, _, _ in labels]
    taken = [(px - 5, py - 5, px + 5, py + 5) for px, py in points]
    for (x, y, text, colour), (px, py) in zip(labels, points, strict=True):
        width, height = 5.0 * len(text) * figure.dpi / 72, 11.0 * figure.dpi / 72
        left_of = -7 - 4.6 * len(text)
        places = [(7, -3), (7, 6), (7, -13), (-3, 9), (-3, -16), (left_of, 5)]
        # Where lines crowd, farther off.
        places += [(x, y) for y in FARTHER for x in (left_of, 7)]
        for dx, dy in places:
            left, low = px + dx * figure.dpi / 72, py + dy * figure.dpi / 72
            box = (left, low, left + width, low + height)
            if not any(_overlap(box, other) for other in taken):
                break
        taken.append(box)
        axes.annotate(
            text,
            (x, y),
            xytext=(dx, dy),
            textcoords="offset points",
            fontsize=8,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6},
        )


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
