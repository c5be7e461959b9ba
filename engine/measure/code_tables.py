"""Tables 1 and 2 of `wavelet_brdf` (Claustres, Barthe, Paulin 2007, §6) as Markdown, a chart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engine.brdf.wavelet.tabulate import Source
from engine.measure import code_chart, code_rates
from engine.measure.chart import machine_caption, write_figure
from engine.measure.code_study import FLOATS, NEURAL, OCTETS, OURS, SAME_GRID, study
from engine.measure.document import table
from engine.measure.stage import Thing
from engine.methods.base import Progress, silent

METRICS = {
    "mean": ("mean relative error, %", 100.0),
    "p99": ("99th percentile of it, %", 100.0),
    "rms": ("root mean square error, sr⁻¹", 1.0),
    "light": ("light in a wrong place, %", 100.0),
}
SCHEMES = {
    FLOATS: "the paper's scheme, slices of floats",
    OCTETS: "the paper's scheme, slices of bytes",
    SAME_GRID: "ours, same grid, no symmetry",
    OURS: "ours",
}
PRINTED = "the paper prints"
ITS, PAPERS = "its samples", "the paper's samples"
ROWS = (
    (FLOATS, "own", PAPERS),
    (OCTETS, "own", PAPERS),
    (SAME_GRID, "own", PAPERS),
    (OURS, "own", ITS),
    (OURS, "at_papers", PAPERS),
)


def make(
    measured: Mapping[str, Source],
    thing: Thing,
    size: tuple[int, int],
    fixed: Mapping[str, Any],
    progress: Progress = silent,
) -> dict[str, Any]:
    """Both tables as JSON; `fixed` are settings that hold for table 2."""
    document = study(measured, progress=progress)
    return {**document, "rates": code_rates.rates(thing, size, fixed, progress)}


def write(document: dict[str, Any], folder: Path) -> list[Path]:
    """Write codes.md, and codes.svg, .png and .json, into a folder; returns their paths."""
    paths = write_figure(code_chart.draw(document), document, folder, "codes")
    text = folder / "codes.md"
    text.write_text(markdown(document))
    return [text, *paths]


def markdown(document: dict[str, Any]) -> str:
    """The tables, with what they are made with."""
    lines = [
        "# Codes of BRDFs",
        "",
        f"{machine_caption(document)}. Samples are {document['samples']:,} points, of which "
        f"{document['sample_bytes'] / 1e6:.2f} MB is 1:1; a code's bytes are all that kernels "
        f"need. ε = {document['floor']:g}. Medians over parameters, and the worst.",
        "",
    ]
    for family in dict.fromkeys(s["family"] for s in document["sources"]):
        lines += _family(document, family)
    lines += ["## Bytes at the paper's errors", "", *_at_papers_errors(document), ""]
    lines += ["## Down to a small network's size", "", *_small(document), ""]
    if "rates" in document:
        lines += code_rates.markdown(document["rates"])
    return "\n".join(lines)


def _family(document: dict[str, Any], family: str) -> list[str]:
    sources = [s for s in document["sources"] if s["family"] == family]
    sizes = [document["sample_bytes"] // ratio for ratio in document["ratios"]]
    head = ["", "at", *(f"{ratio}:1" for ratio in document["ratios"])]
    lines = [f"## {family}", "", "; ".join(s["parameters"] for s in sources) + ".", ""]
    for key, (label, factor) in METRICS.items():
        rows = []
        for scheme, where, place in ROWS:
            values = [_values(sources, scheme, size, where, key) for size in sizes]
            rows.append([SCHEMES[scheme], place, *(_cell(v, factor) for v in values)])
        printed = document["paper"].get(family, {}).get(key)
        if printed is not None:
            rows.append([PRINTED, PAPERS, *(f"{factor * v:.3g}" for v in printed)])
        lines += [f"**{label}**", "", *table(head, rows, names=2), ""]
    used = [
        [
            SCHEMES[scheme],
            *(_cell(_bytes(sources, scheme, size), 1e-3) for size in sizes),
        ]
        for scheme in SCHEMES
    ]
    return [*lines, "**bytes of them, kB**", "", *table([head[0], *head[2:]], used), ""]


def _finest(source: dict[str, Any], scheme: str, size: int) -> dict[str, Any] | None:
    """The code of a scheme and a size at the finest grid that it has there."""
    fitting = [c for c in source["codes"] if c["scheme"] == scheme and c["at_most"] == size]
    return max(fitting, key=lambda code: code["cells"] or 0, default=None)


def _values(
    sources: Sequence[dict[str, Any]], scheme: str, size: int, where: str, key: str
) -> list[float]:
    codes = [_finest(source, scheme, size) for source in sources]
    return [float(code[where][key]) for code in codes if code is not None]


def _bytes(sources: Sequence[dict[str, Any]], scheme: str, size: int) -> list[float]:
    codes = [_finest(source, scheme, size) for source in sources]
    return [float(code["bytes"]) for code in codes if code is not None]


def _cell(values: Sequence[float], factor: float) -> str:
    """Median (worst)."""
    if not values:
        return "-"
    return f"{factor * float(np.median(values)):.3g} ({factor * max(values):.3g})"


def _at_papers_errors(document: dict[str, Any]) -> list[str]:
    """Of our codes, at their own samples."""
    rows = []
    for family, printed in document["paper"].items():
        found = [s["bytes_at_papers_error"] for s in document["sources"] if s["family"] == family]
        for k, error in enumerate(printed["mean"] if found else ()):
            ratio = document["ratios"][k]
            papers = document["sample_bytes"] / ratio
            sizes = [float(each[k]) for each in found]
            rows.append([family, f"{error:.2%}", f"{papers / 1e3:.0f}", _cell(sizes, 1e-3)])
    return table(["", "error", "the paper's kB", "our kB"], rows)


def _small(document: dict[str, Any]) -> list[str]:
    """Of every size the best grid, by the mean error at the paper's samples."""
    families = list(dict.fromkeys(s["family"] for s in document["sources"]))
    sizes = sorted({c["at_most"] for s in document["sources"] for c in s["codes"]}, reverse=True)
    rows = []
    for size in sizes:
        for error in ("mean", "light"):
            cells = []
            for family in families:
                sources = [s for s in document["sources"] if s["family"] == family]
                best = [code_chart.best_of(source, OURS, size) for source in sources]
                values = [float(code["at_papers"][error]) for code in best if code]
                cells.append(_cell(values, 100) if len(values) == len(sources) else "-")
            name = f"{size / 1e3:,.1f} kB" + (", 675 floats" if size == NEURAL else "")
            rows.append([name if error == "mean" else "", METRICS[error][0], *cells])
    return table(["at most", "", *families], rows, names=2)
