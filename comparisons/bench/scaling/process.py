"""One run in a process of its own: ``python -m comparisons.bench.scaling.process FILE``.

The file holds a case as plain data; the answer takes its place.
"""

from time import perf_counter
from typing import Any

from cea.petsc import MPI
from comparisons.bench import memory
from comparisons.bench.launch import answer_file
from comparisons.bench.scaling.cases import scene_of
from scenes.run import run_modes


def answer(case: dict[str, Any]) -> dict[str, Any]:
    """Run a case.

    Returns
    -------
    dict
        ``unknowns``; ``clock``, seconds of each stage on the slowest rank, ``processor``, those of
        all ranks; ``whole``, seconds of the run by the clock; ``peak`` memory of all ranks and
        ``program``, that before the run (bytes); ``eigenvalues`` lambda (1/s) as pairs.
    """
    comm = MPI.COMM_WORLD
    scene = scene_of(case)
    comm.Barrier()
    program, begun = memory.held(), perf_counter()
    result = run_modes(scene)
    whole = perf_counter() - begun
    timer = result.timer
    return {
        "unknowns": result.system.size,
        "clock": {name: comm.allreduce(s, MPI.MAX) for name, s in timer.seconds.items()},
        "processor": {name: comm.allreduce(s) for name, s in timer.processor_seconds.items()},
        "whole": comm.allreduce(whole, MPI.MAX),
        "peak": comm.allreduce(memory.largest()),
        "program": comm.allreduce(program),
        "eigenvalues": [[float(v.real), float(v.imag)] for v in result.eigenvalues],
    }


if __name__ == "__main__":
    answer_file(answer)
