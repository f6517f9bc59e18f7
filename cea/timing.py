"""Time by stage: of the clock, and of the processor."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter, process_time

STAGES = ("meshing", "search", "assembly", "factorisation", "krylov", "post-processing")


class StageTimer:
    """Seconds of the clock, and of the processor for this process, spent in named stages of a run.

    The listener is called with the name of each stage as it begins, to show progress.
    """

    def __init__(self, listener: Callable[[str], None] | None = None) -> None:
        self.seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self.processor_seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._listener = listener

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time a block as part of ``stage``; blocks of one stage add up."""
        if self._listener is not None:
            self._listener(stage)
        start, worked = perf_counter(), process_time()
        try:
            yield
        finally:
            self.add(stage, perf_counter() - start)
            before = self.processor_seconds.get(stage, 0.0)
            self.processor_seconds[stage] = before + process_time() - worked

    def add(self, stage: str, seconds: float) -> None:
        """Count seconds of the clock towards a stage."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + seconds

    @property
    def total(self) -> float:
        """Sum of the clock's seconds over all stages."""
        return sum(self.seconds.values())
