"""Eigenvalues of one window by several methods: time, memory, error.

Times are also given in units of one numeric factorisation (LU) at the common shift, measured in the
same process: the speed of the machine at that time then cancels.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import numpy as np
import pandas as pd

from cea.arrays import Complexes
from cea.eigen.classify import classify, thresholds
from cea.errors import require
from cea.matrices import destroy
from cea.petsc import MPI, PETSc
from comparisons.bench.methods import METHODS, OURS, SERIAL, Problem, backward_errors
from comparisons.study.columns import medians
from comparisons.study.matching import match_spectrum
from comparisons.study.measure import measured
from comparisons.study.numbers import number, shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Process, Session, Study, StudyResult, at_least_one
from scenes.spec.reading import Scene, load_scene

SIZES: Mapping[str, Mapping[str, tuple[int, int, int]]] = {
    "tiny": {"pad": (2, 3, 1), "disc": (3, 16, 1)},
    "small": {"pad": (4, 7, 2), "disc": (6, 36, 1)},
    "medium": {"pad": (7, 12, 4), "disc": (9, 60, 2)},
    "large": {"pad": (9, 16, 5), "disc": (16, 120, 3)},
    "million": {"pad": (16, 28, 9), "disc": (30, 222, 5)},
}
"""Boxes of each body along r, theta and z, six quadratic tetrahedra each."""
MAX_FREQUENCY = 27e3  # end of the window (Hz)
_EVENTS = {
    "factorisations": ("MatLUFactorNum", "MatCholFctrNum"),
    "solves": ("MatSolve", "MatSolveTranspos"),
    "blocks": ("MatMatSolve", "MatMatTrSolve"),
}
"""Events of PETSc that are counted for each method."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    size: Annotated[str, "Mesh: tiny, small, medium, large or million."] = "medium"
    ranks: Annotated[int, "Ranks of each method."] = 1
    repeats: Annotated[int, "Runs of each method; medians are reported."] = 1

    def __post_init__(self) -> None:
        at_least_one(ranks=self.ranks, repeats=self.repeats)
        require(self.size in SIZES, "size", self.size, f"one of {', '.join(SIZES)}")


def cases(options: Options) -> Iterator[Case]:
    """Every method in each round."""
    for repeat in range(options.repeats):
        for method in METHODS:
            yield {"method": method, "ranks": options.ranks, "repeat": repeat}


def scene(case: Case, options: Options) -> Scene:
    """Return disc and pad on quadratic tetrahedra."""
    changes: dict[str, Any] = {"analysis.max_frequency": MAX_FREQUENCY}
    for body, boxes in SIZES[options.size].items():
        changes[f"bodies.{body}.mesh.fe.cell"] = "tetrahedron"
        changes[f"bodies.{body}.mesh.fe.elements"] = list(boxes)
    return load_scene("disc_pad", backend="fe").change(changes)


@cache
def _problem(options: Options) -> Problem:
    """Return the matrices, assembled once in a process, and start the event log of PETSc."""
    PETSc.Log.begin()
    return Problem.of(scene({}, options))


