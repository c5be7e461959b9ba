"""Chart how well K terms fit a BRDF: figure 5 of `glossy_prt` (Wang, Tran, Luebke 2006).

Cosine-weighted RMS error over uniform pairs of directions against the number of terms, a line per
map size. What a line comes to lie at is the error of bilinear look-ups between texels.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from engine.brdf.base import Material
from engine.brdf.factorisation import TERMS, factor
from engine.brdf.fit import PAIRS, albedo_kept, negative_share, rms_errors, uniform_pairs
from engine.measure.chart import GREY, line_style, plain_numbers, quiet, write_figure
from engine.measure.document import finite, provenance
from engine.methods.base import Progress, silent

SIZES = (16, 32, 48, 64)
SHOWN = (1, 2, 4, 8, 16, 32, 64)


def write(
    materials: Mapping[str, Material], folder: Path, progress: Progress = silent
) -> list[Path]:
    """Write factorisation.svg, .png and .json into a folder; returns their paths."""
    document = fit_document(materials, progress=progress)
    return write_figure(draw(document), document, folder, "factorisation")


def fit_document(
    materials: Mapping[str, Material],
    sizes: tuple[int, ...] = SIZES,
    terms: int = SHOWN[-1],
    pairs: int = PAIRS,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Errors of all fits as JSON: per material and size one number for 1, 2, ... terms.

    A diffuse material has one exact term and its error is the rounding of a float.
    """
    found = []
    for number, (name, material) in enumerate(materials.items()):
        drawn = uniform_pairs(material, pairs)
        fits = []
        for step, size in enumerate(sizes):
            factored = factor(material, terms, size)
            errors, none = rms_errors(factored, drawn)
            usual = factored.first(TERMS)
            fits.append(
                {
                    "size": size,
                    "rms": errors.tolist(),
                    "albedo_kept": albedo_kept(usual, material).tolist(),
                    "negative_share": negative_share(usual),
                }
            )
            done = number * len(sizes) + step + 1
            progress("factorisation", done, len(sizes) * len(materials))
        found.append(
            {
                "name": name,
                "material": material.model_dump(mode="json"),
                "rms_of_none": none,
                "fits": fits,
            }
        )
    return finite({**provenance(), "pairs": pairs, "usual_terms": TERMS, "materials": found})


def draw(document: dict[str, Any]) -> Figure:
    """The figure: a panel per material, both scales logarithmic."""
    materials = document["materials"]
    figure = Figure(figsize=(3.1 * len(materials) + 0.6, 3.9), layout="constrained")
    grid = figure.subplots(1, len(materials), squeeze=False)[0]
    for axes, material in zip(grid, materials, strict=True):
        _draw_material(axes, material)
    grid[0].set_ylabel("cosine-weighted RMS error (sr⁻¹)")
    figure.suptitle("BRDFs by terms and map size", fontsize=11, x=0.01, ha="left")
    caption = (
        f"{document['pairs']:,} uniform pairs of directions; in grey the RMS of the BRDF itself, "
        f"and the usual {document['usual_terms']} terms; {document['date'][:10]}, "
        f"{document['commit']}"
    )
    figure.supxlabel(caption, fontsize=7, color=GREY, x=0.01, ha="left")
    return figure


def _draw_material(axes: Axes, material: dict[str, Any]) -> None:
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.axhline(material["rms_of_none"], color=GREY, linewidth=0.8, linestyle=":")
    axes.axvline(TERMS, color=GREY, linewidth=0.8, linestyle=":")
    for number, fit in enumerate(material["fits"]):
        k = [n for n in SHOWN if n <= len(fit["rms"])]
        rms = [fit["rms"][n - 1] for n in k]
        axes.plot(k, rms, **line_style(number), label=f"{fit['size']} x {fit['size']}")
    axes.legend(fontsize=7, frameon=False, loc="lower left", title="texels", title_fontsize=7)
    axes.set_title(material["name"], fontsize=9, loc="left")
    axes.set_xlabel("terms K")
    axes.set_xticks(SHOWN, [str(n) for n in SHOWN], fontsize=8)
    axes.xaxis.set_minor_locator(NullLocator())
    plain_numbers(axes.yaxis)
    low = min(min(fit["rms"]) for fit in material["fits"])
    axes.set_ylim(max(low, 1e-4 * material["rms_of_none"]) / 1.6, 1.25 * material["rms_of_none"])
    quiet(axes)
