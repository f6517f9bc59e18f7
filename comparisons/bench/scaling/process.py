"""One run in a process of its own: ``python -m comparisons.bench.scaling.process FILE``.

The file holds a case as plain data; the answer takes its place.
"""

from time import perf_counter, process_time
from typing import Any

from cea.petsc import MPI
from comparisons.bench import memory
from comparisons.bench.launch import answer_file
from comparisons.bench.scaling.cases import scene_of
from scenes import run_modes


def answer(case: dict[str, Any]) -> dict[str, Any]:
    """Run a case.

    Returns
    -------
    dict
        ``unknowns``; of each stage ``processor``, seconds of all ranks, and ``busiest``, those of
        the rank that worked longest; of the run ``whole``, seconds of the clock, and ``longest``,
        those of the rank that worked longest; ``peak`` memory of all ranks and ``program``, that
        before the run (bytes); ``eigenvalues`` lambda (1/s) as pairs.
    """
    comm = MPI.COMM_WORLD
    scene = scene_of(case)
    comm.Barrier()
    program, begun, worked = memory.held(), perf_counter(), process_time()
    result = run_modes(scene)
    whole, worked = perf_counter() - begun, process_time() - worked
    stages = result.timer.processor_seconds
    return {
        "unknowns": result.system.size,
        "processor": {name: comm.allreduce(s) for name, s in stages.items()},
        "busiest": {name: comm.allreduce(s, MPI.MAX) for name, s in stages.items()},
        "whole": comm.allreduce(whole, MPI.MAX),
        "longest": comm.allreduce(worked, MPI.MAX),
        "peak": comm.allreduce(memory.largest()),
        "program": comm.allreduce(program),
        "eigenvalues": [[float(v.real), float(v.imag)] for v in result.eigenvalues],
    }


if __name__ == "__main__":
    answer_file(answer)
