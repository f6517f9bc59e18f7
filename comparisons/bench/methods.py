"""Methods for the eigenvalues of a window: this driver, SLEPc, scipy, projection on real modes.

Most industrial programs use the last: they project the pencil with friction on the lowest modes of
its symmetric part and solve the projected problem by dense methods.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import eig
from scipy.sparse import csc_array
from scipy.sparse.linalg import eigs

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import all_inner, norms, times
from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.errors import InputError
from cea.matrices import destroy, local_part, scaled_total
from cea.petsc import PETSc, SLEPc
from cea.timing import StageTimer
from scenes.running.system import coupled
from scenes.spec.reading import Scene

TOLERANCE = 1e-12


@dataclass(frozen=True)
class Problem:
    """The eigenproblem K x = kappa M x with K = S + U, and its window."""

    pencil: Pencil  # input of this program's driver
    stiffness: Any  # S, PETSc AIJ
    mass: Any
    friction: Any  # U
    top: float  # end of the window, of kappa = -lambda^2 (1/s^2)

    @classmethod
    def of(cls, scene: Scene) -> "Problem":
        """Return the matrices of a scene with friction in penalty form and without damping."""
        pencil = coupled(scene)[0].pencil()
        matrices = pencil.at()
        if matrices.multipliers is not None or matrices.unsymmetric is None or matrices.quadratic:
            raise InputError("scene", scene.name, "a penalty with friction, without damping")
        assert scene.analysis.kind == "cea"
        top = (2 * np.pi * scene.analysis.max_frequency) ** 2
        return cls(pencil, matrices.stiffness, matrices.mass, matrices.unsymmetric, top)

    @property
    def shift(self) -> float:
        """Middle of the window: the shift of all methods with shift-invert."""
        return 0.5 * self.top

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

    def inside(self, top: float) -> "Answer":
        """Return the eigenvalues inside a window."""
        kept = np.abs(np.sqrt(-self.kappa.astype(complex)).imag) <= np.sqrt(top)
        return replace(self, kappa=self.kappa[kept], vectors=self.vectors[:, kept])


def backward_errors(problem: Problem, found: Answer) -> Floats:
    """|K x - kappa M x| / |kappa M x| of each pair, in the Euclidean norm."""
    K = problem.unsymmetric()
    heavy = times(problem.mass, found.vectors) * found.kappa
    defect = times(K, found.vectors) - heavy
    destroy(K)
    return norms(defect, problem.mass.comm) / norms(heavy, problem.mass.comm)


def this_driver(problem: Problem, wanted: int) -> Answer:
    """Return all modes of the window, with evidence of completeness."""
    timer = StageTimer()
    modes = solve_modes(problem.pencil, np.sqrt(problem.top) / (2 * np.pi), timer=timer)
    window, stages = modes.window, timer.processor_seconds
    claims = "complete" if window.bounded else f"complete to a growth of {window.max_growth:.3g}"
    return Answer(-(modes.eigenvalues**2), modes.vectors, claims, stages)


def slepc(problem: Problem, wanted: int) -> Answer:
    """Krylov-Schur of SLEPc with MUMPS, used as in its manual."""
    K, M = problem.unsymmetric(), problem.mass
    return _krylov_schur(K, M, SLEPc.EPS.ProblemType.PGNHEP, problem.shift, wanted)


def arpack(problem: Problem, wanted: int) -> Answer:
    """ARPACK and SuperLU by scipy, on one rank."""
    K, M = (csc_array(local_part(m)) for m in (problem.unsymmetric(), problem.mass))
    kappa, vectors = eigs(K, wanted, M=M, sigma=problem.shift)
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
