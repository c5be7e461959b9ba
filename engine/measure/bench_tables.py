"""A benchmark as tables for a terminal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rich.table import Table

Row = Callable[..., tuple[str, list[str]]]


def bench_tables(document: dict[str, Any]) -> list[Table]:
    """The machine, then a column per scene."""
    machine = document["machine"]
    facts = Table(box=None, show_header=False)
    facts.add_row("machine", f"{machine['cpu']}, {machine['threads']} threads")
    facts.add_row("memory read", f"{machine['memory_read_gb_s']:.1f} GB/s")
    facts.add_row("random rays", f"{machine['random_rays_m_s']:.1f} M/s")
    facts.add_row("version", f"{document['relight']}, {document['commit']}, {document['date']}")

    scenes = document["scenes"]
    table = Table(title=scenes[0]["method"], title_justify="left")
    table.add_column("")
    for scene in scenes:
        name = f"{scene['scene']}\n{scene['width']}x{scene['height']}"
        table.add_column(name, justify="right")
    for label, cells in _rows(scenes):
        table.add_row(label, *cells)
    return [facts, table]


def _rows(scenes: list[dict[str, Any]]) -> list[tuple[str, list[str]]]:
    def row(label: str, *path: str, unit: str, factor: float = 1.0) -> tuple[str, list[str]]:
        return label, [_cell(scene, path, factor, unit) for scene in scenes]

    phases = dict.fromkeys(name for s in scenes for name in s["phase_seconds"])
    parts = dict.fromkeys(name for s in scenes for name in s["frame_seconds"]["parts"])
    lights = dict.fromkeys(name for s in scenes for name in s["frame_seconds"]["lights"])
    return [
        row("triangles", "triangles", unit=""),
        row("precompute", "precompute_seconds", unit="s"),
        *(row(f"  {name}", "phase_seconds", name, unit="s") for name in phases),
        row("transport", "bytes", unit="MB", factor=1e-6),
        row("edit to linear frame, median", "frame_seconds", "median", unit="ms", factor=1e3),
        row("  95th percentile", "frame_seconds", "p95", unit="ms", factor=1e3),
        *(
            row(f"  {name}", "frame_seconds", "lights", name, unit="ms", factor=1e3)
            for name in lights
        ),
        *(
            row(f"  {name}", "frame_seconds", "parts", name, unit="ms", factor=1e3)
            for name in parts
            if name != "total"
        ),
        row("products / memory bandwidth", "ratios", "product_bandwidth", unit="%", factor=100),
        *(
            [row("a code's value / its formula's", "ratios", "code_over_formula", unit="x")]
            if "code_over_formula" in scenes[0]["ratios"]
            else []
        ),
        row("reference render to 2 % error", "reference", "seconds_to_2_percent", unit="s"),
        row("reference / frame", "ratios", "reference_over_frame", unit="x"),
        row("precompute / reference", "ratios", "precompute_over_reference", unit="x"),
        *(
            [
                row("Mitsuba at our L² error / frame", "ratios", "mitsuba_over_ours", unit="x"),
                row("  denoised, at our PSNR / frame", "ratios", "denoised_over_ours", unit="x"),
                ("  its variant", [s["rivals"]["variant"] for s in scenes]),
            ]
            if "rivals" in scenes[0]
            else []
        ),
        *(_backend_rows(scenes, row) if "gl" in scenes[0] else []),
    ]


def _backend_rows(scenes: list[dict[str, Any]], row: Row) -> list[tuple[str, list[str]]]:
    found = [("OpenGL", [scene["gl"]["an edit"]["renderer"] for scene in scenes])]
    for what in scenes[0]["gl"]:
        found += [
            row(f"  {what}, by OpenGL", "gl", what, "seconds", "gl", unit="ms", factor=1e3),
            row(f"  {what}, by kernels", "gl", what, "seconds", "cpu", unit="ms", factor=1e3),
            (
                "  pictures apart, at worst",
                [f"{scene['gl'][what]['apart']['worst']:.1e}" for scene in scenes],
            ),
        ]
    return found


def _cell(scene: dict[str, Any], path: tuple[str, ...], factor: float, unit: str) -> str:
    value: Any = scene
    for key in path:
        value = value.get(key) if value is not None else None
    if value is None:
        return "-"
    return (
        f"{value:,} {unit}"
        if isinstance(value, int) and factor == 1
        else (f"{factor * value:,.{0 if factor * value >= 1000 else 2}f} {unit}")
    )
