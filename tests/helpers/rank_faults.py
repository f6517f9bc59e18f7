"""What each rank hears when only the last one meets a fault, by kind of fault."""

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from cea.ranks import agreed
from scenes.spec.problems import SceneError


class UnpackableError(Exception):
    """A fault that cannot travel."""

    def __init__(self, first, second):
        super().__init__(first + second)


FAULTS = {
    "InputError": InputError("mu", -1.0, "zero or positive"),
    "SceneError": SceneError([InputError("mu", -1.0, "zero or positive")]),
    "ConvergenceError": ConvergenceError("none", best=lambda: None),
    "ZeroDivisionError": ZeroDivisionError("by zero"),
    "MemoryError": MemoryError(),
    "UnpackableError": UnpackableError("a", "b"),
}


def every():
    """Names of the errors that each rank hears, by kind of the fault."""
    comm = MPI.COMM_WORLD
    return {kind: comm.allgather(_heard(fault, comm)) for kind, fault in FAULTS.items()}


def _heard(fault, comm):
    try:
        with agreed(comm):
            if comm.rank == comm.size - 1:
                raise fault
    except Exception as error:
        return type(error).__name__
    return None
