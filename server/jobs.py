"""Precomputes and other long work: one at a time, watched, cancelled within a second.

A job that was started because somebody looked is stopped when the last one looks elsewhere; a job
that was asked for by name (`watcher=API`) ends only by itself or by `cancel`. What somebody looks
at goes first, then other products, then charts and references: a job that is less urgent makes
room, and goes on later from what it has left in the store.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable
from typing import Any

from engine.errors import Cancelled, NotFound
from engine.methods.base import Progress
from server.precompute import Task
from server.problems import Busy, describe
from server.wire import JobState, JobStatus, Problem

API = "api"
KEPT = 100
MOST = 64  # that run or wait
PUBLISH_SECONDS = 0.1

Work = Callable[[Task, Progress], Any]
Listener = Callable[[JobState], None]


class Job:
    """One precompute; all changes go through `Jobs`, under its lock."""

    def __init__(self, task: Task) -> None:
        self.id = secrets.token_urlsafe(9)
        self.task = task
        self.watchers: set[str] = set()
        self.status: JobStatus = "queued"
        self.phase, self.fraction = "", 0.0
        self.started = self.ended = self.phase_started = 0.0
        self.stop = threading.Event()
        self.makes_room = False
        self.preview = False
        self.problem: Problem | None = None

    @property
    def active(self) -> bool:
        """Whether it still has work to do."""
        return self.status in ("queued", "running")

    @property
    def looked_at(self) -> bool:
        """Whether somebody waits for it before a picture."""
        return bool(self.watchers - {API})

    @property
    def rank(self) -> int:
        """0 is the most urgent."""
        return 0 if self.looked_at else 1 if self.task.work == "product" else 2

    def state(self) -> JobState:
        """As it crosses the wire."""
        now = self.ended or time.monotonic()
        return JobState(
            id=self.id,
            work=self.task.work,
            scene=self.task.scene,
            method=self.task.method,
            status=self.status,
            phase=self.phase,
            fraction=self.fraction,
            elapsed_seconds=round(now - self.started, 2) if self.started else 0.0,
            eta_seconds=self._eta(now),
            preview=self.preview,
            problem=self.problem,
        )

    def _eta(self, now: float) -> float | None:
        """Seconds left in this phase if it goes on at its mean pace so far."""
        if self.status != "running" or self.fraction < 0.02:
            return None
        return round((now - self.phase_started) * (1 - self.fraction) / self.fraction, 1)


class Jobs:
    """All jobs of the service."""

    def __init__(self, work: Work) -> None:
        """`work` does a task, reports to its progress, and stops when that raises."""
        self._work = work
        self._lock = threading.Condition()
        self._jobs: dict[str, Job] = {}
        self._listeners: list[Listener] = []
        self._closed = False
        self._thread = threading.Thread(target=self._serve, name="relight-job", daemon=True)
        self._thread.start()

    def start(self, task: Task, watcher: str) -> JobState:
        """Start the task, or join the job that is at it already; Busy where too many wait."""
        with self._lock:
            job = self._active(task)
            if job is None:
                if self.at_work >= MOST:
                    raise Busy(f"{MOST} jobs are waiting already")
                job = Job(task)
                self._jobs[job.id] = job
                self._forget_old()
            job.watchers.add(watcher)
            self._leave(watcher, job)
            self._make_room()
            return job.state()

    def look_away(self, watcher: str) -> None:
        """The watcher needs none of its jobs any more; those that nobody else watches stop."""
        with self._lock:
            self._leave(watcher, None)
            self._make_room()

    def forget(self, watcher: str) -> None:
        """The watcher is gone; its jobs go on, since it may come back."""
        with self._lock:
            for job in self._jobs.values():
                job.watchers.discard(watcher)
            self._make_room()

    def get(self, identity: str) -> JobState:
        """Raises NotFound."""
        return self._job(identity).state()

    def active(self, task: Task) -> JobState | None:
        """The job that is at this task."""
        with self._lock:
            job = self._active(task)
            return job.state() if job else None

    @property
    def at_work(self) -> int:
        """How many run or wait."""
        with self._lock:
            return sum(job.active for job in self._jobs.values())

    def refused(self, task: Task) -> JobState | None:
        """The last job for this task, if it failed or was cancelled by request."""
        with self._lock:
            ended = [job for job in self._jobs.values() if job.task.key == task.key]
            last = ended[-1] if ended else None
            refused = last and (
                last.status == "failed" or (last.status == "cancelled" and "" in last.watchers)
            )
            return last.state() if last and refused else None

    def cancel(self, identity: str) -> JobState:
        """Stop a job on request; NotFound where there is none."""
        with self._lock:
            job = self._job(identity)
            self._cancel(job)
            return job.state()

    def cancel_all(self, scene: str) -> None:
        """The same for all jobs of a scene."""
        with self._lock:
            for job in self._jobs.values():
                if job.task.scene == scene:
                    self._cancel(job)

    def previewed(self, task: Task) -> None:
        """There is a preview of what the task makes."""
        with self._lock:
            job = self._active(task)
            if job is not None and not job.preview:
                job.preview = True
                self._publish(job)

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Hear of every change, from any thread; returns how to stop hearing."""
        with self._lock:
            self._listeners.append(listener)

        def stop() -> None:
            with self._lock:
                self._listeners.remove(listener)

        return stop

    def close(self) -> None:
        """Stop everything and wait for it."""
        with self._lock:
            for job in self._jobs.values():
                if job.active:
                    self._stop(job)
            self._closed = True
            self._lock.notify_all()
        self._thread.join()

    def _job(self, identity: str) -> Job:
        try:
            return self._jobs[identity]
        except KeyError:
            raise NotFound("there is no such job; it may have ended long ago") from None

    def _active(self, task: Task) -> Job | None:
        for job in self._jobs.values():
            if job.active and not job.stop.is_set() and job.task == task:
                return job
        return None

    def _leave(self, watcher: str, current: Job | None) -> None:
        for job in list(self._jobs.values()):
            if job is not current and watcher in job.watchers and watcher != API:
                job.watchers.discard(watcher)
                if not job.watchers and job.active:
                    self._stop(job)

    def _make_room(self) -> None:
        """The running job waits while there is a more urgent one."""
        first = self._next()
        for job in self._jobs.values():
            job.makes_room = first is not None and job.status == "running" and first.rank < job.rank
        self._lock.notify_all()

    def _cancel(self, job: Job) -> None:
        if job.active:
            job.watchers = {""}  # nobody: it was stopped on purpose
            self._stop(job)

    def _stop(self, job: Job) -> None:
        job.stop.set()
        if job.status == "queued":
            self._end(job, "cancelled")

    def _forget_old(self) -> None:
        ended = [job.id for job in self._jobs.values() if not job.active]
        for identity in ended[: max(0, len(self._jobs) - KEPT)]:
            del self._jobs[identity]

    def _end(self, job: Job, status: JobStatus) -> None:
        job.status, job.ended = status, time.monotonic()
        self._publish(job)

    def _publish(self, job: Job) -> None:
        state = job.state()
        for listener in list(self._listeners):
            listener(state)

    def _serve(self) -> None:
        """The thread of the jobs: the most urgent first, then in order."""
        while True:
            with self._lock:
                self._lock.wait_for(lambda: self._closed or self._next() is not None)
                job = self._next()
                if job is None:
                    return
                job.status, job.started = "running", job.started or time.monotonic()
                job.phase, job.fraction = "", 0.0
                self._publish(job)
            self._run(job)

    def _next(self) -> Job | None:
        queued = [job for job in self._jobs.values() if job.status == "queued"]
        return min(queued, key=lambda job: job.rank, default=None)

    def _run(self, job: Job) -> None:
        published = 0.0

        def progress(phase: str, done: float, total: float) -> None:
            nonlocal published
            if job.stop.is_set() or job.makes_room:
                raise Cancelled("the precompute was stopped")
            with self._lock:
                changed = phase != job.phase
                if changed:
                    job.phase, job.phase_started = phase, time.monotonic()
                job.fraction = min(1.0, max(0.0, done / total)) if total > 0 else 0.0
                if changed or time.monotonic() - published > PUBLISH_SECONDS:
                    published = time.monotonic()
                    self._publish(job)

        try:
            self._work(job.task, progress)
        except Cancelled:
            status: JobStatus = "queued"
        except Exception as error:
            status, job.problem = "failed", describe(error)
        else:
            status, job.fraction = "done", 1.0
        with self._lock:
            if status != "queued" or job.stop.is_set():
                self._end(job, "cancelled" if status == "queued" else status)
            else:
                job.status, job.makes_room = status, False
                self._publish(job)
