"""The routes of speed and accuracy: a method's chart, and a frame beside its reference."""

from __future__ import annotations

import asyncio
from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Body, Query, Request, Response
from pydantic import TypeAdapter

from engine.errors import NotFound
from engine.images import encode
from engine.measure.front import Front, judged_by, known_front
from engine.methods import METHODS
from engine.scene.edits import Edits
from engine.store import Store
from server.compared import Compared
from server.jobs import API
from server.precompute import Task, settings_of
from server.problems import in_json
from server.routes import PROBLEMS, SETTINGS, service_of
from server.service import Service
from server.stage import METHOD, Stage
from server.wire import Chart, ChartPoint, Exposure, JobState, ReferenceResult, Shown
from server.worker import Order, view_of

Noise = Annotated[float, Query(ge=0.002, le=0.5, description="relative L2 error it may have")]
Seconds = Annotated[float, Query(ge=1, le=120, description="it may take, whatever its noise")]

router = APIRouter(responses=PROBLEMS)
