"""The report as one HTML file that needs no other: text, tables, charts as they were measured."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from string import Template
from typing import Any

from engine.measure.stability import HEAD, cells, told_of

STYLE = """
:root { color-scheme: light dark }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 84rem; margin: 2rem auto; padding: 0 1rem }
h1, h2, h3 { line-height: 1.2 } h2 { margin-top: 3rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 13px }
th, td { padding: .25rem .4rem; border-bottom: 1px solid #8884; text-align: right }
th { text-align: right; vertical-align: bottom }
.words { text-align: left } td:not(.words) { white-space: nowrap }
.wide { overflow-x: auto } .bad { color: #d55e00; font-weight: 600 }
figure { margin: 1rem 0 } img { width: 100%; background: white }
.small { color: #888; font-size: 13px }
"""

PAGE = Template("""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Relight: speed against accuracy</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>$style</style></head>
<body><h1>Relight: speed against accuracy</h1>
<p>Every number on this page was measured by <code>relight chart --report</code> on one machine:
$machine. Times are medians. Errors are relative L² against converged path tracing, on edits that no
precompute has seen, without pixels that have edges or show a lamp itself, and with the references'
own noise taken out.</p>
$body
</body></html>
""")

Cell = str | float | None


def page(
    surveys: Sequence[dict[str, Any]],
    charts: Sequence[bytes],
    against: dict[str, Any],
    regimes: dict[str, Any],
    sheets: Mapping[str, bytes],
) -> str:
    """The whole file.

    surveys  of `engine.measure.survey`
    charts   of each, as SVG
    against  of `engine.measure.papers.compare`
    regimes  of `engine.measure.stability`
    sheets   pictures of each of its groups, as PNG
    """
    parts = [*_plans(surveys), *_papers(against)]
    before = None
    for survey, chart in zip(surveys, charts, strict=True):
        if survey["scene"] != before:
            parts.append(f"<h2>{escape(survey['scene'])}</h2>")
        before = survey["scene"]
        parts += _scene(survey, chart)
    parts += _stability(regimes, sheets)
    return PAGE.substitute(style=STYLE, machine=escape(_machine(against)), body="\n".join(parts))


def _machine(document: dict[str, Any]) -> str:
    m = document["machine"]
    return (
        f"{m['cpu']}, {m['threads']} threads, {m['memory_read_gb_s']:.1f} GB/s of memory, "
        f"{m['random_rays_m_s']:.1f} million rays a second"
    )


def _plans(surveys: Sequence[dict[str, Any]]) -> Iterable[str]:
    """What the planner promised of every scene, and what came of it."""
    head = ["scene", "edits", "method", "asked", "promised", "is", "held", "frame promised (ms)",
            "is", "best swept", "MB promised", "is", "precompute promised (s)", "is",
            "planned in (s)"]  # fmt: skip
    rows: list[list[Cell]] = []
    for s in surveys:
        plan, promised, measured = s["plan"], s["plan"]["predicted"], s["plan"]["measured"]
        best = plan["best_swept_frame"]
        held = "yes" if plan["kept"] else "no, and said so" if not plan["holds"] else "NO"
        rows.append(
            [s["scene"], ", ".join(s["kinds"]), plan["method"], _percent(plan["budget"]),
             _percent(promised["error"]), _percent(measured["error"]), held,
             1e3 * promised["frame"], 1e3 * measured["frame"], best and 1e3 * best,
             1e-6 * promised["bytes"], 1e-6 * measured["bytes"],
             promised["precompute"], measured["precompute"], plan["seconds"]]
        )  # fmt: skip
    yield "<h2>Plans: promised and measured</h2>"
    yield (
        "<p>Who asks for an error gets a method and its settings, each at the least that holds, "
        "without naming any. “Best swept” is the fastest of all rungs of all methods that hold the "
        "same error.</p>"
    )
    yield _table(head, rows, words=3)


def _papers(against: dict[str, Any]) -> Iterable[str]:
    """The papers' own figures beside ours."""
    counted = list(dict.fromkeys(name for row in against["rows"] for name in row["theirs"]))
    head = ["method", "the paper's case", "its machine", "our scene", "settings"]
    head += [f"{name}: {who}" for name in counted for who in ("paper", "ours")]
    rows: list[list[Cell]] = []
    for row in against["rows"]:
        settings = ", ".join(f"{k}={v}" for k, v in row["settings"].items()) or "defaults"
        words: list[Cell] = [row["method"], row["name"], row["machine"], row["scene"], settings]
        numbers = [row[who].get(name) for name in counted for who in ("theirs", "ours")]
        rows.append([*words, *numbers])
    yield "<h2>Beside the papers' own figures</h2>"
    yield (
        "<p>At the papers' settings and picture sizes. Their machines are of 2004 to 2008, and use "
        "a graphics card where one is named; ours uses none.</p>"
    )
    yield _table(head, rows, words=5)


def _stability(regimes: dict[str, Any], sheets: Mapping[str, bytes]) -> Iterable[str]:
    """Where methods fail, by how much, and what is said."""
    yield "<h2>Where methods fail</h2><ul>"
    yield from (f"<li>{escape(line)}</li>" for line in told_of(regimes))
    yield "</ul>"
    for group, sheet in sheets.items():
        rows = [cells(row) for row in regimes["regimes"] if row["group"] == group]
        yield f"<h3>{escape(group.capitalize())}</h3>"
        yield _table(HEAD, rows, words=len(HEAD))
        yield _figure(sheet, "image/png", f"Ours, the reference, the difference: {group}")


def _scene(survey: dict[str, Any], chart: bytes) -> Iterable[str]:
    """What edits of a kind cost there, and what its plan leaves out."""
    plan = survey["plan"]
    words = f"Error against frame time, bytes and precompute: {survey['scene']}"
    yield f"<h3>Edits of {escape(' and '.join(survey['kinds']))}</h3>"
    yield _figure(chart, "image/svg+xml", words)
    held = "holds" if plan["holds"] else "does not hold"
    yield (
        f"<p>Planned for {_percent(plan['budget'])}: <b>{escape(plan['method'])}</b>, which "
        f"{held} it.</p><ul>"
    )
    yield from (f"<li>{escape(reason)}</li>" for reason in plan["reasons"])
    yield from (f"<li>left out: {escape(reason)}</li>" for reason in plan["left_out"])
    yield "</ul>"
    yield f'<p class="small">{survey["date"][:10]}, {survey["commit"]}, seed {survey["seed"]}</p>'


def _figure(data: bytes, media_type: str, words: str) -> str:
    """A picture as a data address."""
    address = f"data:{media_type};base64,{base64.b64encode(data).decode()}"
    return f'<figure><img alt="{escape(words)}" src="{address}"></figure>'


def _table(head: Sequence[str], rows: Sequence[Sequence[Cell]], words: int) -> str:
    """A table whose first columns are words."""
    lines = ['<div class="wide"><table>', _row("th", head, words)]
    lines += [_row("td", row, words) for row in rows]
    return "\n".join([*lines, "</table></div>"])


def _row(tag: str, cells: Sequence[Cell], words: int) -> str:
    def classes(k: int, text: str) -> str:
        names = ["words"] * (k < words) + ["bad"] * (text == "NO")
        return f' class="{" ".join(names)}"' if names else ""

    texts = [_short(cell) for cell in cells]
    made = (f"<{tag}{classes(k, t)}>{_marked(t)}</{tag}>" for k, t in enumerate(texts))
    return f"<tr>{''.join(made)}</tr>"


def _marked(text: str) -> str:
    """Text with `code` in it."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))


def _short(cell: Cell) -> str:
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    return f"{cell:.0f}" if abs(cell) >= 100 else f"{cell:.3g}"


def _percent(part: float) -> str:
    return f"{100 * part:.3g} %"
