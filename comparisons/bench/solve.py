"""Eigenvalues of one window by several methods: time, memory, error.

The methods are this driver, SLEPc, scipy, and projection on real modes. Most industrial programs
use the last: they project the pencil with friction on the lowest modes of its symmetric part and
solve the projected problem by dense methods. Times are also given in units of one numeric
factorisation (LU) at the common shift, measured in the same process: the speed of the machine then
cancels.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Annotated, Any

import numpy as np
import pandas as pd
from scipy.linalg import eig
from scipy.sparse import csc_array
from scipy.sparse.linalg import eigs

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import all_inner, norms, times
from cea.eigen.classify import classify, thresholds
from cea.eigen.driver import EigenSolver
from cea.eigen.mumps import Mumps, factors_on_disk
from cea.eigen.pencil import Pencil
from cea.errors import require
from cea.matrices import destroy, local_part, scaled_total
from cea.petsc import MPI, PETSc, SLEPc
from cea.timing import StageTimer
from comparisons.study.columns import medians
from comparisons.study.matching import match_spectrum
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Process, Session, Study, StudyResult, at_least_one
from scenes.checking.memory import in_memory_or_on_disk
from scenes.running.run import coupled
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
_TOP = (2 * np.pi * MAX_FREQUENCY) ** 2  # the same of kappa = -lambda^2 (1/s^2)
_SHIFT = 0.5 * _TOP  # shift of all methods with shift-invert
_EVENTS = {
    "factorisations": ("MatLUFactorNum", "MatCholFctrNum"),
    "solves": ("MatSolve", "MatSolveTranspos"),
    "blocks": ("MatMatSolve", "MatMatTrSolve"),
}
"""Events of PETSc that are counted for each method."""
TOLERANCE = 1e-12
_RIGID = 1e-6  # abs(lambda), relative to the largest, below which a mode is a rigid body mode


@dataclass(frozen=True)
class Problem:
    """The eigenproblem K x = kappa M x of a scene, with K = S + U."""

    scene: Scene
    pencil: Pencil  # input of this program's driver
    stiffness: Any  # S, PETSc AIJ
    mass: Any
    friction: Any  # U

    def unsymmetric(self, shift: float = 0.0) -> Any:
        """Return K - shift M as a new matrix."""
        shifted = [(-shift, self.mass)] if shift else []
        return scaled_total([(1.0, self.stiffness), (1.0, self.friction), *shifted])


@dataclass(frozen=True)
class Answer:
    """Eigenvalues of K x = kappa M x."""

    kappa: Complexes  # (1/s^2), both of each conjugate pair
    vectors: Complexes  # the rows of this rank
    claims: str = ""  # which eigenvalues the method claims to return
    stages: Mapping[str, float] = field(default_factory=dict)  # processor seconds, if known
    on_disk: bool = False  # whether factors were written to disk, for lack of memory

    def inside(self) -> "Answer":
        """Return the eigenvalues inside the window."""
        kept = np.abs(np.sqrt(-self.kappa.astype(complex)).imag) <= np.sqrt(_TOP)
        return replace(self, kappa=self.kappa[kept], vectors=self.vectors[:, kept])


def backward_errors(problem: Problem, found: Answer) -> Floats:
    """|K x - kappa M x| / |kappa M x| of each pair, in the Euclidean norm."""
    K = problem.unsymmetric()
    heavy = times(problem.mass, found.vectors) * found.kappa
    defect = times(K, found.vectors) - heavy
    destroy(K)
    return norms(defect, problem.mass.comm) / norms(heavy, problem.mass.comm)


def unstable(values: Complexes) -> Complexes:
    """Return those lambda of unstable modes."""
    rigid = np.abs(values) <= _RIGID * np.abs(values).max(initial=0.0)
    words = classify(values.real, 0.0, thresholds(values), False, rigid)
    return values[np.array(words) == "unstable"]


def this_driver(problem: Problem, wanted: int) -> Answer:
    """Return all modes of the window, with evidence of completeness."""
    timer = StageTimer()
    with EigenSolver(problem.pencil) as driver:
        solve = partial(driver.solve, MAX_FREQUENCY, timer=timer)
        modes = in_memory_or_on_disk(problem.scene, driver, solve)
    window, stages = modes.window, timer.processor_seconds
    claims = "complete" if window.bounded else f"complete to a growth of {window.max_growth:.3g}"
    on_disk = any(each.kind == "factors-on-disk" for each in modes.warnings)
    claims += ", factors on disk" if on_disk else ""
    return Answer(-(modes.eigenvalues**2), modes.vectors, claims, stages, on_disk)


def slepc(problem: Problem, wanted: int) -> Answer:
    """Krylov-Schur of SLEPc with MUMPS, used as in its manual."""
    K, M = problem.unsymmetric(), problem.mass
    return _krylov_schur(K, M, SLEPc.EPS.ProblemType.PGNHEP, _SHIFT, wanted)


def arpack(problem: Problem, wanted: int) -> Answer:
    """ARPACK and SuperLU by scipy, on one rank."""
    K, M = (csc_array(local_part(m)) for m in (problem.unsymmetric(), problem.mass))
    kappa, vectors = eigs(K, wanted, M=M, sigma=_SHIFT)
    return Answer(kappa, vectors, "nearest to the shift")


def projection(problem: Problem, wanted: int, count: int) -> Answer:
    """Return all eigenvalues of the pencil projected on ``count`` modes of its symmetric part."""
    S, M = problem.stiffness, problem.mass
    modes = _krylov_schur(S, M, SLEPc.EPS.ProblemType.GHEP, 0.0, count)
    basis = np.asfortranarray(modes.vectors[:, :count].real)  # more may have converged
    every = problem.unsymmetric(), problem.mass
    K, M = (all_inner(basis, times(matrix, basis), matrix.comm) for matrix in every)
    kappa, vectors = eig(K, M)
    return Answer(kappa, basis @ vectors, f"on {basis.shape[1]} real modes")


OURS = "this driver"
SERIAL = "scipy eigs, SuperLU"
METHODS: Mapping[str, Callable[[Problem, int], Answer]] = {
    OURS: this_driver,
    "SLEPc Krylov-Schur": slepc,
    SERIAL: arpack,
    **{f"{n} real modes": partial(projection, count=n) for n in (100, 200, 300)},
}
"""Methods by name; arguments are a problem and the number of eigenvalues in its window."""


def _krylov_schur(K: Any, M: Any, kind: Any, shift: float, count: int) -> Answer:
    """Return the eigenpairs nearest to a shift, with both of each conjugate pair."""
    solver: Any = SLEPc.EPS().create(M.comm)
    solver.setOperators(K, M)
    solver.setProblemType(kind)
    solver.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    solver.setDimensions(nev=count)
    solver.setTolerances(tol=TOLERANCE)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(shift)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    inner = transform.getKSP()
    inner.setType(PETSc.KSP.Type.PREONLY)
    symmetric = kind == SLEPc.EPS.ProblemType.GHEP
    inner.getPC().setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
    inner.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    solver.solve()
    real, imaginary = M.createVecs()
    count = solver.getConverged()
    kappa = np.empty(count, dtype=complex)
    vectors = np.empty((real.getLocalSize(), count), dtype=complex, order="F")
    for i in range(count):
        kappa[i] = solver.getEigenpair(i, real, imaginary)
        vectors[:, i] = real.array_r + 1j * imaginary.array_r
    return Answer(kappa, vectors, "nearest to the shift")


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
    solved = scene({}, options)
    pencil = coupled(solved)[0].pencil()
    matrices = pencil.at()
    return Problem(solved, pencil, matrices.stiffness, matrices.mass, matrices.unsymmetric)


@cache
def _wanted(options: Options) -> int:
    """Number of eigenvalues in the window, which the other methods need as input."""
    return len(METHODS[OURS](_problem(options), 0).inside().kappa)


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Run a method; return its measurements, stages and eigenvalues."""
    options, comm, name = session.options, MPI.COMM_WORLD, case["method"]
    require(name != SERIAL or comm.size == 1, "ranks", comm.size, "1: scipy is serial")
    problem = _problem(options)
    wanted, before = 0 if name == OURS else _wanted(options), _counts()
    with measured() as cost:
        found = METHODS[name](problem, wanted).inside()
    counts = {event: count - before[event] or None for event, count in _counts().items()}
    with factors_on_disk() if found.on_disk else nullcontext():
        lu = comm.allreduce(lu_seconds(problem))
    processor = comm.allreduce(cost.processor)
    speeds = np.sqrt(-found.kappa.astype(complex))
    row = {
        "unknowns": int(problem.mass.getSize()[0]),
        "clock": comm.allreduce(cost.clock, MPI.MAX),
        "processor": processor,
        "factorisations_worth": processor / lu,
        **counts,
        "memory": comm.allreduce(cost.memory or 0.0),
        "eigenvalues": len(found.kappa),
        "unstable": len(unstable(np.where(speeds.imag < 0, -speeds, speeds))),
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
    factors = Mumps(problem.unsymmetric(_SHIFT), symmetric=False)
    factors.matrix.stateIncrease()  # a numeric factorisation only
    with measured() as cost:
        factors.factorise()
    factors.free()
    return cost.processor


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
                    "Medians of processor time, also in units of one LU factorisation; calls of "
                    "PETSc; memory beyond the matrices; errors of λ² against the answer with the "
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
