"""Jobs: joined, watched, cancelled within a second."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import pytest

from engine.errors import NotFound, SceneError
from engine.methods.base import Progress
from engine.scene.camera import Camera
from server.jobs import MOST, Jobs
from server.precompute import Task
from server.problems import Busy
from server.wire import JobState


def task(x: float = 0.0) -> Task:
    camera = Camera(position=(x, 0, 1), target=(0, 0, 0))
    return Task(scene="box", source="box", camera=camera, method="direct_to_indirect")


class Clockwork:
    """Work that goes on until it is let go or stopped."""

    def __init__(self) -> None:
        self.go = threading.Event()
        self.begun: list[Task] = []

    def __call__(self, task: Task, progress: Progress) -> None:
        self.begun.append(task)
        done = 0.0
        while not self.go.is_set():
            progress("waiting", min(done, 90), 100)
            done += 1
            time.sleep(0.005)
        progress("ending", 50, 100)


@pytest.fixture
def work() -> Clockwork:
    return Clockwork()


@pytest.fixture
def jobs(work: Clockwork) -> Iterator[Jobs]:
    jobs = Jobs(work)
    yield jobs
    jobs.close()


def until(true: Callable[[], bool], seconds: float = 5.0) -> float:
    start = time.monotonic()
    while not true():
        assert time.monotonic() - start < seconds, "it never became true"
        time.sleep(0.005)
    return time.monotonic() - start


def test_runs_to_its_end_and_tells(jobs: Jobs, work: Clockwork) -> None:
    heard: list[JobState] = []
    jobs.listen(heard.append)
    job = jobs.start(task(), "a")
    until(lambda: jobs.get(job.id).fraction > 0.02)
    state = jobs.get(job.id)
    assert (state.status, state.phase) == ("running", "waiting")
    assert state.eta_seconds is not None
    assert state.eta_seconds > 0
    work.go.set()
    until(lambda: jobs.get(job.id).status == "done")
    assert jobs.get(job.id).fraction == 1
    statuses = [state.status for state in heard]
    assert statuses[0] == "running"
    assert statuses[-1] == "done"
    assert {state.phase for state in heard} >= {"waiting", "ending"}


def test_two_watchers_share_a_job(jobs: Jobs, work: Clockwork) -> None:
    first, second = jobs.start(task(), "a"), jobs.start(task(), "b")
    assert first.id == second.id
    until(lambda: len(work.begun) == 1)
    jobs.look_away("a")
    time.sleep(0.05)
    assert jobs.get(first.id).status == "running"
    jobs.look_away("b")
    assert until(lambda: jobs.get(first.id).status == "cancelled") < 1.0


def test_a_new_camera_stops_the_old_job(jobs: Jobs, work: Clockwork) -> None:
    old = jobs.start(task(0), "a")
    until(lambda: jobs.get(old.id).status == "running")
    new = jobs.start(task(1), "a")
    assert new.id != old.id
    until(lambda: jobs.get(new.id).status == "running", 1.0)
    assert jobs.get(old.id).status == "cancelled"
    # Nobody refused it: to look back starts it anew.
    assert jobs.refused(task(0)) is None


def test_a_job_asked_for_by_name_outlives_its_watchers(jobs: Jobs, work: Clockwork) -> None:
    job = jobs.start(task(0), "api")
    jobs.start(task(0), "a")
    jobs.start(task(1), "a")
    jobs.start(task(2), "api")
    jobs.look_away("a")
    time.sleep(0.05)
    work.go.set()
    until(lambda: jobs.get(job.id).status == "done")


def test_what_is_looked_at_goes_first(jobs: Jobs, work: Clockwork) -> None:
    unseen = jobs.start(task(0), "api")
    until(lambda: jobs.get(unseen.id).status == "running")
    also_unseen = jobs.start(task(1), "api")
    seen = jobs.start(task(2), "a")
    until(lambda: jobs.get(seen.id).status == "running", 1.0)
    assert jobs.get(unseen.id).status == jobs.get(also_unseen.id).status == "queued"
    work.go.set()
    until(lambda: jobs.get(also_unseen.id).status == "done")
    assert [t.camera.position[0] for t in work.begun] == [0, 2, 0, 1]


def test_products_go_before_charts_and_references(jobs: Jobs, work: Clockwork) -> None:
    chart = task(0).model_copy(update={"work": "front"})
    measured = jobs.start(chart, "api")
    until(lambda: jobs.get(measured.id).status == "running")
    wanted = jobs.start(task(1), "api")
    until(lambda: jobs.get(wanted.id).status == "running", 1.0)
    assert jobs.get(measured.id).status == "queued"
    work.go.set()
    until(lambda: jobs.get(measured.id).status == "done")
    assert work.begun == [chart, task(1), chart]


def test_no_more_wait_than_there_is_room_for(jobs: Jobs) -> None:
    for number in range(MOST):
        jobs.start(task(number), "api")
    assert jobs.start(task(3), "api")
    with pytest.raises(Busy):
        jobs.start(task(MOST), "api")


def test_one_who_looks_does_not_push_another_aside(jobs: Jobs, work: Clockwork) -> None:
    first = jobs.start(task(0), "a")
    until(lambda: jobs.get(first.id).status == "running")
    second = jobs.start(task(1), "b")
    time.sleep(0.05)
    assert jobs.get(first.id).status == "running"
    jobs.forget("a")  # nobody waits for it any more, and it is not given up
    until(lambda: jobs.get(second.id).status == "running", 1.0)
    assert jobs.get(first.id).status == "queued"
    work.go.set()
    until(lambda: jobs.get(first.id).status == "done")


def test_a_job_that_made_room_is_cancelled_at_once(jobs: Jobs, work: Clockwork) -> None:
    unseen = jobs.start(task(0), "api")
    until(lambda: jobs.get(unseen.id).status == "running")
    seen = jobs.start(task(1), "a")
    until(lambda: jobs.get(seen.id).status == "running")
    assert jobs.cancel(unseen.id).status == "cancelled"
    work.go.set()
    until(lambda: jobs.get(seen.id).status == "done")
    assert work.begun == [task(0), task(1)]


def test_a_client_that_leaves_stops_nothing(jobs: Jobs, work: Clockwork) -> None:
    job = jobs.start(task(), "a")
    jobs.forget("a")
    time.sleep(0.05)
    assert jobs.get(job.id).status in ("queued", "running")


def test_cancelled_on_request_within_a_second_and_not_begun_again(
    jobs: Jobs, work: Clockwork
) -> None:
    job = jobs.start(task(), "a")
    until(lambda: jobs.get(job.id).status == "running")
    jobs.cancel(job.id)
    assert until(lambda: jobs.get(job.id).status == "cancelled") < 1.0
    refused = jobs.refused(task())
    assert refused is not None
    assert refused.id == job.id
    assert jobs.start(task(), "api").id != job.id  # asked for by name it does


def test_a_queued_job_is_cancelled_at_once(jobs: Jobs, work: Clockwork) -> None:
    jobs.start(task(0), "api")
    queued = jobs.start(task(1), "api")
    assert queued.status == "queued"
    assert jobs.cancel(queued.id).status == "cancelled"
    work.go.set()
    time.sleep(0.05)
    assert task(1) not in work.begun


def test_a_failure_says_why() -> None:
    def fail(task: Task, progress: Progress) -> None:
        raise SceneError("too dark", field="lights")

    jobs = Jobs(fail)
    job = jobs.start(task(), "a")
    until(lambda: jobs.get(job.id).status == "failed")
    problem = jobs.get(job.id).problem
    assert problem is not None
    assert (problem.detail, problem.field) == ("too dark", "lights")
    assert jobs.refused(task()) is not None
    jobs.close()


def test_unknown_jobs(jobs: Jobs) -> None:
    with pytest.raises(NotFound):
        jobs.get("none")
