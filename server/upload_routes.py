"""The routes by which files are sent in: scenes, environment maps, measured materials.

The body is the file as it is; the query says what it is called.
"""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from server.details import scene_summary
from server.routes import PROBLEM, PROBLEMS, service_of
from server.wire import MapSummary, MeasuredSent, SceneSummary

FileName = Annotated[str, Query(max_length=256, description="of the file")]

_BUSY = {**PROBLEM, "headers": {"Retry-After": {"schema": {"type": "integer"}}}}
_REFUSED: dict[int | str, dict[str, Any]] = {**PROBLEMS, 413: PROBLEM, 503: _BUSY}
_FILE = {"schema": {"type": "string", "format": "binary"}}
_BODY = {"requestBody": {"required": True, "content": {"application/octet-stream": _FILE}}}

router = APIRouter(responses=_REFUSED)


@router.post("/api/scenes", status_code=201, responses={415: PROBLEM}, openapi_extra=_BODY)
async def send_scene(request: Request, response: Response, name: FileName = "") -> SceneSummary:
    """Keep a scene: the bytes of a .glb, .gltf, .obj, .ply, .stl or .zip file, as they are.

    A glTF file has its buffers in itself. A zip has a scene.json and what it names, or one mesh
    file with its materials, textures and buffers.
    """
    service = service_of(request)
    stage = await service.sent.add(request.stream(), name)
    response.headers["Location"] = f"/api/scenes/{stage.name}"
    return scene_summary(stage, service.stages)


@router.delete("/api/scenes/{scene}", status_code=204, responses={403: PROBLEM})
async def remove_scene(request: Request, scene: str) -> None:
    """Forget a scene that was sent, and stop the jobs that are at it."""
    await service_of(request).sent.remove(scene)


@router.post("/api/maps", status_code=201, openapi_extra=_BODY)
async def send_map(request: Request, name: FileName = "") -> MapSummary:
    """Keep an environment map: the bytes of an OpenEXR or Radiance HDR file, as they are."""
    return await service_of(request).uploads.add(request.stream(), name)


@router.post("/api/measured", status_code=201, openapi_extra=_BODY)
async def send_measured(request: Request, name: FileName = "") -> MeasuredSent:
    """Keep a measured material: the bytes of a .brdf, .binary or .csv file, as they are."""
    return await service_of(request).samples.add(request.stream(), name)
