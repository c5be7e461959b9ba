"""The route of measured materials' thumbnails."""

from __future__ import annotations

import asyncio
from typing import Annotated

from fastapi import APIRouter, Header, Query, Request, Response
from pydantic import TypeAdapter

from engine.brdf.base import Material
from engine.brdf.measured import Measured
from engine.brdf.table import AnyMaterial
from server.measured import file_of
from server.problems import in_json
from server.routes import PROBLEMS, service_of

MATERIAL: TypeAdapter[Material] = TypeAdapter(AnyMaterial)

router = APIRouter(responses=PROBLEMS)


@router.get(
    "/api/scenes/{scene}/materials/thumbnail",
    response_class=Response,
    responses={200: {"content": {"image/png": {}}}, 304: {}},
)
async def material_thumbnail(
    request: Request,
    scene: str,
    material: Annotated[str, Query(description="as in a scene, in JSON")],
    if_none_match: Annotated[str, Header()] = "",
) -> Response:
    """A ball of a material in the light of lamps; a file is read and encoded the first time."""
    service = service_of(request)
    stage = service.stages.get(scene)
    wanted = in_json(MATERIAL, material, "material")
    await asyncio.to_thread(stage.scene)
    if isinstance(wanted, Measured):
        file = file_of(wanted.file, stage, service.samples, "material.file")
        wanted = wanted.model_copy(update={"file": file})
    tag, data = await service.reader.thumbnail(stage, wanted)
    # A file may be another the next time it is asked for.
    headers = {"ETag": f'"{tag}"', "Cache-Control": "no-cache"}
    if f'"{tag}"' in if_none_match:
        return Response(status_code=304, headers=headers)
    return Response(data, media_type="image/png", headers=headers)
