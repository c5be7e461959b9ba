"""POST /api/scenes/{scene}/frame, and the routes around it."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
from fastapi import FastAPI
from httpx import Client, Response
from numpy.typing import NDArray
from PIL import Image

from engine.images import read_image
from server.app import MAX_BODY, create_app

Serving = Callable[[FastAPI], AbstractContextManager[str]]

FRAME = "/api/scenes/tiny-box/frame"
WIDTH, HEIGHT = 24, 18


def pixels(response: Response) -> NDArray[np.float64]:
    assert response.status_code == 200, response.text
    return np.asarray(Image.open(io.BytesIO(response.content)), np.float64)


def frame(
    client: Client, edits: object = None, accept: str = "image/png", **query: float | str
) -> Response:
    return client.post(FRAME, json=edits or {}, params=query, headers={"Accept": accept})


def test_lists_given_scenes_before_built_in_ones(client: Client) -> None:
    scenes = client.get("/api/scenes").json()
    assert scenes[0]["name"] == "tiny-box"
    assert [scene["default"] for scene in scenes] == [True] + [False] * (len(scenes) - 1)
    assert "cornell-box" in [scene["name"] for scene in scenes]


def test_describes_a_scene(client: Client) -> None:
    scene = client.get("/api/scenes/tiny-box").json()
    assert (scene["camera"]["width"], scene["camera"]["height"]) == (WIDTH, HEIGHT)
    assert [light["id"] for light in scene["lights"]] == ["ceiling", "key"]
    assert scene["light_types"]["spot"]["properties"]["cone_degrees"]["maximum"] == 90
    assert scene["methods"][0]["name"] == "direct_to_indirect"
    assert scene["methods"][0]["ready"] is False
    assert scene["methods"][0]["edits"] == ["environment", "lights"]
    assert scene["environment"]["description"] is None
    assert scene["environment"]["maps"] == ["studio"]
    assert scene["environment"]["sky"]["properties"]["turbidity"]["maximum"] == 10
    assert scene["environment"]["area_light"]["properties"]["radius_degrees"]["maximum"] == 45
    assert scene["material_presets"]["Wang et al. 2006"]["red Phong"]["exponent"] == 50
    assert "emission" not in scene["material_presets"]["Matt"]["plain diffuse"]
    assert scene["triangles"] == 30


@pytest.mark.parametrize(
    ("x", "y", "material"),
    [(0.2, 0.5, "red"), (0.8, 0.5, "green"), (0.5, 0.5, "tall block"), (0.01, 0.5, None)],
)
def test_tells_what_a_place_of_the_picture_shows(
    client: Client, x: float, y: float, material: str | None
) -> None:
    picked = client.post("/api/scenes/tiny-box/pick", params={"x": x, "y": y})
    assert (picked.status_code, picked.json()) == (200, {"material": material})


def test_picks_through_the_camera_of_the_edits(client: Client) -> None:
    scene = client.get("/api/scenes/tiny-box").json()["camera"]
    away = np.array(scene["position"]) * 2 - scene["target"]
    for target, material in ((scene["target"], "tall block"), (away.tolist(), None)):
        picked = client.post(
            "/api/scenes/tiny-box/pick",
            params={"x": 0.5, "y": 0.5},
            json={"camera": {"target": target}},
        )
        assert picked.json() == {"material": material}


def test_there_is_nothing_beside_the_picture(client: Client) -> None:
    beside = client.post("/api/scenes/tiny-box/pick", params={"x": 1.2, "y": 0.5})
    assert (beside.status_code, beside.json()["field"]) == (422, "x")
    assert client.post("/api/scenes/no/pick", params={"x": 0, "y": 0}).status_code == 404


@pytest.mark.parametrize("format", ["jpeg", "png", "webp"])
def test_draws_every_format(client: Client, format: str) -> None:
    response = frame(client, accept=f"image/{format}")
    assert response.headers["content-type"] == f"image/{format}"
    image = pixels(response)
    assert image.shape == (HEIGHT, WIDTH, 3)
    # The red wall is on the left, the green one on the right.
    left, right = image[:, :8].mean((0, 1)), image[:, -8:].mean((0, 1))
    assert left[0] > left[1] + 10
    assert right[1] > right[0] + 5


def test_exr_is_linear_and_agrees_with_png(client: Client, tmp_path: Path) -> None:
    response = frame(client, accept="image/x-exr")
    path = tmp_path / "frame.exr"
    path.write_bytes(response.content)
    linear = read_image(path)
    assert linear.shape == (HEIGHT, WIDTH, 3)
    shown = pixels(frame(client)) / 255
    decoded = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(decoded, np.clip(linear, 0, 1), atol=0.005)
    assert linear.max() > 1  # the lamp is seen, and not clipped


def test_scale_two_is_every_second_pixel(client: Client) -> None:
    assert pixels(frame(client, scale=2)).shape == (HEIGHT // 2, WIDTH // 2, 3)


def test_a_stop_of_exposure_doubles_the_light(client: Client) -> None:
    dark = pixels(frame(client, exposure=-1)) / 255
    light = pixels(frame(client, exposure=0)) / 255
    linear = [
        np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4) for x in (dark, light)
    ]
    unclipped = (light < 1).all(axis=2) & (dark > 0.08).all(axis=2)
    assert unclipped.sum() > 20
    np.testing.assert_allclose(linear[1][unclipped] / linear[0][unclipped], 2, rtol=0.08)


def test_lights_add_up(client: Client, tmp_path: Path) -> None:
    """Light is additive: both lights together are the sum of each alone."""

    def linear(*off: str) -> NDArray[np.float32]:
        edits = {"lights": [{"id": name, "enabled": False} for name in off]}
        path = tmp_path / "part.exr"
        path.write_bytes(frame(client, edits, accept="image/x-exr").content)
        return read_image(path)

    np.testing.assert_allclose(linear(), linear("key") + linear("ceiling"), rtol=1e-5, atol=1e-6)
    assert linear("key", "ceiling").max() == 0
    assert linear("key").max() > 0


def test_times_and_header_go_along(client: Client) -> None:
    response = frame(client)
    timing = dict(part.split(";dur=") for part in response.headers["server-timing"].split(", "))
    assert float(timing["total"]) > 0
    assert float(timing["relight"]) + float(timing["encode"]) <= float(timing["total"]) + 0.1
    header = json.loads(response.headers["relight-frame"])
    assert (header["width"], header["height"], header["method"]) == (WIDTH, HEIGHT, "direct")
    assert [warning["code"] for warning in header["warnings"]] == ["indirect_pending"]


@pytest.mark.parametrize(
    ("edits", "field"),
    [
        ({"lights": [{"id": "key", "intensity": [1, "much", 1]}]}, "lights.0.intensity.1"),
        ({"lights": [{"id": "key", "intensity": [1, -1, 1]}]}, "lights.0.intensity.1"),
        ({"lights": [{"id": "key", "colour": [1, 1, 1]}]}, "lights.0.colour"),
        ({"lights": [{"position": [0, 0, 0]}]}, "lights.0.id"),
        ({"lights": [{"id": "new", "type": "laser"}]}, "lights.0.type"),
        ({"lights": {"id": "key"}}, "lights"),
        ({"lamps": []}, "lamps"),
        ({"camera": {"fov_y_degrees": 0}}, "camera.fov_y_degrees"),
        ({"camera": {"width": 100000}}, "camera.width"),
        ({"materials": {"white": {"diffuse": [0, 0, 0]}}}, "materials"),
    ],
)
def test_bad_edits_name_their_field(client: Client, edits: object, field: str) -> None:
    response = frame(client, edits)
    assert response.status_code == 422
    assert response.headers["content-type"] == "application/problem+json"
    problem = response.json()
    assert problem["field"] == field
    assert problem["status"] == 422
    assert problem["detail"]


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
@pytest.mark.parametrize("place", ["lights", "camera"])
def test_refuses_numbers_that_are_none(client: Client, number: str, place: str) -> None:
    body = {
        "lights": f'{{"lights": [{{"id": "key", "position": [0, {number}, 0]}}]}}',
        "camera": f'{{"camera": {{"fov_y_degrees": {number}}}}}',
    }[place]
    response = client.post(FRAME, content=body, headers={"Content-Type": "application/json"})
    assert response.status_code == 422
    assert response.json()["field"].startswith(place)


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ({"scale": 0}, "scale"),
        ({"scale": 99}, "scale"),
        ({"exposure": "nan"}, "exposure"),
        ({"exposure": 1e9}, "exposure"),
        ({"quality": 101}, "quality"),
    ],
)
def test_bad_parameters_name_themselves(client: Client, query: dict[str, str], field: str) -> None:
    response = client.post(FRAME, json={}, params=query)
    assert (response.status_code, response.json()["field"]) == (422, field)


@pytest.mark.parametrize(
    ("body", "kind", "status", "words"),
    [
        (b"{", "application/json", 400, "not valid JSON"),
        (b"{}", "text/plain", 422, "application/json"),
        (b'{"lights": ' + b"[" * 100_000, "application/json", 400, ""),
        (b'{"lights": "' + b"x" * MAX_BODY + b'"}', "application/json", 413, "bytes"),
    ],
)
def test_bodies_that_cannot_be_read(
    client: Client, body: bytes, kind: str, status: int, words: str
) -> None:
    response = client.post(FRAME, content=body, headers={"Content-Type": kind})
    assert response.status_code == status
    assert words in response.json()["detail"]


def test_a_large_body_without_a_length_is_refused_too(client: Client) -> None:
    parts = (b" " * 65536 for _ in range(MAX_BODY // 65536 + 1))
    response = client.post(FRAME, content=parts, headers={"Content-Type": "application/json"})
    assert response.status_code == 413


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/api/scenes/none", 404),
        ("POST", "/api/scenes/none/frame", 404),
        ("POST", "/api/scenes/none/precompute", 404),
        ("GET", "/api/scenes/%2e%2e%2fetc", 404),
        ("GET", "/api/jobs/none", 404),
        ("GET", "/api/jobs/none/events", 404),
        ("DELETE", "/api/jobs/none", 404),
        ("GET", "/nothing.js", 404),
        ("GET", "/..%2f..%2fetc/passwd", 404),
        ("PUT", "/api/scenes", 405),
    ],
)
def test_unknown_things_are_problems(client: Client, method: str, path: str, status: int) -> None:
    response = client.request(method, path)
    assert response.status_code == status
    assert response.json()["status"] == status


def test_unacceptable_format(client: Client) -> None:
    response = frame(client, accept="image/gif")
    assert (response.status_code, response.json()["status"]) == (406, 406)


def test_the_page_may_reach_no_other_host(client: Client) -> None:
    page = client.get("/")
    assert "<canvas" in page.text
    assert "default-src 'none'" in page.headers["content-security-policy"]
    assert client.get("/main.js").headers["content-type"].startswith("text/javascript")
    assert client.get("/healthz").json() == {"status": "ok"}


def test_a_scene_that_cannot_be_opened_says_why(tmp_path: Path, serving: Serving) -> None:
    path = tmp_path / "broken.json"
    path.write_text('{"objects": 3}')
    with serving(create_app([str(path)])) as address, Client(base_url=address) as client:
        response = client.get("/api/scenes/broken")
        assert response.status_code == 422
        assert response.json()["file"] == "broken.json"
        assert str(tmp_path) not in response.text
        assert client.post("/api/scenes/broken/frame", json={}).status_code == 422


def test_another_method_by_name(
    tiny_scene: Path, serving: Serving, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Until its product is there light is direct; then any camera is drawn by it."""
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path))
    app = create_app([str(tiny_scene)], precompute_at_start=False)
    with serving(app) as address, Client(base_url=address, timeout=120) as client:
        settings = {"light_texels": 16, "visibility_texels": 16, "bounces": 0}
        wanted = {"method": "glossy_prt", "settings": settings}
        job = client.post("/api/scenes/tiny-box/precompute", json=wanted).json()
        while client.get(f"/api/jobs/{job['id']}").json()["status"] in ("queued", "running"):
            time.sleep(0.2)
        edits = {"environment": {"map": [1, 1, 1]}, "camera": {"position": [0.3, 0.3, -0.7]}}
        response = frame(client, edits, method="glossy_prt")
        header = json.loads(response.headers["relight-frame"])
        assert header["method"] == "glossy_prt"
        assert header["job"] is None
        assert pixels(response).max() > 0
        refused = frame(client, {"lights": [{"id": "key", "enabled": False}]}, method="glossy_prt")
        assert refused.status_code == 422
        assert frame(client, method="nonsense").status_code == 404
