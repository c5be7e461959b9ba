"""The shaders of the tables: a BRDF or a light has a shader with the name of its Python file.

`shaders/brdf/phong.glsl` holds `evaluate_phong`, `shaders/light/spot.glsl` holds
`illuminate_spot`; a light with extent has `emitted_`, `irradiance_` and `glance_` as well.
Shaders that need them include `brdf/table.glsl` and `light/chosen.glsl`, which are written here.
"""

from __future__ import annotations

from types import ModuleType

from engine.brdf.table import MODULES
from engine.light.table import LIGHTS

BRDF_TABLE, CHOSEN_LIGHT = "brdf/table.glsl", "light/chosen.glsl"


def brdf_table() -> str:
    """`evaluate(model, p, wi, wo)` for all models."""
    names = [file_name(module) for module in MODULES]
    lines = [f'#include "brdf/{name}.glsl"' for name in names]
    lines += ["vec3 evaluate(int model, float p[BRDF_ROW], vec3 wi, vec3 wo)", "{"]
    for index, name in enumerate(names):
        lines += [f"    if (model == {index})", f"        return evaluate_{name}(p, wi, wo);"]
    return "\n".join([*lines, "    return vec3(0.0);", "}"])


def chosen_light(kind: int) -> str:
    """`illuminate` of the one light that a program draws, and the others if it has extent."""
    light, module = list(LIGHTS.items())[kind]
    name = file_name(module)
    functions = ("illuminate", "emitted", "irradiance", "glance")
    lines = [f"#define {f} {f}_{name}" for f in (functions if light.has_extent else functions[:1])]
    return "\n".join([f'#include "light/{name}.glsl"', *lines])


def made(kind: int) -> dict[str, str]:
    """Both files by their paths, for `source.load`."""
    return {BRDF_TABLE: brdf_table(), CHOSEN_LIGHT: chosen_light(kind)}


def file_name(module: ModuleType) -> str:
    """`spot` of `engine.light.spot`."""
    return module.__name__.rpartition(".")[2]
