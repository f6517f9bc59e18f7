"""Stages are timed by the clock and by the processor."""

from time import perf_counter, sleep

import pytest

from cea.timing import STAGES, StageTimer


def test_waiting_counts_for_the_clock_alone():
    timer = StageTimer()
    with timer("search"):
        sleep(0.2)
    with timer("search"):
        pass
    assert timer.seconds["search"] >= 0.2
    assert timer.processor_seconds["search"] < 0.1
    assert timer.total == pytest.approx(timer.seconds["search"])


def test_work_counts_for_both_under_its_stage():
    told = []
    timer = StageTimer(told.append)
    with timer("krylov"):
        end = perf_counter() + 0.1
        while perf_counter() < end:
            pass
    assert 0 < timer.processor_seconds["krylov"] <= timer.seconds["krylov"] + 0.02
    assert [s for s in STAGES if timer.processor_seconds[s]] == told == ["krylov"]
