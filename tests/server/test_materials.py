"""Other materials than the scene's: a precompute by name, then frames that ask for them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import FastAPI

from engine.images import read_image
from server.app import create_app

Serving = Callable[[FastAPI], AbstractContextManager[str]]
FLOOR = {"shape": "rectangle", "size": [2, 2]}
SCENE = {
    "camera": {"position": [0, 2, 0.1], "target": [0, 0, 0], "width": 8, "height": 8,
               "fov_y_degrees": 20},
    "environment": {"map": [1, 1, 1]},
    "lights": [],
    "materials": {"floor": {"type": "diffuse", "diffuse": [0.5, 0.5, 0.5]}},
    "objects": [{"name": "floor", "mesh": FLOOR, "material": "floor",
                 "transform": {"rotate_degrees": [-90, 0, 0]}}],
}  # fmt: skip
SETTINGS = {"light_texels": 16, "visibility_texels": 16, "bounces": 0, "brdf_texels": 16}
RED = {"floor": {"diffuse": [0.6, 0.1, 0.1]}}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory, serving: Serving) -> Iterator[httpx.Client]:
    path = tmp_path_factory.mktemp("scene") / "floor.json"
    path.write_text(json.dumps(SCENE))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RELIGHT_STORE", str(tmp_path_factory.mktemp("store")))
        app = create_app([str(path)], precompute_at_start=False)
        with serving(app) as address, httpx.Client(base_url=address, timeout=120) as client:
            yield client


def precompute(client: httpx.Client, materials: Any, method: str = "glossy_prt") -> None:
    wanted = {
        "method": method,
        "settings": SETTINGS if method == "glossy_prt" else {"gather_samples": 256},
        "edits": {"materials": materials},
    }
    job = client.post("/api/scenes/floor/precompute", json=wanted)
    assert job.status_code == 202, job.text
    path = f"/api/jobs/{job.json()['id']}"
    while client.get(path).json()["status"] in ("queued", "running"):
        time.sleep(0.1)
    assert client.get(path).json()["status"] == "done"


def frame(client: httpx.Client, edits: Any, method: str = "glossy_prt") -> httpx.Response:
    return client.post(
        "/api/scenes/floor/frame",
        json=edits,
        params={"method": method},
        headers={"Accept": "image/x-exr"},
    )


def colour(response: httpx.Response, folder: Path) -> np.ndarray:
    assert response.status_code == 200, response.text
    path = folder / "frame.exr"
    path.write_bytes(response.content)
    return read_image(path).mean(axis=(0, 1))


def materials(client: httpx.Client, edits: Any) -> list[dict[str, Any]]:
    answer = client.post("/api/scenes/floor/materials", json=edits, params={"method": "glossy_prt"})
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_materials_are_drawn_once_they_are_precomputed(
    client: httpx.Client, tmp_path: Path
) -> None:
    refused = frame(client, {"materials": RED})
    assert (refused.status_code, refused.json()["field"]) == (422, "materials")
    assert "precomputed" in refused.json()["detail"]
    assert materials(client, {"materials": RED})[0]["terms"] is None
    precompute(client, {})
    precompute(client, RED)
    own, red = frame(client, {}), frame(client, {"materials": RED})
    np.testing.assert_allclose(colour(own, tmp_path), 0.5, rtol=0.02)
    np.testing.assert_allclose(colour(red, tmp_path), [0.6, 0.1, 0.1], rtol=0.02)
    # What the method takes at once it takes with them too.
    twice = frame(client, {"materials": RED, "environment": {"intensity": 2}})
    np.testing.assert_allclose(colour(twice, tmp_path), [1.2, 0.2, 0.2], rtol=0.02)
    # Others are not there.
    assert frame(client, {"materials": {"floor": {"diffuse": [0, 0, 0]}}}).status_code == 422


def test_a_preset_tells_its_terms_and_error(client: httpx.Client) -> None:
    presets = client.get("/api/scenes/floor").json()["material_presets"]
    assert list(presets) == ["Matt", "Metals", "Plastics", "Wang et al. 2006"]
    paper = presets["Wang et al. 2006"]
    assert set(paper) == {"red Phong", "Ashikhmin-Shirley", "clay", "skin"}
    skin = {"floor": paper["skin"]}
    precompute(client, skin)
    (floor,) = materials(client, {"materials": skin})
    assert floor["description"]["type"] == "lafortune"
    assert (floor["terms"], floor["channels"]) == (4, 3)
    assert 0.1 < floor["error"] < 0.5
    (own,) = materials(client, {})
    assert own["description"]["type"] == "diffuse"


def test_a_method_that_takes_them_as_they_are_says_nothing(
    client: httpx.Client, tmp_path: Path
) -> None:
    precompute(client, RED, "direct_to_indirect")
    image = colour(frame(client, {"materials": RED}, "direct_to_indirect"), tmp_path)
    np.testing.assert_allclose(image, [0.6, 0.1, 0.1], rtol=0.02)
    answer = client.post("/api/scenes/floor/materials", json={"materials": RED})
    assert answer.json()[0]["error"] is None


@pytest.mark.parametrize(
    ("edits", "field"),
    [
        ({"materials": {"wall": {"diffuse": [0, 0, 0]}}}, "materials.wall"),
        ({"materials": {"floor": {"diffuse": [2, 0, 0]}}}, "materials.floor.diffuse.0"),
        ({"materials": {"floor": {"type": "velvet"}}}, "materials.floor.type"),
        ({"environment": {"intensity": 2}}, "edits.environment"),
    ],
)
def test_what_cannot_be_precomputed_is_told_at_once(
    client: httpx.Client, edits: Any, field: str
) -> None:
    wanted = {"method": "glossy_prt", "edits": edits}
    answer = client.post("/api/scenes/floor/precompute", json=wanted)
    assert (answer.status_code, answer.json()["field"]) == (422, field)
