"""Shift-and-invert by MUMPS, or by GMRES with algebraic multigrid: the same eigenvalues.

``python -m comparisons.bench.scaling.inverse FILE``: the file holds ``case``, ``way``, ``wanted``,
``shift`` and ``tolerance``, and then the answer. Multigrid (PETSc's GAMG, smoothed aggregation)
is made of the symmetric part and knows the rigid motions of the bodies. It needs one that is
positive definite: that is so at shifts left of all eigenvalues, and no more inside the window.
"""

from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from cea.arrays import Floats
from cea.body import Body
from cea.matrices import destroy
from cea.petsc import PETSc, SLEPc
from cea.system.coupled import CoupledSystem
from comparisons.bench import memory
from comparisons.bench.launch import answer_file
from comparisons.bench.rigid import rigid_motions
from comparisons.bench.scaling.cases import scene_of
from scenes.running.system import coupled

_TRIALS = 3
"""Systems with random right sides that are timed."""
_MOST = 1000
"""Steps of GMRES before a system is given up."""
_RESTART = 100
_PREFIX = "bench_scaling_"
_SMOOTHER = {
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_ksp_max_it": "2",
    "mg_levels_pc_type": "icc",
}
"""Smoothing by incomplete Cholesky factors in Chebyshev steps: with incomplete LU in Richardson's,
GMRES stands still on thin bodies of quadratic elements."""


def answer(question: dict[str, Any]) -> dict[str, Any]:
    """Find the eigenvalues nearest to a shift.

    Returns
    -------
    dict
        ``unknowns``; processor seconds of ``setup`` and of a ``solve``; ``steps`` of a solve;
        ``whole``, processor seconds of the eigenvalues; ``solves``; ``kappa``, eigenvalues (1/s^2)
        as pairs; ``memory`` over that of the matrices (bytes); ``failed``, the reason or "".
    """
    PETSc.Log.begin()
    system, _, _ = coupled(scene_of(question["case"]))
    matrices = system.pencil().at()
    shift = question["shift"]
    K, M = matrices.operator(), matrices.mass
    A = K if shift == 0 else matrices.operator(shift)
    for matrix in (A, K):
        matrix.setBlockSize(system_dim(system))
    P = A if matrices.symmetric else matrices.operator(shift, symmetric_part=True)
    P.setBlockSize(system_dim(system))
    P.setNearNullSpace(near_null_space(system))
    memory.forget_largest()
    before = memory.held()
    ksp = inverse(A, P, question["way"], question["tolerance"])
    begun = process_time()
    ksp.setUp()
    setup = process_time() - begun
    found = {"unknowns": matrices.size, "setup": setup, "way": question["way"], "shift": shift}
    found |= _systems(ksp, A)
    if not found["failed"] and question["wanted"]:
        found |= _eigenvalues(ksp, K, M, shift, question["wanted"])
    return found | {"memory": memory.largest() - before}


def system_dim(system: CoupledSystem) -> int:
    """Dimension of space, of all bodies."""
    return next(iter(system.bodies.values())).dim


def inverse(A: Any, P: Any, way: str, tolerance: float) -> Any:
    """What solves systems with A, PETSc KSP: ``mumps``, or GMRES with ``gamg`` of P."""
    ksp: Any = PETSc.KSP().create(A.comm)
    ksp.setOperators(A, A if way == "mumps" else P)
    pc = ksp.getPC()
    if way == "mumps":
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc.setType(PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        return ksp
    ksp.setType(PETSc.KSP.Type.GMRES)
    ksp.setGMRESRestart(_RESTART)
    ksp.setTolerances(rtol=tolerance, max_it=_MOST)
    pc.setType(PETSc.PC.Type.GAMG)
    pc.setGAMGType(PETSc.PC.GAMGType.AGG)
    options: Any = PETSc.Options(_PREFIX)
    for name, value in _SMOOTHER.items():
        options[name] = value
    ksp.setOptionsPrefix(_PREFIX)
    ksp.setFromOptions()
    return ksp


def near_null_space(system: CoupledSystem) -> Any:
    """Rigid motions of all bodies together, PETSc null space of the free displacements."""
    parts = [_motions(body) for body in system.bodies.values()]
    basis, _ = np.linalg.qr(np.concatenate(parts))
    vectors = []
    for column in basis.T:
        entries: Any = np.ascontiguousarray(column)
        vectors.append(PETSc.Vec().createWithArray(entries, comm=PETSc.COMM_SELF))
    return PETSc.NullSpace().create(vectors=vectors, comm=PETSc.COMM_SELF)


def _motions(body: Body) -> Floats:
    """Rigid motions of a body by its free displacements, shape (n, 6)."""
    cells = body.volume_cells()
    values = csc_array(cells.values)
    points = spsolve(csc_array(values.T @ values), values.T @ cells.points)
    every, free = body.expansion.createVecLeft(), body.expansion.createVecRight()
    columns = []
    for motion in rigid_motions(points).T:
        every.array[:] = motion
        body.expansion.multTranspose(every, free)
        columns.append(free.array_r.copy())
    destroy(every, free)
    return np.column_stack(columns)


def _systems(ksp: Any, A: Any) -> dict[str, Any]:
    """Seconds and steps of a system with a random right side."""
    b, x = A.createVecs()
    seconds, steps, reason = [], [], 0
    for _ in range(_TRIALS):
        b.setRandom()
        begun = process_time()
        ksp.solve(b, x)
        seconds.append(process_time() - begun)
        steps.append(ksp.getIterationNumber())
        reason = ksp.getConvergedReason()
        if reason < 0:
            break
    destroy(b, x)
    failed = f"not solved after {steps[-1]} steps of GMRES" if reason < 0 else ""
    return {"solve": float(np.median(seconds)), "steps": int(max(steps)), "failed": failed}


def _eigenvalues(ksp: Any, K: Any, M: Any, shift: float, wanted: int) -> dict[str, Any]:
    """Eigenvalues nearest to the shift by Krylov-Schur, what they took, their backward errors."""
    solver: Any = SLEPc.EPS().create(K.comm)
    solver.setOperators(K, M)
    solver.setProblemType(SLEPc.EPS.ProblemType.GNHEP)
    solver.setDimensions(nev=wanted)
    solver.setTolerances(tol=1e-9)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(shift)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    transform.setKSP(ksp)
    clock, begun = perf_counter(), process_time()
    before = _applications()
    solver.solve()
    whole, clock = process_time() - begun, perf_counter() - clock
    count = min(wanted, solver.getConverged())
    kappa = [solver.getEigenvalue(i) for i in range(count)]
    return {
        "whole": whole,
        "clock": clock,
        "solves": _applications() - before,
        "kappa": sorted([float(k.real), float(k.imag)] for k in kappa),
        "failed": "" if count == wanted else f"{count} of {wanted} eigenvalues converged",
    }


def _applications() -> int:
    """How often the shifted matrix was inverted so far, as SLEPc counts."""
    return int(PETSc.Log.Event("STApply").getPerfInfo()["count"])


if __name__ == "__main__":
    answer_file(answer)
