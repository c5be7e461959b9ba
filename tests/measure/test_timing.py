"""Timings count what they say and nothing else."""

from __future__ import annotations

import time

from engine.measure.machine import memory_read_bandwidth, ray_rate, this_machine
from engine.measure.timing import PhaseClock, Timing, paired_ratio, repeat


def test_median_and_percentile() -> None:
    timing = Timing(tuple(float(k) for k in range(101)))
    assert timing.median == 50
    assert timing.p95 == 95


def test_warm_up_does_not_count() -> None:
    calls: list[int] = []

    def slow_at_first() -> None:
        calls.append(len(calls))
        time.sleep(0.2 if len(calls) == 1 else 0.001)

    timing = repeat(slow_at_first, count=4, warm_up=1)
    assert len(calls) == 5
    assert len(timing.seconds) == 4
    assert max(timing.seconds) < 0.19


def test_paired_ratio_of_sleeps() -> None:
    low, middle, high = paired_ratio(lambda: time.sleep(0.03), lambda: time.sleep(0.01), 6)
    assert low <= middle <= high
    assert 1.5 < middle < 4.5


def test_the_phase_clock_adds_up_and_passes_on() -> None:
    heard: list[tuple[str, float, float]] = []
    clock = PhaseClock(lambda *report: heard.append(report))
    clock("gather", 0, 2)
    time.sleep(0.02)
    clock("gather", 1, 2)
    clock("links", 0, 1)
    time.sleep(0.01)
    clock("gather", 1, 2)
    time.sleep(0.02)
    clock.stop()
    assert set(clock.seconds) == {"gather", "links"}
    assert clock.seconds["gather"] >= 0.04
    assert 0.01 <= clock.seconds["links"] < clock.seconds["gather"]
    assert [report[0] for report in heard] == ["gather", "gather", "links", "gather"]


def test_yardsticks_are_possible() -> None:
    assert 2e8 < memory_read_bandwidth(1) < 5e12
    assert 1e4 < ray_rate(1) < 1e10


def test_machine_facts_are_measured_once() -> None:
    machine = this_machine()
    assert machine.cpu
    assert machine.threads >= 1
    assert machine.as_dict()["packages"].keys() == {"numpy", "numba", "embreex"}
    assert machine is this_machine()
