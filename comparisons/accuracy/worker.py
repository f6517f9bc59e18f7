"""Cases measured in a process of their own."""

from collections.abc import Callable
from typing import Any

from cea.arrays import Complexes
from comparisons.accuracy.study import Case
from comparisons.kit.worker import Worker


class CaseWorker(Worker):
    """Measures cases in another process, begun anew whenever it has died.

    Parameters
    ----------
    make
        Makes what measures, in that process; a function of a module.
    """

    def __init__(self, make: Callable[[], Callable[..., dict[str, Any]]] | None = None) -> None:
        super().__init__(make or _measurer)

    def measure(self, case: Case, exact: Complexes, repeats: int, seconds: float) -> dict[str, Any]:
        """Measure a case.

        Parameters
        ----------
        case, exact, repeats
            See :meth:`comparisons.accuracy.measure.Measurer.measure`.
        seconds
            Time for it, the start of the process not counted.

        Raises
        ------
        WorkerError
            With the message of the failure, or how the process ended.
        """
        return self.ask(case, exact, repeats, seconds=seconds)


def _measurer() -> Callable[..., dict[str, Any]]:
    from comparisons.accuracy.measure import Measurer

    return Measurer().measure
