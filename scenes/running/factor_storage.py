"""Where the factors of a scene are kept: in memory, or on disk where memory would not do."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any, Literal

from cea.eigen.mumps import factors_on_disk
from cea.petsc import MPI
from cea.warned import ResultWarning
from scenes.checking.memory import (
    MemoryEstimate,
    available_memory,
    estimated_memory,
    may_be_on_disk,
    on_all_machines,
)
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class FactorStorage:
    """Where factors are kept, and why.

    Parameters
    ----------
    place
        In memory or on disk.
    estimate
        Memory that the scene needs.
    available
        Memory that it may have (bytes).
    """

    place: Literal["memory", "disk"]
    estimate: MemoryEstimate
    available: float

    def kept(self) -> AbstractContextManager[Any]:
        """What factorisations are made in."""
        return factors_on_disk() if self.place == "disk" else nullcontext()

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """That factors were on disk, where they were."""
        if self.place == "memory":
            return ()
        data = {
            "memory": self.estimate.bytes,
            "available": self.available,
            "memory_with_files": self.estimate.bytes_with_files,
            "files": self.estimate.files,
        }
        message = (
            f"factors were kept on disk, about {data['files'] / 1e9:.3g} GB: in memory the scene "
            f"takes about {data['memory'] / 1e9:.3g} GB of {self.available / 1e9:.3g} GB"
        )
        return (ResultWarning("factors-on-disk", message, data),)


def factor_storage(scene: Scene, comm: Any = MPI.COMM_WORLD) -> FactorStorage:
    """Where the factors of a scene go; collective.

    Parameters
    ----------
    scene
        A scene that :func:`scenes.checking.memory.check_memory` lets pass.
    comm
        Communicator (mpi4py) of the ranks that run it.
    """
    estimate, available = estimated_memory(scene), on_all_machines(available_memory, comm)
    fits = estimate.bytes <= available or not may_be_on_disk(scene)
    return FactorStorage("memory" if fits else "disk", estimate, available)
