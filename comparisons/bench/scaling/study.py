"""What more unknowns, higher degrees and more ranks cost, and what larger machines would need.

Every run is a process of its own, and rows of runs are repeated by turns. A direct and an iterative
inverse find the same eigenvalues at each size; from both a model tells what others would take.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.bench.launch import asked
from comparisons.bench.scaling.cases import SIZES, Case, boxes, cases, scene_of
from comparisons.kit.progress import Progress
from scenes.results.record import record
from scenes.spec.analysis import ComplexEigenvalueAnalysis

COMMAND = "bench scaling"
_RUN = "comparisons.bench.scaling.process"
_INVERSE = "comparisons.bench.scaling.inverse"
WAYS = ("mumps", "gamg")
"""Inverses at zero, left of all eigenvalues that do not diverge; the second is tried in the middle
of the window, too."""


@dataclass(frozen=True)
class ScalingStudy:
    """What is run.

    Parameters
    ----------
    size
        Name of a row of meshes (:data:`~comparisons.bench.scaling.cases.SIZES`).
    ranks
        Numbers of ranks, rising.
    repeats
        Runs of each by turns; medians count.
    wanted
        Eigenvalues nearest to zero that both inverses find.
    tolerance
        To which GMRES solves.
    seconds
        Longest time of a run by the clock.
    """

    size: str = "medium"
    ranks: tuple[int, ...] = (1, 2)
    repeats: int = 1
    wanted: int = 20
    tolerance: float = 1e-10
    seconds: float = 900.0

    def __post_init__(self) -> None:
        if self.size not in SIZES:
            raise InputError("size", self.size, f"one of {', '.join(SIZES)}")
        for name in ("repeats", "wanted"):
            if getattr(self, name) < 1:
                raise InputError(name, getattr(self, name), "1 or more")
        if not self.ranks or any(count < 1 for count in self.ranks):
            raise InputError("ranks", self.ranks, "one or more numbers, 1 or more each")
        if not 0 < self.tolerance < 1:
            raise InputError("tolerance", self.tolerance, "between 0 and 1")


def run_scaling(study: ScalingStudy, progress: Progress) -> Iterator[dict[str, Any]]:
    """Run every case and both inverses.

    Yields
    ------
    dict
        The record so far, after each round of runs and after the inverses of each size, so that
        what was measured outlives a study that is cut short: ``runs``, each a case with
        ``failed`` (the reason, or "") and ``answers``, one for each repeat
        (:func:`comparisons.bench.scaling.process.answer`); ``inverses``, each with ``failed`` and
        what :func:`comparisons.bench.scaling.inverse.answer` gives.

    Raises
    ------
    InputError
        On several ranks: the cases' processes start their own.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("mpiexec", MPI.COMM_WORLD.size, "--ranks instead")
    begun = perf_counter()
    every = list(dict.fromkeys(cases(study.size, study.ranks)))
    runs = [{**each.plain(), "failed": "", "answers": []} for each in every]
    inverses = list[dict[str, Any]]()
    inputs = asdict(study) | {"ranks": list(study.ranks)}

    def so_far() -> dict[str, Any]:
        done = [dict(run) for run in runs if run["failed"] or run["answers"]]
        data = {"runs": done, "inverses": list(inverses)}
        return record(COMMAND, data, inputs=inputs, seconds=perf_counter() - begun)

    with TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(study.repeats):
            for case, run in zip(every, runs, strict=True):
                progress.step(f"{told(run)}, {number + 1} of {study.repeats}")
                if not run["failed"]:
                    _add(run, case, study, folder)
            yield so_far()
        for factor in SIZES[study.size]:
            inverses += _inverses(Case("size", 1, *boxes(factor)), study, folder, progress)
            yield so_far()


def told(run: Mapping[str, Any]) -> str:
    """A run in words."""
    kind = {"fe": "Lagrange", "iga": "NURBS"}[run["backend"]]
    ranks = f"{run['ranks']} rank{'s' if run['ranks'] > 1 else ''}"
    return f"{run['kind']}: {kind} of degree {run['degree']}, disc {run['disc']}, {ranks}"


def _add(run: dict[str, Any], case: Case, study: ScalingStudy, folder: Path) -> None:
    """Add an answer to a run, or why there is none."""
    try:
        found = asked(_RUN, case.plain(), folder, ranks=case.ranks, seconds=study.seconds)
    except ConvergenceError as error:
        run["failed"] = str(error)
    else:
        run["answers"].append(found)


def _inverses(
    case: Case, study: ScalingStudy, folder: Path, progress: Progress
) -> list[dict[str, Any]]:
    """Both inverses at zero, the iterative one in the middle of the window, too."""
    analysis = scene_of(case.plain()).analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    middle = 0.5 * (2 * np.pi * analysis.max_frequency) ** 2
    found = []
    for way, shift in (*((way, 0.0) for way in WAYS), (WAYS[-1], middle)):
        progress.step(f"{way} at {shift:.3g} 1/s², disc {case.disc}")
        question = {
            "case": case.plain(),
            "way": way,
            "shift": shift,
            "wanted": study.wanted if shift == 0 else 0,
            "tolerance": study.tolerance,
        }
        try:
            answer = asked(_INVERSE, question, folder, ranks=1, seconds=study.seconds)
        except ConvergenceError as error:
            answer = {"way": way, "shift": shift, "unknowns": None, "failed": str(error)}
        found.append({"disc": list(case.disc), **answer})
    return found
