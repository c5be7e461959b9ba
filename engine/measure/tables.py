"""Tables I and II of `glossy_prt` (Wang, Tran, Luebke 2006, §5.1): what objects cost.

Each object has the paper's Ashikhmin-Shirley material and lies on a matt floor of as many vertices
as the paper's. Table I is the precompute, table II are frames.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from engine.brdf.published import BRUSHED
from engine.light.environment import EnvironmentDescription
from engine.light.maps import load_environment
from engine.measure.chart import machine_caption
from engine.measure.document import finite, provenance, table, write_json
from engine.measure.fresh import fresh
from engine.measure.machine import this_machine
from engine.measure.probes import held_out_turns, held_out_views
from engine.measure.settings import settings_from
from engine.measure.stage import Thing, ball, stage
from engine.measure.sweep import REPEATS, STEP, time_frames
from engine.methods import METHODS
from engine.methods.base import Product, Progress, silent
from engine.scene.edits import Edits
from engine.scene.scene import Scene

METHOD = "glossy_prt"
TERMS = (1, 4)
CUTS = 176  # of the floor: 31 K vertices
SIZE = (512, 512)
EDITS = 3

PAPER = {
    "machine": "Pentium 4, 2.4 GHz, with a GeForce 6800",
    "objects": ("Bird", "Bunny", "Head", "Buddha", "Lucy"),
    "rows": {
        "vertices": ("25 K", "36 K", "49 K", "56 K", "102 K"),
        "triangles": ("50 K", "70 K", "98 K", "113 K", "203 K"),
        "direct, K = 1": ("5.3 min", "5.6 min", "7.7 min", "11 min", "20 min"),
        "direct, K = 4": ("11 min", "14 min", "20 min", "24 min", "44 min"),
        "direct, K = 1, size": ("35 MB", "36 MB", "50 MB", "54 MB", "83 MB"),
        "direct, K = 4, size": ("82 MB", "100 MB", "142 MB", "160 MB", "273 MB"),
        "bounce, K = 1": ("20 min", "22 min", "23 min", "35 min", "56 min"),
        "bounce, K = 4": ("39 min", "46 min", "51 min", "109 min", "122 min"),
        "view, K = 1, GPU / CPU": ("230 / 79", "226 / 79", "255 / 56", "210 / 47", "173 / 35"),
        "view, K = 4, GPU / CPU": ("123 / 67", "97 / 62", "160 / 46", "90 / 38", "101 / 26"),
        "light, K = 1, GPU / CPU": ("31 / 13", "31 / 12", "25 / 10", "7.6 / 8.7", "- / 5.9"),
        "light, K = 4, GPU / CPU": ("- / 5.8", "- / 4.8", "- / 3.6", "- / 2.9", "- / 1.8"),
    },
}
"""What the paper's tables say, of its own machine and its own floor of 31 K vertices."""


