"""Wall clock and processor time by stage."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter, process_time

STAGES = ("meshing", "search", "assembly", "factorisation", "krylov", "post-processing")


class StageTimer:
    """Wall clock seconds, and processor seconds of this process, by stage of a run.

    ``listener`` is called with the name of each stage when it begins, to report progress.
    """

    def __init__(self, listener: Callable[[str], None] | None = None) -> None:
        self.seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self.processor_seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._listener = listener

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the time of a block to ``stage``."""
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
        """Add wall clock seconds to a stage."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + seconds

    @property
    def total(self) -> float:
        """Wall clock seconds of all stages."""
        return sum(self.seconds.values())
