"""Run times of a study: seconds by stage, summed over its runs."""

from collections.abc import Iterable, Mapping

from cea.timing import StageTimer


def summed(timings: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Seconds by stage, summed over runs."""
    total = StageTimer()
    for seconds in timings:
        for stage, each in seconds.items():
            total.add(stage, each)
    return dict(total.seconds)
