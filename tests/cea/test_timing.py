"""Stages are timed by the clock and by the processor."""

from time import sleep

import pytest

from cea.timing import StageTimer


def test_waiting_counts_for_the_clock_alone():
    timer = StageTimer()
    with timer("search"):
        sleep(0.2)
    with timer("search"):
        pass
    assert timer.seconds["search"] >= 0.2
    assert timer.processor_seconds["search"] < 0.1
    assert timer.total == pytest.approx(timer.seconds["search"])
