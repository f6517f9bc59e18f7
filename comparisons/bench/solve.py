"""Eigenvalues of one window by several methods: time, memory, error.

Each method also counts its seconds in numeric factorisations (LU) at the shift that all of them
use, made in the same process: how fast the machine happens to be then cancels.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from cea.arrays import Complexes
from cea.eigen.classify import classify, thresholds
from cea.errors import InputError
from cea.matrices import destroy
from cea.petsc import MPI, PETSc
from comparisons.bench.methods import METHODS, OURS, SERIAL, Problem, backward_errors
from comparisons.study.columns import Column, medians
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study, at_least_one
from scenes.spec.reading import Scene, load_scene

SIZES: Mapping[str, Mapping[str, tuple[int, int, int]]] = {
    "tiny": {"pad": (2, 3, 1), "disc": (3, 16, 1)},
    "small": {"pad": (4, 7, 2), "disc": (6, 36, 1)},
    "medium": {"pad": (7, 12, 4), "disc": (9, 60, 2)},
    "large": {"pad": (9, 16, 5), "disc": (16, 120, 3)},
    "million": {"pad": (16, 28, 9), "disc": (30, 222, 5)},
}
"""Boxes of each body along r, theta and z, six quadratic tetrahedra each."""
MAX_FREQUENCY = 27e3
"""End of the window (Hz)."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark.

    Parameters
    ----------
    size
        Mesh: tiny, small, medium, large or million.
    ranks
        Ranks of each method.
    repeats
        Runs of each by turns; medians count.
    """

    size: str = "medium"
    ranks: int = 1
    repeats: int = 1

    def __post_init__(self) -> None:
        at_least_one(ranks=self.ranks, repeats=self.repeats)
        if self.size not in SIZES:
            raise InputError("size", self.size, f"one of {', '.join(SIZES)}")


def cases(options: Options) -> Iterator[Case]:
    """Every method by turns."""
    for repeat in range(options.repeats):
        for method in METHODS:
            yield {"method": method, "ranks": options.ranks, "repeat": repeat}


def scene(case: Case, options: Options) -> Scene:
    """Disc and pad on quadratic tetrahedra."""
    changes: dict[str, Any] = {"analysis.max_frequency": MAX_FREQUENCY}
    for body, boxes in SIZES[options.size].items():
        changes[f"bodies.{body}.mesh.fe.cell"] = "tetrahedron"
        changes[f"bodies.{body}.mesh.fe.elements"] = list(boxes)
    return load_scene("disc_pad", backend="fe").change(changes)


@cache
def _problem(options: Options) -> Problem:
    """The matrices, assembled once in a process."""
    return Problem.of(scene({}, options))


@cache
def _wanted(options: Options) -> int:
    """How many eigenvalues the window holds, which other methods must be told."""
    problem = _problem(options)
    return len(METHODS[OURS](problem, 0).inside(problem.top).kappa)


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Run a method and measure it: its row and its eigenvalues."""
    options, comm, name = session.options, MPI.COMM_WORLD, case["method"]
    if name == SERIAL and comm.size > 1:
        raise InputError("ranks", comm.size, "1: scipy runs on one")
    problem = _problem(options)
    wanted = 0 if name == OURS else _wanted(options)
    with measured() as cost:
        found = METHODS[name](problem, wanted)
    found = found.inside(problem.top)
    processor, lu = comm.allreduce(cost.processor), comm.allreduce(lu_seconds(problem))
    row = {
        "unknowns": int(problem.mass.getSize()[0]),
        "clock": comm.allreduce(cost.clock, MPI.MAX),
        "processor": processor,
        "factorisations_worth": processor / lu,
        "memory": comm.allreduce(cost.memory or 0.0),
        "eigenvalues": len(found.kappa),
        "unstable": unstable(found.kappa),
        "backward_error": float(backward_errors(problem, found).max()),
        "claims": found.claims,
    }
    return {"runs": [row], "eigenvalues": [{"re": k.real, "im": k.imag} for k in found.kappa]}


def lu_seconds(problem: Problem) -> float:
    """Processor seconds of a numeric factorisation at the shift on this rank, its order known."""
    matrix = problem.unsymmetric(problem.shift)
    pc: Any = PETSc.PC().create(matrix.comm)
    pc.setOperators(matrix)
    pc.setType(PETSc.PC.Type.LU)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setUp()
    matrix.stateIncrease()  # a matrix that was touched is factorised anew
    pc.setOperators(matrix)
    with measured() as cost:
        pc.setUp()
    destroy(pc, matrix)
    return cost.processor


def unstable(kappa: Complexes) -> int:
    """How many modes grow."""
    speeds = np.sqrt(-kappa.astype(complex))
    speeds = np.where(speeds.imag < 0, -speeds, speeds)
    return classify(speeds.real, 0.0, thresholds(speeds), False).count("unstable")


def errors_of(found: Complexes, exact: Complexes) -> tuple[list[float], int]:
    """Relative errors of eigenvalues, each paired with an exact one, and how many have no pair."""
    cost = np.abs(found[:, None] - exact) / np.abs(exact)
    rows, columns = linear_sum_assignment(cost)
    return cost[rows, columns].tolist(), len(exact) - len(columns)


def methods(result: StudyResult) -> pd.DataFrame:
    """Medians of each method, and errors of its eigenvalues against the tightest answer."""
    runs = medians(result.frame())
    values = result.frame("eigenvalues").query("repeat == repeat.min()")
    kappa = {
        name: (own["re"] + 1j * own["im"]).to_numpy() for name, own in values.groupby("method")
    }
    exact = kappa[tightest(result)]
    found = [errors_of(kappa[name], exact) for name in runs["method"]]
    runs["median"] = [float(np.median(errors)) for errors, _ in found]
    runs["worst"] = [max(errors) for errors, _ in found]
    runs["missing"] = [missing for _, missing in found]
    return runs


def tightest(result: StudyResult) -> str:
    """The method whose largest backward error is the least."""
    runs = result.frame()
    return str(runs.loc[runs["backward_error"].idxmin(), "method"])


COLUMNS = {
    "factorisations_worth": Column("time", "LU", shown(3)),
    "median": Column("error, median", show=shown(2)),
    "worst": Column("worst error of λ²", show=shown(2)),
}
TABLE = Table(
    "methods",
    "Processor time of all ranks, medians, also in numeric factorisations (LU) at the shift; peak "
    "memory of all ranks above that of the matrices; errors of the eigenvalues (λ², relative) "
    "against the answer with the smallest backward error.",
    methods,
    COLUMNS,
    printed=True,
)
STUDY = Study(
    name="bench solve",
    title="Eigenvalues of a window beside other methods",
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
            tables=[TABLE],
            plots=[
                Plot(
                    "error_against_time",
                    "Worst error of each method over its processor time.",
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
