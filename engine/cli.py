"""`relight`: scenes, precompute, render, plan, chart, bench, serve, doctor.

Results go to standard output, progress and warnings to standard error. What Relight refuses is one
line and status 2 where the input is to blame, 1 where it is not; there are no tracebacks.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated

import typer

from engine.arguments import needs_extra, read_edits, sized_scene, words
from engine.backend.choice import wanted
from engine.cli_measure import bench, chart, chosen, plan
from engine.diagnosis import worth_saying
from engine.doctor import examine
from engine.errors import REFUSED, InputError, NotFound, RelightError
from engine.images import format_of, write_image
from engine.methods import METHODS, prepare
from engine.methods.base import require_supported
from engine.options import AnyMethodOption, KindsOption, SceneArgument, SetOption, SizeOption
from engine.reference import render as render_reference
from engine.scene.edits import apply
from engine.scene.open import scenes as builtin_scenes
from engine.terminal import complain, out, progress_bars, warn

app = typer.Typer(
    help="Drag a light and see the scene relit at once, shadows and indirect light included.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.command()
def scenes() -> None:
    """List the built-in scenes."""
    listed = builtin_scenes()
    width = max(map(len, listed))
    for name, summary in listed.items():
        out.print(f"[bold]{name:<{width}}[/]  {summary}", highlight=False)


@app.command()
def precompute(
    scene: SceneArgument,
    method: AnyMethodOption = None,
    edits: KindsOption = None,
    error: Annotated[
        float | None, typer.Option(help="plan for this relative L2 error: see `relight plan`")
    ] = None,
    set_: SetOption = None,
    size: SizeOption = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="of a Dask cluster to compute on: tcp://host:8786"),
    ] = None,
) -> None:
    """Precompute a scene into the store; what is there already is kept.

    With --error the planner chooses settings, and without --method the method.
    """
    opened = sized_scene(scene, size)
    if error is None and edits is not None:
        raise InputError("--edits is for --error, which plans for them")
    method, settings = chosen(opened, method, set_, error, words(edits or ""))
    with _executor(scheduler) as executor, progress_bars() as progress:
        product = prepare(opened, method, settings, progress=progress, executor=executor)
    out.print(f"{method} of {opened.name}: {product.bytes / 1e6:.1f} MB")
    for name, value in dataclasses.asdict(product.settings).items():
        out.print(f"  {name} = {value}")


def _executor(scheduler: str | None) -> AbstractContextManager[Executor | None]:
    """The executor of a cluster, or none: the cores of this machine."""
    if scheduler is None:
        return nullcontext()
    with needs_extra("cluster"):
        from engine.methods.cluster import cluster
    return cluster(scheduler)


@app.command()
def render(
    scene: SceneArgument,
    to: Annotated[Path, typer.Option("--out", help="the image: .exr, .png, .jpg or .webp")],
    method: Annotated[
        str | None, typer.Option("--method", help=f"reference, or one of {', '.join(METHODS)}")
    ] = None,
    edits: Annotated[
        Path | None, typer.Option("--edits", help="JSON: lights and so on, as in a scene, partial")
    ] = None,
    exposure: Annotated[float, typer.Option(min=-32, max=32, help="stops, for all but EXR")] = 0.0,
    error: Annotated[
        float | None,
        typer.Option(help="relative L2 error to stop at, or of a method to plan for"),
    ] = None,
    samples: Annotated[
        int | None, typer.Option(help="reference: stop at so many samples per pixel")
    ] = None,
    seed: Annotated[int, typer.Option(help="reference: another noise")] = 0,
    backend: Annotated[
        str | None,
        typer.Option(
            help="auto, cpu or gl, in place of RELIGHT_BACKEND; auto is gl on a GPU, else cpu"
        ),
    ] = None,
    set_: SetOption = None,
    size: SizeOption = None,
) -> None:
    """Render a scene under edits with a method, or with the reference path tracer."""
    # Find what is wrong before the work, not after it.
    format_of(to)
    drawing = wanted(backend)
    opened = sized_scene(scene, size)
    change = read_edits(edits)
    edited = apply(opened, change)
    if method == "reference":
        if set_:
            raise InputError("the reference has no settings; it takes --error and --samples")
        if backend is not None:
            raise InputError("the reference has no backends; --backend is for the methods")
        with progress_bars() as progress:
            result = render_reference(
                edited, error=error, samples=samples, seed=seed, progress=progress
            )
        write_image(to, result.image, exposure)
        out.print(
            f"{to}: {result.samples} samples per pixel, relative error {result.error:.2%}, "
            f"{result.seconds:.1f} s"
        )
        return
    if samples is not None:
        raise InputError("--samples is for --method reference; see --set and --error")
    # Another camera is another precompute, not an edit that a product could take.
    opened, change = opened.with_camera(edited.camera), change.model_copy(update={"camera": None})
    method, settings = chosen(opened, method, set_, error, sorted(change.touched()))
    require_supported(method, change)
    with progress_bars() as progress:
        product = prepare(opened, method, settings, progress=progress)
    frame = product.relight(change, backend=drawing)
    write_image(to, frame.image, exposure)
    warn(frame.warnings if error is None else worth_saying(frame.warnings, error))
    out.print(f"{to}: {1000 * frame.timings['total']:.1f} ms")


app.command()(chart)
app.command()(bench)
app.command()(plan)


@app.command()
def serve(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE]...", help="the first is shown at once")
    ] = None,
    host: Annotated[str, typer.Option(help="address to listen at")] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="this or the next free one; 0 takes any")
    ] = 8000,
    open_browser: Annotated[
        bool, typer.Option("--open", help="open the page in a browser")
    ] = False,
    token: Annotated[
        str | None,
        typer.Option(
            envvar="RELIGHT_TOKEN",
            help="ask everybody for it; required where --host can be reached by others",
        ),
    ] = None,
    name: Annotated[
        list[str] | None, typer.Option(help="by which a proxy calls the service; may be repeated")
    ] = None,
    memory: Annotated[
        float, typer.Option(min=0, help="GB for products; those used last stay, others are let go")
    ] = 4.0,
) -> None:
    """Serve the page."""
    from engine.methods.warm import compile_kernels
    from server.main import serve as run
    from server.token import checked

    checked(host, token)  # rather than after the work
    with progress_bars() as progress:
        compile_kernels(progress)
    run(
        scenes or ["cornell-box"], host, port,
        open_browser=open_browser, names=name or (), token=token, memory=1e9 * memory,
    )  # fmt: skip


@app.command()
def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="print JSON in place of words")] = False,
) -> None:
    """Try out what Relight leans on: threads, Embree, OpenGL, compiled kernels, the store.

    Says what would mend what; status 1 where something is broken that nothing works without.
    """
    found = examine()
    if as_json:
        print(json.dumps([dataclasses.asdict(finding) for finding in found], indent=1))
    else:
        for each in found:
            style = {"ok": "green", "note": "yellow", "broken": "bold red"}[each.state]
            said = f"{each.what:<8} {each.says}".replace("[", r"\[")
            out.print(f"[{style}]{each.state:<6}[/] {said}", highlight=False)
            if each.do:
                out.print(f"{'':15} do: {each.do}", highlight=False, markup=False)
    if any(each.state == "broken" for each in found):
        raise typer.Exit(1)


def main() -> None:
    """Entry point: every expected error becomes one line."""
    try:
        app()
    except RelightError as error:
        complain("bold red", "relight", str(error))
        sys.exit(2 if isinstance(error, InputError | NotFound) else 1)
    except OSError as error:
        if error.errno not in REFUSED:
            raise
        complain("bold red", "relight", f"{error.filename or 'a file'}: {error.strerror}")
        sys.exit(1)


if __name__ == "__main__":
    main()
