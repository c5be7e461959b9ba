"""Which edits methods are judged on: drawn from a seed, and seen by no precompute."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from engine.errors import InputError
from engine.measure.material_edits import held_out_materials
from engine.measure.probes import held_out_edits, held_out_turns, held_out_views, nudged
from engine.methods import METHODS
from engine.scene.edits import Edits
from engine.scene.scene import Scene

HELD_OUT: dict[str, Callable[[Scene, int, int], list[Edits]]] = {
    "materials": held_out_materials,
    "lights": held_out_edits,
    "environment": held_out_turns,
    "camera": held_out_views,
}
"""(scene, count, seed) -> edits, by what they touch."""

PATH, PATH_STEP = 4, 0.01  # edits of a drag; of the scene's size, from one to the next


def kind_of_edits(methods: Sequence[str], asked: str | None = None) -> str:
    """What methods are judged on: what is asked for, else the first of HELD_OUT that all take.

    One that reflects the light of lamps alone is judged on those rather than on materials.
    """
    able = [kind for kind in HELD_OUT if all(kind in METHODS[m].edits for m in methods)]
    if asked is not None:
        if asked not in HELD_OUT:
            raise InputError(f"{asked!r} cannot be drawn; {_listed(HELD_OUT)} can", field="of")
        unable = [m for m in methods if asked not in METHODS[m].edits]
        if unable:
            raise InputError(f"{_listed(unable)} takes no edits of {asked}", field="of")
        return asked
    if any(METHODS[m].lamps_alone for m in methods) and "lights" in able:
        return "lights"
    if not able:
        raise InputError(
            f"{_listed(methods)} take different edits: chart them one by one", field="method"
        )
    return able[0]


def methods_for(kind: str) -> list[str]:
    """All methods that take edits of a kind; InputError for what none does."""
    able = [name for name, method in METHODS.items() if kind in method.edits]
    if not able:
        raise InputError(f"no method takes edits of {kind!r}; of {_listed(HELD_OUT)}", field="of")
    return able


def judged_on(
    scene: Scene, methods: Sequence[str], count: int, seed: int, asked: str | None = None
) -> tuple[Scene, list[Edits]]:
    """(scene, edits) that methods are judged on; see `kind_of_edits`.

    Only light that all of them carry shines: no lamps where one carries none, no environment where
    one reflects that of lamps alone. InputError where no light is left.
    """
    kind = kind_of_edits(methods, asked)
    no_lamps = any("lights" not in METHODS[m].edits for m in methods)
    lamps_alone = any(METHODS[m].lamps_alone for m in methods)
    if no_lamps and lamps_alone:
        raise InputError(f"{_listed(methods)} carry no light in common", field="method")
    if no_lamps:
        scene = scene.with_lights(())
    if lamps_alone:
        scene = scene.with_environment(None)
    return scene, HELD_OUT[kind](scene, count, seed)


def drag_path(scene: Scene, edit: Edits, steps: int = PATH) -> list[Edits]:
    """An edit, and those that a hand would pass that goes on from there."""
    return [nudged(edit, k * PATH_STEP * scene.diagonal) for k in range(steps)]


def _listed(words: Iterable[str]) -> str:
    return ", ".join(words)
