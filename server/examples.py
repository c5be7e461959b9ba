"""An example of every route, for /openapi.json: what to send, and what comes back.

Long answers are shortened: lists hold one thing of each kind. A test sends all of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fastapi import FastAPI

JSON, BYTES = "application/json", "application/octet-stream"
PATH = {"scene": "cornell-box", "job": "Zt3yVnq0fXkD", "which": "difference"}

LAMP = {"lights": [{"id": "key", "position": [0.2, 0.4, 0.1], "intensity": [0.3, 0.2, 0.1]}]}
SKY = {"environment": {"map": {"sun_direction": [1, -1, 0.3], "turbidity": 3}}}
RED = {"materials": {"white": {"diffuse": [0.6, 0.1, 0.1]}}}

# A map of 2 x 1 pixels: red-green-blue mantissas and an exponent for each.
MAP = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n@@@~@@p~"
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
# One colour, measured in a few directions.
ROWS = [
    f"{i},0,{o},{p},0.02,0.2,0.02" for i in (10, 40, 70) for o in (10, 70) for p in (0, 90, 180)
]
COLUMNS = "theta_i_degrees,phi_i_degrees,theta_o_degrees,phi_o_degrees,red,green,blue"
TABLE = "\n".join([COLUMNS, *ROWS])

JOB = {
    "id": PATH["job"],
    "work": "product",
    "scene": "cornell-box",
    "method": "direct_to_indirect",
    "status": "running",
    "phase": "final",
    "fraction": 0.42,
    "elapsed_seconds": 20.1,
    "eta_seconds": 27.7,
    "preview": False,
    "problem": None,
}
SUMMARY = {
    "name": "cornell-box", "description": "the Cornell box", "default": True, "sent": False,
}  # fmt: skip
CAMERA = {
    "position": [0.278, 0.273, -0.8],
    "target": [0.278, 0.273, 0],
    "up": [0, 1, 0],
    "fov_y_degrees": 39.3,
    "width": 512,
    "height": 512,
}
METHOD = {
    "name": "direct_to_indirect",
    "paper": "Hašan, Pellacini, Bala 2006",
    "edits": ["environment", "lights"],
    "models": [],
    "settings": {},
    "ready": True,
    "bytes": 31_000_000,
}
SCENE = {
    "name": "cornell-box",
    "description": "the Cornell box",
    "camera": CAMERA,
    "diagonal": 0.96,
    "lights": [{"id": "key", "type": "spot", "position": [0.4, 0.5, 0.1], "enabled": True}],
    "light_types": {"spot": {"title": "Spot", "type": "object"}},
    "environment": {
        "description": None,
        "maps": ["studio"],
        "uploads": [],
        "sky": {"title": "Sky", "type": "object"},
        "area_light": {"title": "FarDisk", "type": "object"},
    },
    "materials": ["white", "red", "green"],
    "material_types": {"diffuse": {"title": "Diffuse", "type": "object"}},
    "material_presets": {"metals": {"gold": {"type": "cook_torrance"}}},
    "measured": [{"name": "plastic", "label": "plastic", "kind": "built_in"}],
    "objects": ["floor"],
    "triangles": 32,
    "methods": [METHOD],
    "warnings": [],
    "job": None,
}
MATERIAL = {
    "name": "white",
    "description": {"type": "diffuse", "diffuse": [0.7, 0.7, 0.7]},
    "curve": {"type": "half_angle_curve"},
    "terms": 1,
    "channels": 3,
    "error": 0.0,
    "bytes": 1_200_000,
}
CHART = {
    "scene": "cornell-box",
    "method": "direct_to_indirect",
    "kinds": ["lights"],
    "points": [],
    "current": None,
    "job": None,
}
VERDICT = {"error": 0.031, "least": 0.004, "psnr": 38.2, "noise": 0.02}
REFERENCE = {
    "method": "direct_to_indirect",
    "verdict": VERDICT,
    "samples": 256,
    "seconds": 11.8,
    "full": 0.2,
    "averaged": 1,
}


@dataclass(frozen=True)
class Example:
    """What to send, and the JSON that comes back, None where it is something else."""

    query: Mapping[str, Any] = field(default_factory=dict)
    body: Any = None
    media: str = JSON
    answer: Any = None


EXAMPLES: dict[tuple[str, str], Example] = {
    ("get", "/healthz"): Example(answer={"status": "ok"}),
    ("get", "/metrics"): Example(),
    ("get", "/api/scenes"): Example(answer=[SUMMARY]),
    ("get", "/api/scenes/{scene}"): Example(answer=SCENE),
    ("post", "/api/scenes/{scene}/frame"): Example({"exposure": 0.5}, LAMP),
    ("post", "/api/scenes/{scene}/environment"): Example(body=SKY),
    ("post", "/api/scenes/{scene}/materials"): Example(
        {"method": "brdf_editing"}, RED, answer=[MATERIAL]
    ),
    ("post", "/api/scenes/{scene}/pick"): Example(
        {"x": 0.5, "y": 0.9}, {}, answer={"material": "white"}
    ),
    ("post", "/api/scenes/{scene}/precompute"): Example(
        body={"method": "direct_to_indirect", "settings": {"coefficients": 100}}, answer=JOB
    ),
    ("get", "/api/scenes/{scene}/chart"): Example({"method": "direct_to_indirect"}, answer=CHART),
    ("post", "/api/scenes/{scene}/chart"): Example(
        {"method": "direct_to_indirect"}, answer=JOB | {"work": "front"}
    ),
    ("post", "/api/scenes/{scene}/reference"): Example(
        {"noise": 0.3, "seconds": 5}, LAMP, answer=JOB | {"work": "reference"}
    ),
    ("get", "/api/scenes/{scene}/materials/thumbnail"): Example(
        {"material": '{"type": "diffuse", "diffuse": [0.7, 0.1, 0.1]}'}
    ),
    ("get", "/api/jobs/{job}"): Example(answer=JOB),
    ("delete", "/api/jobs/{job}"): Example(answer=JOB | {"status": "cancelled"}),
    ("get", "/api/jobs/{job}/events"): Example(),
    ("get", "/api/jobs/{job}/reference"): Example({"exposure": 0}, answer=REFERENCE),
    ("get", "/api/jobs/{job}/reference/{which}"): Example({"exposure": 0}),
    ("post", "/api/scenes"): Example(
        {"name": "triangle.obj"}, TRIANGLE, BYTES,
        {"name": "upload:9d21", "description": "triangle.obj", "default": False, "sent": True},
    ),
    ("delete", "/api/scenes/{scene}"): Example(),
    ("post", "/api/maps"): Example(
        {"name": "two.hdr"}, MAP, BYTES,
        {"name": "upload:two-3f6c.exr", "label": "two.hdr", "width": 2, "height": 1},
    ),
    ("post", "/api/measured"): Example(
        {"name": "green.csv"}, TABLE, BYTES,
        {
            "material": {"name": "upload:green-9d21.csv", "label": "green.csv", "kind": "upload"},
            "diagnoses": [],
        },
    ),
}  # fmt: skip


def install(app: FastAPI) -> None:
    """Have the app's schema hold the examples, and what its framework cannot see."""
    plain = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            _add(plain())
        assert app.openapi_schema is not None
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def _add(schema: dict[str, Any]) -> None:
    for path, operations in schema["paths"].items():
        for method, operation in operations.items():
            example = EXAMPLES.get((method, path))
            if example is not None:
                _add_to(operation, example)


def _add_to(operation: dict[str, Any], example: Example) -> None:
    for parameter in operation.get("parameters", ()):
        known = PATH if parameter["in"] == "path" else example.query
        if parameter["name"] in known:
            parameter["example"] = known[parameter["name"]]
    if example.media == BYTES:  # which the route reads as they come
        body = {BYTES: {"schema": {"type": "string", "format": "binary"}}}
        operation["requestBody"] = {"required": True, "content": body}
    if example.body is not None:
        operation["requestBody"]["content"][example.media]["example"] = example.body
    if example.answer is not None:
        for status, answer in operation["responses"].items():
            if status.startswith("2"):
                answer["content"][JSON]["example"] = example.answer
