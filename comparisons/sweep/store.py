"""Storage of full solves and finished lines of a sweep, from which an interrupted one resumes.

The folder is named like that of the result with the ending ``.unfinished``. It holds the full
solves (a file for each rank), from which the basis is rebuilt, and every finished line of points.
"""

import json
import pickle
import shutil
from collections.abc import Callable, Iterator, Mapping
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from cea import __version__
from cea.eigen.block_products import times
from cea.files import write_whole
from cea.petsc import Mat
from cea.reduced.greedy import FullSolve
from comparisons.sweep.scene import SweptScene
from scenes.results.record import as_json
from scenes.spec.plain import plain_data

_ABOUT = "sweep.json"


class Store:
    """The folder of an unfinished sweep; it is emptied if it belongs to another ``about``."""

    def __init__(self, out: Path, about: Mapping[str, Any], comm: Any) -> None:
        self.folder = out.with_name(out.name + ".unfinished")
        self._comm = comm
        if comm.rank == 0:
            told = json.dumps({**about, "ranks": comm.size}, sort_keys=True)
            file = self.folder / _ABOUT
            if not file.is_file() or file.read_text(encoding="utf-8") != told:
                shutil.rmtree(self.folder, ignore_errors=True)
                write_whole(told.encode(), file)
        comm.barrier()

    def once[T](self, name: str, make: Callable[[], T]) -> T:
        """Return the object that this rank stored under a name; make and store it without any."""
        file = self._file(name)
        if not file.is_file():
            write_whole(pickle.dumps(make()), file)
        stored: T = pickle.loads(file.read_bytes())
        return stored

    def keep_solve(self, number: int, solve: FullSolve) -> None:
        """Store a full solve; it is complete once every rank has written it."""
        write_whole(pickle.dumps(solve), self._solve(number))

    def solves(self) -> Iterator[FullSolve]:
        """Yield the stored full solves in their order."""
        for number in count():
            file = self._solve(number)
            if self._comm.allreduce(file.is_file()) < self._comm.size:
                return
            yield pickle.loads(file.read_bytes())

    def discard(self) -> None:
        """Remove the folder: its sweep is finished."""
        self._comm.barrier()
        if self._comm.rank == 0:
            shutil.rmtree(self.folder, ignore_errors=True)

    def _file(self, name: str) -> Path:
        return self.folder / f"{name}.rank{self._comm.rank}"

    def _solve(self, number: int) -> Path:
        return self._file(f"solve-{number:04d}")


def fingerprint(scene: SweptScene) -> list[str]:
    """Return data that identify a sweep, the same on every rank: its scene, and its matrices.

    A mesh or a matrix may have changed in its file, under the same name.
    """
    pencil = scene.pencil
    matrices = [term.matrix for term in pencil.terms]
    for each in pencil.forces:
        matrices += [each.closure, each.compliance, *filter(None, [each.slip])]
    norms = [_products(matrix) for matrix in matrices]
    given = sha256(as_json(plain_data(scene.assembled.scene)).encode()).hexdigest()
    fixed = [f"{each.name} {each.value!r}" for each in pencil.parameters.values()]
    return [f"program {__version__}", f"scene {given}", *fixed, *norms]


def _products(matrix: Mat) -> str:
    """Return the norm of A v and u^T A v for fixed vectors u, v: they see signs and order too."""
    rows, columns = matrix.getLocalSize()
    first = matrix.getOwnershipRange()[0]
    generator = np.random.default_rng(first)
    u, v = generator.standard_normal((rows, 1)), generator.standard_normal((columns, 1))
    image, comm = times(matrix, v), matrix.comm.tompi4py()
    inner, square = comm.allreduce(np.array([np.vdot(u, image), np.vdot(image, image)]))
    return f"{square:.6e} {inner / max(np.sqrt(square), 1e-300):.5f}"
