"""Wall-clock time by stage."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

STAGES = ("meshing", "search", "assembly", "factorisation", "krylov", "post-processing")


class StageTimer:
    """Seconds spent in each named stage of a run.

    Parameters
    ----------
    listener
        Called with the name of each stage as it begins, e.g. to show progress.
    """

    def __init__(self, listener: Callable[[str], None] | None = None) -> None:
        self.seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._listener = listener

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time a block as part of ``stage``; blocks of one stage add up."""
        if self._listener is not None:
            self._listener(stage)
        start = perf_counter()
        try:
            yield
        finally:
            self.add(stage, perf_counter() - start)

    def add(self, stage: str, seconds: float) -> None:
        """Count ``seconds`` towards ``stage``."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + seconds

    @property
    def total(self) -> float:
        """Sum over all stages (s)."""
        return sum(self.seconds.values())
