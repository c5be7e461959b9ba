"""`relight bench --service`: what the service adds to a frame, and how it does with many clients.

The service runs in a process of its own and its clients in this one, on the same machine. First the
product is precomputed, which is not measured; then the service is started anew.
"""

from __future__ import annotations

import asyncio
import http.client
import json
import math
import os
import statistics
import time
from collections.abc import Sequence
from typing import Any, get_args
from urllib.parse import urlsplit

import numpy as np
from websockets.sync.client import connect

from engine.errors import BackendError, InputError
from engine.methods.base import Progress, silent
from server.bench_load import Hand, Stop, Target, drag_together, header_of, stop
from server.bench_process import Process, service
from server.live import SILENT_SECONDS

CLIENTS = 16
BESIDE = 4  # clients beside the one that stops
FRAMES = 200  # of which transport is measured
STOP_SECONDS = SILENT_SECONDS + 10
SAMPLE_SECONDS = 0.25
RADIUS = 0.05  # of the circle that a hand draws, in diagonals of the scene


def bench(scene: str, seconds: float, progress: Progress = silent) -> dict[str, Any]:
    """All figures of the service, as a document; CLIENTS drag at once for some seconds.

    Products are those of the store, and go there.
    """
    with service(scene) as process:
        _precompute(process, progress)
    progress("starting again", 0, 1)
    with service(scene) as process:
        start = _first_pixels(process)
        target = _target(process)
        progress("transport", 0, 1)
        ways = {"socket": _by_socket, "request": _by_request}
        transport = {name: _transport(way(target)) for name, way in ways.items()}
        progress(f"{CLIENTS} clients for {seconds:g} s", 0, 1)
        clients = asyncio.run(_many(process, target, seconds))
        stopped = {}
        for k, how in enumerate(get_args(Stop)):
            progress("clients that stop", k, 3)
            stopped[how] = asyncio.run(_beside(process, target, how))
        progress("clients that stop", 3, 3)
    return {
        "scene": target.scene,
        "cores": os.cpu_count(),
        "start": start,
        "transport": transport,
        "clients": clients,
        "stopped": stopped,
    }


def _precompute(process: Process, progress: Progress) -> None:
    scene = _scene(process)
    job = process.ask(f"/api/scenes/{scene}/precompute", {})
    while job["status"] in ("queued", "running"):
        progress(job["phase"] or "precompute", job["fraction"], 1)
        time.sleep(SAMPLE_SECONDS)
        job = process.ask(f"/api/jobs/{job['id']}")
    if job["status"] != "done":
        raise BackendError(f"the precompute of {scene} {job['status']}")


def _scene(process: Process) -> str:
    """What the service calls the scene that it was started with."""
    (name,) = [each["name"] for each in process.ask("/api/scenes") if each["default"]]
    return str(name)


def _target(process: Process) -> Target:
    name = _scene(process)
    scene = process.ask(f"/api/scenes/{name}")
    placed = [light for light in scene["lights"] if light.get("position")]
    if not placed:
        raise InputError(f"{name} has no light that could be dragged")
    light = placed[-1]
    return Target(
        address=process.address,
        scene=name,
        light=light["id"],
        position=tuple(light["position"]),
        radius=RADIUS * scene["diagonal"],
    )


def _first_pixels(process: Process) -> dict[str, float]:
    """Seconds from the start of the process to its first frames."""
    listening = time.perf_counter() - process.started
    name = _scene(process)
    url = f"{process.address.replace('http', 'ws', 1)}/api/scenes/{name}/live"
    first = None
    with connect(url, compression=None, max_size=None) as socket:
        socket.send(json.dumps({"type": "edit", "seq": 1}))
        while True:
            data = socket.recv()
            if isinstance(data, str):
                continue
            now = time.perf_counter() - process.started
            first = first or now
            if header_of(data)["method"] != "direct":
                break
            socket.send(json.dumps({"type": "ack", "seq": 1}))
    seconds = {"listening": listening, "first_pixels": first, "with_product": now}
    return {name: round(value, 2) for name, value in seconds.items()}


def _by_socket(target: Target) -> list[tuple[float, dict[str, Any]]]:
    """(seconds from edit to frame, header) of one frame after the other, over the socket."""
    found = []
    with connect(target.live, compression=None, max_size=None) as socket:
        for _, message in zip(range(FRAMES), target.messages(1, 92), strict=False):
            start = time.perf_counter()
            socket.send(json.dumps(message))
            data = socket.recv()
            while isinstance(data, str):
                data = socket.recv()
            found.append((time.perf_counter() - start, header_of(data)))
            socket.send(json.dumps({"type": "ack", "seq": message["seq"]}))
    return found


