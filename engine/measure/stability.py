"""The stability table: every regime measured, and how often warnings are right."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from engine.measure import contact_sheet
from engine.measure.chart import machine_caption
from engine.measure.contact_sheet import Row, Sheet, difference, picture
from engine.measure.document import finite, provenance, table, write_json
from engine.measure.machine import Machine, this_machine
from engine.measure.metrics import auto_exposure
from engine.measure.regimes import BUDGET, GROUPS, REGIMES, Outcome, run
from engine.measure.settings import settings_from
from engine.methods import METHODS
from engine.methods.base import Progress
from engine.store import Store

SIDE = 128  # pixels of a picture
FULL = 0.5  # part of the reference's mean at which the colours of a difference are full
OVERSTATED = 3.0  # times the error that was measured
HEAD = ["regime", "method", "what breaks", "off", "bound", "said", "mend", "then"]


def chart(methods: Sequence[str], side: int, folder: Path, progress: Progress) -> list[Path]:
    """Run all regimes, or those of some methods; returns the files that were written."""
    store, outcomes = Store(), []
    chosen = [regime for regime in REGIMES if regime.method in methods or not methods]
    for number, regime in enumerate(chosen):
        progress("regimes", number, len(chosen))
        outcomes.append(run(regime, side, store, progress))
    progress("regimes", len(chosen), len(chosen))
    return write(outcomes, regimes_document(outcomes, side, this_machine()), folder)


def write(outcomes: Sequence[Outcome], document: dict[str, Any], folder: Path) -> list[Path]:
    """The numbers, the table, and a sheet of pictures for each group; returns their paths."""
    numbers, words = write_json(document, folder, "stability"), folder / "stability.md"
    head = ["# Where methods fail, and what is said of it", "", *markdown(document)]
    words.write_text("\n".join([*head, "", machine_caption(document), ""]))
    paths = [numbers, words]
    for group, regimes in GROUPS.items():
        shown = [outcome for outcome in outcomes if outcome.regime in regimes]
        if shown:
            path = folder / sheet_name(group)
            figure = contact_sheet.draw(sheet(group, shown, document))
            figure.savefig(path, dpi=150, metadata={"Software": None})
            paths.append(path)
    return paths


def sheet_name(group: str) -> str:
    """The file of a group's pictures."""
    return f"stability-{group.replace(' ', '-')}.png"


def regimes_document(outcomes: Sequence[Outcome], side: int, machine: Machine) -> dict[str, Any]:
    """Outcomes as JSON: provenance, counts, and a row for each."""
    return finite(
        {
            **provenance(),
            "machine": machine.as_dict(),
            "width": side,
            "height": side,
            "budget": BUDGET,
            "overstated_from": OVERSTATED,
            "counts": counts(outcomes),
            "regimes": [_row(outcome) for outcome in outcomes],
        }
    )


def counts(outcomes: Iterable[Outcome]) -> dict[str, Any]:
    """How often warnings are right, against what was measured.

    warnings      all that were given, and how many of them have a size
    false_alarms  those with a size above the budget though the picture's error is below
    overstated    those with a size above the budget and OVERSTATED times the error
    silent        names of regimes with an error above the budget and no warning
    """
    outcomes = list(outcomes)
    given = [(o, code, size) for o in outcomes for code, size in o.sizes.items()]
    loud = [(o, code, size) for o, code, size in given if size > BUDGET]
    return {
        "regimes": len(outcomes),
        "warnings": len(given),
        "sized": sum(size > 0 for _, _, size in given),
        "false_alarms": [_named(o, code) for o, code, _ in loud if o.error <= BUDGET],
        "overstated": [_named(o, code) for o, code, size in loud if size > OVERSTATED * o.error],
        "silent": [o.regime.name for o in outcomes if o.error > BUDGET and not o.sizes],
    }


def _named(outcome: Outcome, code: str) -> str:
    return f"{outcome.regime.name}: {code}"


