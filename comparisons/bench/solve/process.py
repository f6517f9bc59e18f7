"""One method in a process of its own: ``python -m comparisons.bench.solve.process FILE``.

The file holds the question: ``method``, ``modes`` where it projects, ``folder`` of the matrices,
``wanted`` and ``memory``, the most a rank may take; the answer takes its place. Under a launcher of
ranks all of them work on it.
"""

from contextlib import nullcontext
from importlib import import_module
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import image_of
from cea.heap import plain_heap
from cea.matrices import destroy
from cea.petsc import MPI, PETSc
from comparisons.bench import memory
from comparisons.bench.launch import answer_file
from comparisons.bench.solve.methods.method import Answer
from comparisons.bench.solve.methods.problem import Problem

_OURS = "this_driver"
"""The method whose memory is handled as this program does; other methods have what they are used
to."""
_LU_RUNS = 2
_EVENTS = {
    "factorisations": ("MatLUFactorNum", "MatCholFctrNum"),
    "analyses": ("MatLUFactorSym", "MatCholFctrSym"),
    "solves": ("MatSolve", "MatSolveTranspos"),
    "blocks": ("MatMatSolve", "MatMatTrSolve"),
}
"""What PETSc counts, by its own names."""


def answer(question: dict[str, Any]) -> dict[str, Any]:
    """Run a method and measure it.

    Returns
    -------
    dict
        ``eigenvalues``, kappa of the window (1/s^2) as pairs; ``backward_errors``; ``processor``
        seconds of all ranks, ``clock`` seconds; ``peak`` memory of all ranks (bytes), ``before``
        that of the matrices; ``lu``, processor seconds of a numeric factorisation; ``counts`` of
        what PETSc did; ``stages`` and ``claims`` of the method.
    """
    comm = MPI.COMM_WORLD
    memory.limit(question["memory"])
    PETSc.Log.begin()
    problem = Problem.read(Path(question["folder"]), question["wanted"])
    module = import_module(f"comparisons.bench.solve.methods.{question['method']}")
    arguments = [question["modes"]] if question["modes"] else []
    comm.Barrier()
    before, clock, worked = memory.held(), perf_counter(), process_time()
    with nullcontext() if question["method"] == _OURS else plain_heap():
        found: Answer = module.solve(problem, *arguments)
    worked, clock = process_time() - worked, perf_counter() - clock
    peak, counts = memory.largest(), _counts()
    found = found.inside(problem.top)
    return {
        "eigenvalues": [[float(k.real), float(k.imag)] for k in found.kappa],
        "backward_errors": backward_errors(problem, found).tolist(),
        "unknowns": int(problem.mass.getSize()[0]),
        "processor": comm.allreduce(worked),
        "clock": comm.allreduce(clock, MPI.MAX),
        "peak": comm.allreduce(peak),
        "before": comm.allreduce(before),
        "counts": counts,
        "stages": {name: comm.allreduce(value) for name, value in found.stages.items() if value},
        "claims": found.claims,
        "lu": comm.allreduce(lu_seconds(problem)),
    }


def backward_errors(problem: Problem, found: Answer) -> Floats:
    """|K x - kappa M x| / |kappa M x| of each pair, in the Euclidean norm."""
    comm = problem.mass.comm.tompi4py()
    K = problem.unsymmetric()
    stiff, heavy = (_image(matrix, found.vectors) for matrix in (K, problem.mass))
    destroy(K)
    heavy = heavy * found.kappa
    norms = (np.sum(np.abs(part) ** 2, axis=0) for part in (stiff - heavy, heavy))
    defect, size = (np.sqrt(comm.allreduce(part)) for part in norms)
    return np.asarray(defect / size)


def _image(matrix: Any, vectors: Complexes) -> Complexes:
    return image_of(matrix, vectors.real) + 1j * image_of(matrix, vectors.imag)


def lu_seconds(problem: Problem) -> float:
    """Processor seconds of a numeric factorisation at the shift on this rank, its order known.

    In memory that is new to it, as that of the first factorisation of a run is.
    """
    with plain_heap():
        return _lu_seconds(problem)


def _lu_seconds(problem: Problem) -> float:
    matrix = problem.shifted()
    pc: Any = PETSc.PC().create(matrix.comm)
    pc.setOperators(matrix)
    pc.setType(PETSc.PC.Type.LU)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setUp()
    taken = []
    for _ in range(_LU_RUNS):
        matrix.stateIncrease()  # a matrix that was touched is factorised anew
        pc.setOperators(matrix)
        begun = process_time()
        pc.setUp()
        taken.append(process_time() - begun)
    destroy(pc, matrix)
    return min(taken)


def _counts() -> dict[str, int]:
    """How often PETSc factorised and solved so far."""
    return {
        name: sum(int(PETSc.Log.Event(event).getPerfInfo()["count"]) for event in events)
        for name, events in _EVENTS.items()
    }


if __name__ == "__main__":
    answer_file(answer)