def _by_request(target: Target) -> list[tuple[float, dict[str, Any]]]:
    """The same by POST, over a connection that is kept."""
    place = urlsplit(target.address)
    connection = http.client.HTTPConnection(place.hostname or "", place.port)
    headers = {"Content-Type": "application/json", "Accept": "image/jpeg"}
    found = []
    for k in range(FRAMES):
        body = json.dumps(target.edits(k / FRAMES))
        start = time.perf_counter()
        connection.request("POST", f"/api/scenes/{target.scene}/frame?quality=92", body, headers)
        answer = connection.getresponse()
        answer.read()
        seconds = time.perf_counter() - start
        if answer.status != 200:
            raise BackendError(f"a frame was answered with {answer.status}")
        found.append((seconds, json.loads(answer.headers["Relight-Frame"])))
    connection.close()
    return found


def _transport(frames: Sequence[tuple[float, dict[str, Any]]]) -> dict[str, float]:
    """Milliseconds of encoding and of all that is not drawing."""
    parts = "buffer", "relight"
    drawing = [sum(header["timings"][part] for part in parts) for _, header in frames]
    over = [1000 * seconds - drawn for (seconds, _), drawn in zip(frames, drawing, strict=True)]
    encoding = [header["timings"]["encode"] for _, header in frames]
    header = frames[-1][1]
    return {
        "width": header["width"],
        "height": header["height"],
        "frames": len(frames),
        "draw_median_ms": round(statistics.median(drawing), 2),
        "encode_median_ms": round(statistics.median(encoding), 2),
        "encode_p95_ms": round(_p95(encoding), 2),
        "over_median_ms": round(statistics.median(over), 2),
        "over_p95_ms": round(_p95(over), 2),
    }


async def _many(process: Process, target: Target, seconds: float) -> dict[str, Any]:
    """CLIENTS at once; the memory of the service while they drag."""
    watching = asyncio.create_task(_watch(process, seconds))
    hands = await drag_together(target, CLIENTS, seconds)
    memory = await watching
    frames = [hand.frames for hand in hands]
    waits = [wait for hand in hands for wait in hand.seconds]
    return {
        "seconds": seconds,
        "frames": frames,
        "per_second": round(sum(frames) / seconds, 1),
        "slowest_over_mean": round(min(frames) / statistics.mean(frames), 3),
        "answer_median_ms": round(1000 * statistics.median(waits), 1),
        "answer_p95_ms": round(1000 * _p95(waits), 1),
        "stale": sum(hand.stale for hand in hands),
        "errors": [error for hand in hands for error in hand.errors],
        **_of_memory(memory),
    }


async def _beside(process: Process, target: Target, how: Stop) -> dict[str, Any]:
    """Clients beside one that stops, and for as long without it."""
    alone = await drag_together(target, BESIDE, STOP_SECONDS)
    gone = asyncio.create_task(_until_gone(process, BESIDE + 1))
    watching = asyncio.create_task(_watch(process, STOP_SECONDS))
    stopped = asyncio.create_task(stop(target, how, STOP_SECONDS))
    hands = await drag_together(target, BESIDE, STOP_SECONDS)
    await stopped
    memory = await watching
    before, after = _rate(alone), _rate(hands)
    return {
        "dropped_after_s": await gone,
        "per_second": round(before, 1),
        "per_second_beside": round(after, 1),
        "stale": sum(hand.stale for hand in hands),
        "errors": [error for hand in hands for error in hand.errors],
        **_of_memory(memory),
    }


async def _until_gone(process: Process, sessions: int) -> float | None:
    """Seconds from when so many sessions are open until one of them is not; None where all stay."""
    since, end = math.inf, time.perf_counter() + STOP_SECONDS - 1
    while time.perf_counter() < end:
        now = await asyncio.to_thread(process.gauge, "sessions")
        if now >= sessions:
            since = min(since, time.perf_counter())
        elif since < math.inf:
            return round(time.perf_counter() - since, 1)
        await asyncio.sleep(SAMPLE_SECONDS)
    return None


def _rate(hands: Sequence[Hand]) -> float:
    """Frames a second of all."""
    return sum(hand.frames for hand in hands) / STOP_SECONDS


async def _watch(process: Process, seconds: float) -> list[tuple[float, float]]:
    """(seconds, MB) of the service's memory, while it is at work."""
    found, start = [], time.perf_counter()
    while (now := time.perf_counter() - start) < seconds:
        memory = process.memory()
        if memory is not None:
            found.append((now, memory))
        await asyncio.sleep(SAMPLE_SECONDS)
    return found


def _of_memory(samples: Sequence[tuple[float, float]]) -> dict[str, float | None]:
    """Memory at a quarter of the time, when all is warm, at its end, at its most, and its slope."""
    if len(samples) < 8:
        return dict.fromkeys(("memory_mb", "memory_end_mb", "memory_most_mb", "mb_per_minute"))
    warm = np.array(samples[len(samples) // 4 :])
    slope = np.polyfit(warm[:, 0], warm[:, 1], 1)[0]
    return {
        "memory_mb": round(float(warm[0, 1]), 1),
        "memory_end_mb": round(float(warm[-1, 1]), 1),
        "memory_most_mb": round(float(max(mb for _, mb in samples)), 1),
        "mb_per_minute": round(60 * float(slope), 2),
    }


def _p95(values: Sequence[float]) -> float:
    ordered = sorted(values)
    return ordered[math.ceil(0.95 * len(ordered)) - 1]
