"""Static equilibrium (K + K_n - K_f) x = load by one factorisation."""

from typing import Any

from cea.contact.saddle import Multipliers
from cea.eigen.pencil import Pencil
from cea.errors import ConvergenceError
from cea.petsc import PETSc
from cea.timing import StageTimer

_SINGULAR = "the stiffness is singular: the bodies are not held by supports and contacts"


def solve_static(
    stiffness: Any,
    load: Any,
    friction: Any | None = None,
    timer: StageTimer | None = None,
    *,
    multipliers: Multipliers | None = None,
) -> Any:
    """Displacements under a load.

    Parameters
    ----------
    stiffness
        Symmetric part K + K_n, PETSc AIJ (N/m).
    load
        Forces (N), PETSc vector.
    friction
        Unsymmetric part K_f, PETSc AIJ (N/m); None takes the symmetric path.
    timer
        Counts factorisation.
    multipliers
        Contact forces that are unknowns.

    Returns
    -------
    PETSc.Vec
        Free displacements (m).

    Raises
    ------
    ConvergenceError
        When the matrix is singular; the failed solution is attached.
    """
    timer = timer or StageTimer()
    pencil = Pencil(stiffness, None, friction, multipliers)
    x = stiffness.createVecRight()
    if multipliers is not None:
        with timer("factorisation"):
            bordered = pencil.bordered()
            solved = bordered.solve(load, x)
            bordered.free()
    else:
        with timer("factorisation"):
            solved = _solve(pencil, load, x)
    if not solved:
        raise ConvergenceError(_SINGULAR, best=x)
    return x


def _solve(pencil: Pencil, load: Any, x: Any) -> bool:
    operator = pencil.displacement_operator()
    if pencil.symmetric:
        operator.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    solver = PETSc.KSP().create(operator.comm)
    solver.setOperators(operator)
    solver.setType(PETSc.KSP.Type.PREONLY)
    pc = solver.getPC()
    pc.setType(PETSc.PC.Type.CHOLESKY if pencil.symmetric else PETSc.PC.Type.LU)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    solver.solve(load, x)
    solved = solver.getConvergedReason() >= 0
    solver.destroy()
    if operator is not pencil.stiffness:
        operator.destroy()
    return bool(solved)
