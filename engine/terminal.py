"""What the command line shows: results on standard output, bars and warnings on standard error."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator

import rich.progress
from rich.console import Console

from engine.diagnosis import Diagnosis
from engine.methods.base import Progress

out, err = Console(soft_wrap=True), Console(stderr=True, soft_wrap=True)


def complain(style: str, label: str, message: str) -> None:
    """`label: message` on standard error, in one line whatever the message holds."""
    text = " ".join(message.split()).replace("[", r"\[")
    err.print(f"[{style}]{label}:[/] {text}", highlight=False)


def warn(diagnoses: Iterable[Diagnosis]) -> None:
    """Say what a scene or a frame has to say about itself."""
    for diagnosis in diagnoses:
        complain("yellow", "warning", diagnosis.message)


@contextlib.contextmanager
def progress_bars() -> Iterator[Progress]:
    """A bar per phase, on standard error."""
    columns = (
        rich.progress.TextColumn("{task.description:>24}"),
        rich.progress.BarColumn(),
        rich.progress.TaskProgressColumn(),
        rich.progress.TimeElapsedColumn(),
        rich.progress.TimeRemainingColumn(),
    )
    with rich.progress.Progress(*columns, console=err) as bars:
        tasks: dict[str, rich.progress.TaskID] = {}

        def progress(phase: str, done: float, total: float) -> None:
            if phase not in tasks:
                tasks[phase] = bars.add_task(phase)
            # A phase that comes again, for another picture or setting, starts its bar again.
            bars.update(tasks[phase], completed=done, total=total)

        yield progress
