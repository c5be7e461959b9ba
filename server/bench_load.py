"""Clients of the live socket for `relight bench --service`: hands that drag, and some that stop."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal
from urllib.parse import urlsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.client import ClientProtocol
from websockets.exceptions import ConnectionClosed
from websockets.uri import parse_uri

PERIOD_SECONDS = 2.0  # of a circle that the hand draws
EVENT_SECONDS = 1 / 60  # between two moves of the hand
KEPT = 256  # edits whose time is remembered

Stop = Literal["reading", "reading, and acknowledges all", "acknowledging"]


@dataclass(frozen=True)
class Target:
    """What is dragged: a light of a scene, around where it stands."""

    address: str
    scene: str
    light: str
    position: tuple[float, float, float]
    radius: float

    @property
    def live(self) -> str:
        """Where the live socket is."""
        return f"{self.address.replace('http', 'ws', 1)}/api/scenes/{self.scene}/live"

    def edits(self, phase: float) -> dict[str, Any]:
        """The light on its circle, phase in turns."""
        x, y, z = self.position
        angle = 2 * math.pi * phase
        place = [x + self.radius * math.sin(angle), y, z + self.radius * math.cos(angle)]
        return {"lights": [{"id": self.light, "position": place}]}

    def messages(self, scale: int, quality: int, phase: float = 0.0) -> Iterator[dict[str, Any]]:
        """What a page sends for one move after the other."""
        for seq in itertools.count(1):
            turns = phase + seq * EVENT_SECONDS / PERIOD_SECONDS
            yield {
                "type": "edit", "seq": seq, "edits": self.edits(turns), "scale": scale,
                "quality": quality,
            }  # fmt: skip


@dataclass
class Hand:
    """What a client that drags has seen.

    seconds  from an edit to its frame, for each frame
    stale    frames that came after one of a newer edit
    """

    frames: int = 0
    stale: int = 0
    seconds: list[float] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)


def header_of(data: bytes) -> dict[str, Any]:
    """The header of a binary message."""
    length = int.from_bytes(data[:4], "little")
    header: dict[str, Any] = json.loads(data[4 : 4 + length])
    return header


async def drag(target: Target, seconds: float, scale: int = 2, phase: float = 0.0) -> Hand:
    """Drag as the page does: an edit for every move, of which the service draws the newest."""
    hand, sent = Hand(), dict[int, float]()
    end = time.perf_counter() + seconds

    async def move(socket: ClientConnection) -> None:
        for message in target.messages(scale, 80, phase):
            if time.perf_counter() > end:
                return
            sent[message["seq"]] = time.perf_counter()
            sent.pop(message["seq"] - KEPT, None)
            await socket.send(json.dumps(message))
            await asyncio.sleep(EVENT_SECONDS)

    async def look(socket: ClientConnection) -> None:
        newest = -1
        async for data in socket:
            now = time.perf_counter()
            if isinstance(data, str):
                message = json.loads(data)
                if message["type"] == "problem":
                    hand.errors.append(message["problem"]["detail"])
                continue
            seq = header_of(data)["seq"]
            await socket.send(json.dumps({"type": "ack", "seq": seq}))
            hand.frames += 1
            hand.stale += seq < newest
            newest = max(newest, seq)
            if seq in sent:
                hand.seconds.append(now - sent[seq])

    try:
        async with connect(target.live, compression=None, max_size=None) as socket:
            looking = asyncio.create_task(look(socket))
            await move(socket)
            looking.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await looking
    except (ConnectionClosed, OSError) as error:
        hand.errors.append(str(error))
    return hand


async def drag_together(target: Target, clients: int, seconds: float) -> list[Hand]:
    """So many at once, each somewhere else on the circle."""
    return await asyncio.gather(*(drag(target, seconds, 2, k / clients) for k in range(clients)))


async def stop(target: Target, how: Stop, seconds: float) -> None:
    """A client that goes on dragging and has stopped something else; until it is cut off.

    Its socket has no client library that would read for it, or answer pings.
    """
    uri = parse_uri(target.live)
    protocol = ClientProtocol(uri)
    reader, writer = await asyncio.open_connection(urlsplit(target.live).hostname, uri.port)
    protocol.send_request(protocol.connect())
    writer.writelines(protocol.data_to_send())
    protocol.receive_data(await reader.readuntil(b"\r\n\r\n"))
    assert protocol.handshake_exc is None, protocol.handshake_exc
    reading = asyncio.create_task(_read_on(reader)) if how == "acknowledging" else None
    if reading is None:
        writer.transport.pause_reading()  # type: ignore[attr-defined]
    end = time.perf_counter() + seconds
    try:
        for message in target.messages(1, 92):
            if time.perf_counter() > end:
                return
            protocol.send_text(json.dumps(message).encode())
            if how == "reading, and acknowledges all":
                protocol.send_text(json.dumps({"type": "ack", "seq": message["seq"]}).encode())
            writer.writelines(protocol.data_to_send())
            await writer.drain()
            await asyncio.sleep(EVENT_SECONDS)
    except OSError:
        return  # cut off
    finally:
        if reading is not None:
            reading.cancel()
        writer.transport.abort()


async def _read_on(reader: asyncio.StreamReader) -> None:
    with contextlib.suppress(OSError):
        while await reader.read(1 << 20):
            pass
