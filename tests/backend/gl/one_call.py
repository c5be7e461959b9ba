"""Call one GLSL function on the GPU for many arguments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device

_TYPES = {1: "float", 2: "vec2", 3: "vec3", 4: "vec4"}


def call(
    gpu: Device,
    include: str,
    expression: str,
    width: int,
    *,
    before: str = "",
    made: Mapping[str, str] | None = None,
    buffers: Mapping[str, Any] | None = None,
    uniforms: Mapping[str, Any] | None = None,
    **arguments: NDArray[Any],
) -> NDArray[np.float32]:
    """(n, width) float32 of an expression over named arguments (n, k).

    Arguments of one to four columns are a float or a vector by their name, wider ones an array.
    `expression` is a list of `width` floats; `before` are statements that it needs.
    """
    n = max(len(a) for a in arguments.values())
    lines = ['#include "common/each.glsl"', f'#include "{include}"', "uniform int u_count;"]
    lines.append("layout(std430) writeonly buffer b_result { float result[]; };")
    body = []
    bound = dict(buffers or {})
    for name, values in arguments.items():
        array = np.broadcast_to(np.asarray(values, np.float32), (n, np.shape(values)[1]))
        columns = array.shape[1]
        lines.append(f"layout(std430) readonly buffer b_arg_{name} {{ float arg_{name}[]; }};")
        parts = [f"arg_{name}[{columns} * i + {k}]" for k in range(columns)]
        if columns in _TYPES:
            body.append(f"{_TYPES[columns]} {name} = {_TYPES[columns]}({', '.join(parts)});")
        else:
            body.append(f"float {name}[{columns}];")
            body.append(
                f"for (int k = 0; k < {columns}; k++) {name}[k] = arg_{name}[{columns} * i + k];"
            )
        bound[f"b_arg_{name}"] = gpu.upload(np.ascontiguousarray(array))
    body += [before, f"float answer[{width}] = float[{width}]({expression});"]
    body.append(f"for (int k = 0; k < {width}; k++) result[{width} * i + k] = answer[k];")
    text = "\n".join([*lines, "void main() { for (EACH(i, u_count)) {", *body, "} }"])
    bound["b_result"] = gpu.floats(n * width)
    program = gpu.program("one_call.glsl", made={"one_call.glsl": text, **(made or {})})
    program.run(n, bound, u_count=n, **(uniforms or {}))
    gpu.check()
    return np.frombuffer(bound["b_result"].read(4 * n * width), np.float32).reshape(n, width)