def profiles(
    things: Sequence[Thing],
    *,
    size: tuple[int, int] = SIZE,
    cuts: int = CUTS,
    fixed: Mapping[str, Any] | None = None,
    seed: int = 1,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Both tables as JSON; seconds, bytes, frames per second.

    size   width and height of the pictures
    cuts   of the floor along both sides
    fixed  settings that hold throughout
    seed   draws the turns of the environment and the views
    """
    # What is compiled is compiled before the clock runs.
    _profile(brushed(ball(4), (16, 16), 4), 1, fixed or {}, seed, silent)
    found = []
    for number, thing in enumerate(things):
        progress("objects", number, len(things))
        scene = brushed(thing, size, cuts)
        own = scene.geometry.object == 0
        found.append(
            {
                "name": thing.name,
                "vertices": len(thing.part.positions),
                "triangles": int(own.sum()),
                "floor_vertices": len(scene.geometry.positions) - len(thing.part.positions),
                "terms": {str(k): _profile(scene, k, fixed or {}, seed, progress) for k in TERMS},
            }
        )
    progress("objects", len(things), len(things))
    return finite(
        {
            **provenance(),
            "machine": this_machine().as_dict(),
            "method": METHOD,
            "material": BRUSHED.model_dump(mode="json"),
            "width": size[0],
            "height": size[1],
            "seed": seed,
            "objects": found,
            "paper": PAPER,
        }
    )


def brushed(thing: Thing, size: tuple[int, int], cuts: int) -> Scene:
    """A thing of the paper's brushed metal, on a floor in the studio."""
    studio = load_environment(EnvironmentDescription(map="studio"), Path())
    return stage(thing, BRUSHED, size, cuts=cuts, environment=studio)


def _profile(
    scene: Scene, terms: int, fixed: Mapping[str, Any], seed: int, progress: Progress
) -> dict[str, Any]:
    def settings(bounces: int) -> Any:
        values = {**fixed, "terms": terms, "bounces": bounces}
        return settings_from(METHODS[METHOD].settings, values)

    with fresh(scene, METHOD, settings(0), progress) as made:
        direct_seconds, direct_bytes = made.seconds, made.product.bytes
    with fresh(scene, METHOD, settings(1), progress) as made:
        passes = [took for phase, took in made.phases.items() if phase.startswith("bounce")]
        return {
            "direct_seconds": direct_seconds,
            "direct_bytes": direct_bytes,
            "bounce_seconds": sum(passes),
            "bytes": made.product.bytes,
            "view_fps": _rate(made.product, scene, held_out_views(scene, EDITS, seed)),
            "light_fps": _rate(made.product, scene, held_out_turns(scene, EDITS, seed)),
        }


def _rate(product: Product, scene: Scene, edits: Sequence[Edits]) -> float:
    """Frames per second, of which every one is new."""
    _, timing, _ = time_frames(product, edits, REPEATS, STEP * scene.diagonal)
    return 1.0 / timing.median


def write(document: dict[str, Any], folder: Path) -> list[Path]:
    """Write tables.json and tables.md into a folder; returns their paths."""
    numbers, text = write_json(document, folder, "tables"), folder / "tables.md"
    text.write_text(markdown(document))
    return [numbers, text]


Row = tuple[str, str, str, float]  # label, key of a profile, format, factor
PRECOMPUTE: tuple[Row, ...] = (
    ("direct", "direct_seconds", "{:,.1f} s", 1.0),
    ("size of it", "direct_bytes", "{:,.1f} MB", 1e-6),
    ("one bounce more", "bounce_seconds", "{:,.1f} s", 1.0),
    ("size of both", "bytes", "{:,.1f} MB", 1e-6),
)
FRAMES: tuple[Row, ...] = (
    ("new view", "view_fps", "{:,.1f}", 1.0),
    ("new light", "light_fps", "{:,.1f}", 1.0),
)


def markdown(document: dict[str, Any]) -> str:
    """Both tables, and the paper's below them."""
    objects, paper = document["objects"], document["paper"]
    names = [entry["name"] for entry in objects]
    counts = [
        [label, *(f"{entry[key]:,}" for entry in objects)]
        for label, key in (
            ("vertices", "vertices"),
            ("triangles", "triangles"),
            ("vertices of the floor", "floor_vertices"),
        )
    ]

    def lines(rows: Sequence[Row]) -> list[list[str]]:
        return [
            [f"{label}, K = {k}", *(form.format(factor * e["terms"][k][key]) for e in objects)]
            for label, key, form, factor in rows
            for k in objects[0]["terms"]
        ]

    size = f"{document['width']} x {document['height']}"
    return "\n".join(
        [
            f"# What objects cost `{document['method']}`",
            "",
            f"Brushed objects on a matt floor. {machine_caption(document)}.",
            "",
            "## Precompute",
            "",
            *table(["", *names], [*counts, *lines(PRECOMPUTE)]),
            "",
            f"## Frames per second at {size}, one bounce included",
            "",
            *table(["", *names], lines(FRAMES)),
            "",
            f"## The paper's tables I and II: {paper['machine']}",
            "",
            *table(
                ["", *paper["objects"]], [[label, *row] for label, row in paper["rows"].items()]
            ),
            "",
        ]
    )