def _row(outcome: Outcome) -> dict[str, Any]:
    regime = outcome.regime
    mend = regime.mend
    return {
        "group": next(name for name, group in GROUPS.items() if regime in group),
        "name": regime.name,
        "method": regime.method,
        "words": regime.words,
        "settings": asdict(settings_from(METHODS[regime.method].settings, outcome.settings)),
        "edit": regime.edit.model_dump(mode="json", exclude_none=True),
        "error": outcome.error,
        "floor": outcome.floor,
        "bound": regime.bound,
        "warnings": outcome.sizes,
        "sentences": outcome.sentences,
        "mend": None if mend is None else mend.words,
        "mended_error": outcome.mended,
        "mended_warnings": outcome.mended_codes,
    }


def markdown(document: dict[str, Any]) -> list[str]:
    """Lines: what the counts say, and a table for each group."""
    found, side = document["counts"], document["width"]
    lines = [
        f"{found['regimes']} regimes at {side} x {side} pixels, relative L2 against the path "
        f"tracer without edges and lamps; {found['warnings']} warnings, {found['sized']} of them "
        "with a size.",
        "",
        *(f"- {line}" for line in told_of(document)),
    ]
    for group in GROUPS:
        rows = [cells(row) for row in document["regimes"] if row["group"] == group]
        if rows:
            lines += ["", f"### {group.capitalize()}", "", *table(HEAD, rows, len(HEAD))]
    return lines


def told_of(document: dict[str, Any]) -> list[str]:
    """How often warnings are wrong."""
    found, budget = document["counts"], _percent(document["budget"])
    return [
        f"False alarms, above {budget} where the error is below: {_listed(found['false_alarms'])}",
        f"More than {document['overstated_from']:g} times too large: "
        f"{_listed(found['overstated'])}",
        f"Above {budget} and silent: {_listed(found['silent'])}",
    ]


def _listed(names: Sequence[str]) -> str:
    return f"{len(names)} ({'; '.join(names)})" if names else "none"


def cells(row: dict[str, Any]) -> list[str]:
    """A regime's line of the table below HEAD."""
    said = ", ".join(
        f"`{code}` {_percent(size) if size else ''}".strip()
        for code, size in row["warnings"].items()
    )
    return [
        row["name"],
        f"`{row['method']}`",
        row["words"],
        _error(row["error"], row["floor"]),
        _percent(row["bound"]),
        said or "nothing",
        row["mend"] or "the reference",
        "" if row["mended_error"] is None else _error(row["mended_error"], row["floor"]),
    ]


def _error(error: float | None, floor: float | None) -> str:
    """An error, or what the reference's noise lets one say of it."""
    if error is None or floor is None:
        return "endless"
    return _percent(error) if error > floor else f"under {_percent(floor)}"


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %" if value >= 0.1 else f"{100 * value:.2g} %"


def sheet(group: str, outcomes: Sequence[Outcome], document: dict[str, Any]) -> Sheet:
    """Ours, the reference and the difference of every regime of a group."""
    return Sheet(
        f"Where methods fail: {group}" if group != "at ease" else "Where nothing breaks",
        "Ours, the path tracer, and where ours is too bright (red) or too dark (blue), by "
        f"{_percent(FULL)} of the mean at full colour.",
        [_pictures(outcome) for outcome in outcomes],
        {**document, "regimes": [r for r in document["regimes"] if r["group"] == group]},
    )


def _pictures(outcome: Outcome) -> Row:
    exposure = auto_exposure(outcome.reference)
    said = "\n".join(outcome.sizes) or "nothing said"
    return Row(
        outcome.regime.name,
        [
            picture(outcome.ours, exposure, f"{outcome.regime.method}"),
            picture(outcome.reference, exposure, "path tracer"),
            difference(
                outcome.ours,
                outcome.reference,
                outcome.kept,
                FULL,
                f"{_percent(outcome.error)} off\n{said}",
            ),
        ],
    )
