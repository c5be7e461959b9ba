"""The routes of speed and accuracy: a method's chart, and a frame beside its reference."""

from __future__ import annotations

import asyncio
from typing import Annotated

from fastapi import APIRouter, Body, Query, Request, Response

from engine.errors import NotFound
from engine.images import encode
from engine.scene.edits import Edits
from server.compared import Compared
from server.problems import in_json
from server.routes import PROBLEMS, SETTINGS, service_of
from server.stage import METHOD
from server.wire import Chart, Exposure, JobState, ReferenceResult, Shown
from server.worker import Order

Noise = Annotated[float, Query(ge=0.002, le=0.5, description="relative L2 error it may have")]
Seconds = Annotated[float, Query(ge=1, le=120, description="it may take, whatever its noise")]

router = APIRouter(responses=PROBLEMS)


@router.get("/api/scenes/{scene}/chart")
async def chart(request: Request, scene: str, method: Annotated[str, Query()] = METHOD) -> Chart:
    """What a method's settings cost on a scene; no points until POST had them measured."""
    service = service_of(request)
    return await asyncio.to_thread(service.chart, service.stages.get(scene), method)


@router.post("/api/scenes/{scene}/chart", status_code=202)
async def measure(
    request: Request, response: Response, scene: str, method: Annotated[str, Query()] = METHOD
) -> JobState:
    """Measure the chart, or join the job that is at it."""
    service = service_of(request)
    job = await asyncio.to_thread(service.measure, service.stages.get(scene), method)
    response.headers["Location"] = f"/api/jobs/{job.id}"
    return job


@router.post("/api/scenes/{scene}/reference", status_code=202)
async def reference(
    request: Request,
    response: Response,
    scene: str,
    edits: Annotated[Edits, Body()] = Edits(),  # noqa: B008 - frozen
    method: Annotated[str, Query()] = METHOD,
    settings: Annotated[str, Query(description="in JSON, see MethodState")] = "{}",
    noise: Noise = 0.02,
    seconds: Seconds = 30,
) -> JobState:
    """Draw the scene under the edits, and have it path-traced beside."""
    service = service_of(request)
    stage = service.stages.get(scene)
    order = Order(
        edits=service.located(edits, stage),
        exposure=0.0,
        scale=1,
        format="exr",
        quality=100,
        method=method,
        settings=in_json(SETTINGS, settings, "settings"),
    )
    job = await service.compare(stage, order, noise, seconds)
    response.headers["Location"] = f"/api/jobs/{job.id}"
    return job


@router.get("/api/jobs/{job}/reference")
async def reference_result(
    request: Request, job: str, exposure: Annotated[Exposure, Query()] = 0.0
) -> ReferenceResult:
    """How far the frame is off, once the job is done."""
    return await asyncio.to_thread(_compared(request, job).result, exposure)


@router.get(
    "/api/jobs/{job}/reference/{which}",
    response_class=Response,
    responses={200: {"content": {"image/png": {}}}},
)
async def reference_picture(
    request: Request, job: str, which: Shown, exposure: Annotated[Exposure, Query()] = 0.0
) -> Response:
    """The frame, its reference, or their difference in false colour."""
    image = await asyncio.to_thread(_compared(request, job).picture, which, exposure)
    return Response(encode(image, "png"), media_type="image/png")


def _compared(request: Request, job: str) -> Compared:
    found = service_of(request).compared.get(job)
    if found is None:
        raise NotFound("there is no such reference; it may have been asked for long ago")
    return found