@cache
def _wanted(options: Options) -> int:
    """Number of eigenvalues in the window, which the other methods need as input."""
    return len(METHODS[OURS](_problem(options), 0).inside(_problem(options).top).kappa)


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Run a method; return its measurements, stages and eigenvalues."""
    options, comm, name = session.options, MPI.COMM_WORLD, case["method"]
    require(name != SERIAL or comm.size == 1, "ranks", comm.size, "1: scipy is serial")
    problem = _problem(options)
    wanted, before = 0 if name == OURS else _wanted(options), _counts()
    with measured() as cost:
        found = METHODS[name](problem, wanted).inside(problem.top)
    counts = {event: count - before[event] or None for event, count in _counts().items()}
    processor, lu = comm.allreduce(cost.processor), comm.allreduce(lu_seconds(problem))
    row = {
        "unknowns": int(problem.mass.getSize()[0]),
        "clock": comm.allreduce(cost.clock, MPI.MAX),
        "processor": processor,
        "factorisations_worth": processor / lu,
        **counts,
        "memory": comm.allreduce(cost.memory or 0.0),
        "eigenvalues": len(found.kappa),
        "unstable": unstable(found.kappa),
        "backward_error": float(backward_errors(problem, found).max()),
        "claims": found.claims,
    }
    stages = [
        {"stage": stage, "processor": taken, "factorisations_worth": taken / lu}
        for stage, seconds in found.stages.items()
        if (taken := comm.allreduce(seconds))
    ]
    values = [{"re": k.real, "im": k.imag} for k in found.kappa]
    return {"runs": [row], "stages": stages, "eigenvalues": values}


def _counts() -> dict[str, int]:
    """Return how often PETSc has factorised and solved so far."""
    return {
        name: sum(int(PETSc.Log.Event(event).getPerfInfo()["count"]) for event in events)
        for name, events in _EVENTS.items()
    }


def lu_seconds(problem: Problem) -> float:
    """Processor time (s) of a numeric factorisation at the shift, without its ordering."""
    matrix = problem.unsymmetric(problem.shift)
    pc: Any = PETSc.PC().create(matrix.comm)
    pc.setOperators(matrix)
    pc.setType(PETSc.PC.Type.LU)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setUp()
    matrix.stateIncrease()  # forces a new numeric factorisation
    pc.setOperators(matrix)
    with measured() as cost:
        pc.setUp()
    destroy(pc, matrix)
    return cost.processor


def unstable(kappa: Complexes) -> int:
    """Return the number of unstable modes."""
    speeds = np.sqrt(-kappa.astype(complex))
    speeds = np.where(speeds.imag < 0, -speeds, speeds)
    return classify(speeds.real, 0.0, thresholds(speeds), False).count("unstable")


def methods(result: StudyResult) -> pd.DataFrame:
    """Medians of each method; errors against the answer with the smallest backward error."""
    every = result.frame()
    runs = medians(every)
    values = result.frame("eigenvalues").query("repeat == repeat.min()")
    kappa = {
        name: (own["re"] + 1j * own["im"]).to_numpy() for name, own in values.groupby("method")
    }
    exact = kappa[every.loc[every["backward_error"].idxmin(), "method"]]
    found = [match_spectrum(kappa[name], exact, (-np.inf, np.inf)) for name in runs["method"]]
    errors = [match.errors[np.isfinite(match.errors)] for match in found]
    runs["median"] = [float(np.median(each)) for each in errors]
    runs["worst"] = [float(each.max()) for each in errors]
    runs["missing"] = [len(match.missing) for match in found]
    return runs


COLUMNS = {
    "factorisations_worth": Column("time", "LU", shown(3)),
    "factorisations": Column("factorised", show=number),
    "blocks": Column("of blocks", show=number),
    "median": Column("error, median", show=shown(2)),
    "worst": Column("worst error of λ²", show=shown(2)),
}
STUDY = Study(
    name="bench solve",
    title="Eigenvalues of a window by several methods",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={"size": "tiny"},
    process=Process("comparisons.bench.solve:STUDY", 3600.0),
    sections=[
        Section(
            "Methods",
            of="runs",
            tables=[
                Table(
                    "methods",
                    "Processor time of all ranks (medians), also in units of one numeric LU "
                    "factorisation at the shift; calls counted by PETSc; peak memory of all ranks "
                    "in excess of the matrices; relative errors of λ² against the answer with the "
                    "smallest backward error.",
                    methods,
                    COLUMNS,
                    printed=True,
                ),
                Table(
                    "stages",
                    "Processor time by stage, for methods that report stages.",
                    lambda result: medians(result.frame("stages"), "stage"),
                    COLUMNS,
                ),
            ],
            plots=[
                Plot(
                    "error_against_time",
                    "Worst error of each method against its processor time.",
                    methods,
                    "processor",
                    "worst",
                    ("method",),
                    log="xy",
                    own=COLUMNS,
                    style="markers",
                )
            ],
        )
    ],
)
