"""Static equilibrium (K + K_n - K_f) x = load by one factorisation."""

from typing import Any

from petsc4py import PETSc

from cea.errors import ConvergenceError
from cea.timing import StageTimer


def solve_static(
    stiffness: Any, load: Any, friction: Any | None = None, timer: StageTimer | None = None
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
    operator = stiffness
    if friction is not None:
        operator = stiffness.copy()
        operator.axpy(-1.0, friction, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    else:
        operator.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    solver = PETSc.KSP().create(operator.comm)
    solver.setOperators(operator)
    solver.setType(PETSc.KSP.Type.PREONLY)
    pc = solver.getPC()
    pc.setType(PETSc.PC.Type.CHOLESKY if friction is None else PETSc.PC.Type.LU)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    x = operator.createVecRight()
    with timer("factorisation"):
        solver.solve(load, x)
    failed = solver.getConvergedReason() < 0
    solver.destroy()
    if friction is not None:
        operator.destroy()
    if failed:
        raise ConvergenceError(
            "the stiffness is singular: the bodies are not held by supports and contacts", best=x
        )
    return x
