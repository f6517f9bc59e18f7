"""Measuring one case in this process: run times by stage, peak memory, errors of lambda."""

import ctypes
import gc
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.matching import match_spectrum
from comparisons.accuracy.problems import problem
from comparisons.accuracy.study import Case, overrides
from scenes import Result, run_modes
from scenes.spec.reading import load_scene

REACH = 0.25
"""Relative distance at which a computed eigenvalue no longer stands for an exact one."""


@dataclass
class Measurer:
    """Measures cases; remembers what this process has warmed up.

    The first run of a problem, discretisation and contact rule in a process imports modules,
    loads or compiles finite element forms and fills caches: it is made on the coarsest mesh and
    not timed.
    """

    def __post_init__(self) -> None:
        self._warm: set[Case] = set()

    def measure(self, case: Case, exact: Complexes, repeats: int) -> dict[str, Any]:
        """Measure a case.

        Parameters
        ----------
        case
            The case.
        exact
            Exact eigenvalues to beyond the band.
        repeats
            Timed runs.

        Returns
        -------
        dict
            ``dofs``, ``points``; ``seconds`` of every run, ``stages`` as medians over the runs,
            both of processor time: on one thread of an idle machine that is time by the clock,
            and other work does not lengthen it; ``clock``, the time by the clock of every run;
            ``memory`` peak above what the process held before, and ``memory_process`` at the
            peak (MB, None where the system does not tell); errors of :func:`errors`.
        """
        self._warm_up(case)
        before = start_memory()
        first = _timed(case)
        memory = peak_memory()
        assert first.result is not None
        system, interface = first.result.system, next(iter(first.result.interfaces.values()))
        modes = first.result.modes
        measured = {"dofs": system.size, "points": len(interface.points)}
        del system, interface
        timed = [replace(first, result=None)]
        del first
        for _ in range(repeats - 1):
            gc.collect()
            timed.append(replace(_timed(case), result=None))
        return measured | {
            "seconds": [run.seconds for run in timed],
            "clock": [run.clock for run in timed],
            "stages": {
                stage: float(np.median([run.stages[stage] for run in timed]))
                for stage in timed[0].stages
            },
            "memory": None if memory is None or before is None else memory - before,
            "memory_process": memory,
            **errors(modes.eigenvalues, exact, problem(case.problem).band),
        }

    def _warm_up(self, case: Case) -> None:
        key = replace(case, refinement=1, stiffness=1.0)
        if key not in self._warm:
            _run(key)
            self._warm.add(key)


@dataclass(frozen=True)
class _Timed:
    """A run with its processor time by stage and its time by the clock (s)."""

    result: Result | None
    stages: dict[str, float]
    clock: float

    @property
    def seconds(self) -> float:
        """Processor time of all stages (s)."""
        return sum(self.stages.values())


def _timed(case: Case) -> _Timed:
    clock, processor = perf_counter(), process_time()
    result = _run(case)
    clock, processor = perf_counter() - clock, process_time() - processor
    share = processor / clock
    stages = {stage: share * seconds for stage, seconds in result.timer.seconds.items()}
    return _Timed(result, stages, result.timer.total)


def _run(case: Case) -> Result:
    fields = overrides(problem(case.problem), case)
    return run_modes(load_scene(Path(case.problem), fields, case.method.backend))


def errors(computed: Complexes, exact: Complexes, band: tuple[float, float]) -> dict[str, Any]:
    """Errors over the exact eigenvalues of a band.

    Returns
    -------
    dict
        ``lambda``, ``frequency``, ``growth``, each with ``worst`` and ``median``, None where
        modes are missing; ``modes`` listed; ``missing`` and ``spurious`` eigenvalues as pairs.
    """
    match = match_spectrum(computed, exact, band, reach=REACH)
    return {
        "modes": len(match.exact),
        "lambda": _summary(match.errors),
        "frequency": _summary(match.frequency_errors),
        "growth": _summary(match.growth_errors),
        "missing": _pairs(match.missing),
        "spurious": _pairs(match.spurious),
    }


def _summary(error: Floats) -> dict[str, float | None]:
    worst, median = float(error.max(initial=0.0)), float(np.median(error)) if len(error) else 0.0
    return {
        "worst": worst if np.isfinite(worst) else None,
        "median": median if np.isfinite(median) else None,
    }


def _pairs(values: Complexes) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in values]


_PROCESS = Path("/proc/self")
_RESET_PEAK = "5"
"""What clears the high-water mark of resident memory: proc(5), clear_refs."""


def start_memory() -> float | None:
    """Give free memory back, clear the peak, and tell what is held (MB)."""
    gc.collect()
    if not sys.platform.startswith("linux"):
        return None
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    try:
        (_PROCESS / "clear_refs").write_text(_RESET_PEAK)
    except OSError:
        return None
    return peak_memory()


def peak_memory() -> float | None:
    """Peak of resident memory since it was cleared (MB); None where the system does not tell."""
    try:
        lines = (_PROCESS / "status").read_text().splitlines()
    except OSError:
        return None
    peak = next((line for line in lines if line.startswith("VmHWM:")), None)
    return None if peak is None else int(peak.split()[1]) / 1024
