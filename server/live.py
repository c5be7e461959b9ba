"""The live socket: edits in, frames out, the newest edit wins.

A session holds the newest edit only. Its frame is drawn when the render thread comes to it, from
the edit that is newest at that moment. No more than two frames are under way: drawn or sent, and
not yet acknowledged. When a better product for the view arrives, the last edit is drawn again.

A client that stops reading is dropped: one that leaves a frame unacknowledged for SILENT_SECONDS,
and one that nothing can be sent to for so long, whatever it acknowledges.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import time
from collections import deque

from fastapi import WebSocket, WebSocketDisconnect
from pydantic import TypeAdapter, ValidationError

from engine.errors import Cancelled, InputError
from engine.methods.interrupt import interruptible
from server.problems import describe, invalid
from server.service import Service, with_job
from server.stage import Stage
from server.wire import JobState, LiveAck, LiveEdit, LiveJob, LiveMessage, LiveProblem
from server.worker import Drawn, Order, draw

IN_FLIGHT = 2
SILENT_SECONDS = 15.0
CLOSE_SECONDS = 1.0

_MESSAGE: TypeAdapter[LiveEdit | LiveAck] = TypeAdapter(LiveMessage)


class Session:
    """One client of the live socket."""

    def __init__(self, service: Service, stage: Stage, socket: WebSocket) -> None:
        self.service, self.stage, self.socket = service, stage, socket
        self.id = secrets.token_urlsafe(9)
        self._loop = asyncio.get_running_loop()
        self._changed = asyncio.Event()
        self._send_lock = asyncio.Lock()
        self._edit: LiveEdit | None = None
        self._came = self._since = 0.0  # when a frame was last asked for, and that drawn last was
        self._job: JobState | None = None
        self._dirty = False
        self._stopped = False  # whether the last picture was given up for a newer one
        self._unacknowledged: deque[float] = deque()  # when those frames were handed to the socket

    async def run(self) -> None:
        """Serve until the client leaves."""
        stop = self.service.jobs.listen(self._job_moved)
        self.service.sessions += 1
        parts = self._read(), self._write(), self._silence()
        tasks = {asyncio.create_task(part) for part in parts}
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            stop()
            self.service.sessions -= 1
            self.service.jobs.forget(self.id)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        for task in done:
            error = task.exception()
            if error is not None and not isinstance(error, WebSocketDisconnect | TimeoutError):
                raise error
        with contextlib.suppress(RuntimeError, WebSocketDisconnect, TimeoutError):
            await asyncio.wait_for(self.socket.close(), CLOSE_SECONDS)

    async def _read(self) -> None:
        while True:
            text = await self.socket.receive_text()
            try:
                message = _MESSAGE.validate_json(text)
            except ValidationError as error:
                await self._send_problem(-1, invalid(error, skip=("edit", "ack")))
                continue
            if isinstance(message, LiveAck):
                if self._unacknowledged:
                    self._unacknowledged.popleft()
            elif self._edit is None or message.seq >= self._edit.seq:
                self._edit, self._came, self._dirty = message, time.perf_counter(), True
            self._changed.set()

    async def _write(self) -> None:
        while True:
            # Wait for something to draw, and for room for it.
            if not self._dirty or len(self._unacknowledged) >= IN_FLIGHT:
                await self._wait()
                continue
            seq = self._edit.seq if self._edit else -1
            try:
                await asyncio.to_thread(self.stage.scene)
                if self._edit is not None:
                    await self.service.acquire(self.stage, self._edit.edits)
                drawn = await self.service.worker.run(self._draw, always=True)
            except Cancelled:
                self._stopped = True
                continue  # to the newer edit
            except Exception as error:
                self._dirty = self._edit is not None and self._edit.seq > seq
                await self._send_problem(seq, error)
                continue
            self._unacknowledged.append(time.monotonic())
            await self._send_frame(drawn)
            self.service.metrics.frame(drawn.header, "live", time.perf_counter() - self._since)
            # The job may have ended before this session knew that it waits for it.
            if self._job is not None:
                await self._job_told(self.service.jobs.get(self._job.id))

    async def _silence(self) -> None:
        """Ends once the oldest frame has not been acknowledged for too long."""
        while True:
            now = time.monotonic()
            since = self._unacknowledged[0] if self._unacknowledged else now
            if now - since >= SILENT_SECONDS:
                return
            await asyncio.sleep(since + SILENT_SECONDS - now)

    async def _wait(self) -> None:
        await self._changed.wait()
        self._changed.clear()

    def _draw(self) -> Drawn:
        """In the render thread: the newest edit, whichever it is by now."""
        self._dirty = False  # before the edit is read: one that comes in between counts as new
        edit, self._since = self._edit, self._came
        assert edit is not None
        # A view is prepared once the hand rests, not for every camera on the way.
        if edit.scale == 1:
            self._job = self.service.look(self.stage, edit.edits, self.id, edit.method)
        order = Order(
            edits=self.service.located(edit.edits, self.stage),
            exposure=edit.exposure,
            scale=edit.scale,
            format=edit.format,
            quality=edit.quality,
            seq=edit.seq,
            method=edit.method,
            settings=edit.settings,
        )
        # Once in a row, so that a client who asks for nothing but whole pictures gets some.
        may_stop, self._stopped = not self._stopped, False
        with interruptible(lambda: may_stop and self._has_moved_on(edit)):
            return with_job(draw(self.stage, order), self._job)

    def _has_moved_on(self, edit: LiveEdit) -> bool:
        """Whether a frame would show what is edited no longer; a small one is done soon enough."""
        now = self._edit
        return edit.scale == 1 and now is not None and now.edits != edit.edits

    def _job_moved(self, state: JobState) -> None:
        """From the job's thread."""
        with contextlib.suppress(RuntimeError):  # the loop is closed when the service ends
            asyncio.run_coroutine_threadsafe(self._job_told(state), self._loop)

    async def _job_told(self, state: JobState) -> None:
        if self._job is None or state.id != self._job.id:
            return
        done = state.status == "done"
        if done or (state.preview and not self._job.preview):
            self._came, self._dirty = time.perf_counter(), True
            self._changed.set()
        self._job = None if done else state
        await self._send_text(LiveJob(job=state).model_dump_json())

    async def _send_problem(self, seq: int, error: Exception) -> None:
        problem = describe(error)
        self.service.metrics.problem(problem.status)
        if isinstance(error, InputError) and problem.field:
            problem = problem.model_copy(update={"field": problem.field.removeprefix("edits.")})
        await self._send_text(LiveProblem(seq=seq, problem=problem).model_dump_json())

    async def _send_text(self, text: str) -> None:
        async with self._send_lock:
            await asyncio.wait_for(self.socket.send_text(text), SILENT_SECONDS)

    async def _send_frame(self, drawn: Drawn) -> None:
        header = drawn.header.model_dump_json().encode()
        message = len(header).to_bytes(4, "little") + header + drawn.image
        async with self._send_lock:
            await asyncio.wait_for(self.socket.send_bytes(message), SILENT_SECONDS)
