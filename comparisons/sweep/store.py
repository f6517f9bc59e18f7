"""Full solves of a sweep so far, on disk: an interrupted one goes on from there.

Beside the folder of the result stands one with the ending ``.unfinished``. It holds every full
solve, a file for each rank: the basis is made anew of them.
"""

import json
import pickle
import shutil
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from cea import __version__
from cea.files import write_whole
from cea.reduced.model import Snapshot
from comparisons.sweep.scene import SweptScene
from scenes.results.record import as_json
from scenes.spec.plain import as_data

_ABOUT = "sweep.json"


class Store:
    """The folder of an unfinished sweep; that of another one than ``about`` says is emptied."""

    def __init__(self, out: Path, about: Mapping[str, Any], comm: Any) -> None:
        self.folder = out.with_name(out.name + ".unfinished")
        self._comm, self.stored = comm, 0
        if comm.rank == 0:
            told = json.dumps({**about, "ranks": comm.size}, sort_keys=True)
            file = self.folder / _ABOUT
            if not file.is_file() or file.read_text(encoding="utf-8") != told:
                shutil.rmtree(self.folder, ignore_errors=True)
                write_whole(told.encode(), file)
        comm.barrier()
        while comm.allreduce(self._file(self.stored).is_file()) == comm.size:
            self.stored += 1
        self._count = self.stored

    def keep(self, solve: Snapshot) -> None:
        """Store a full solve; it counts once every rank has written."""
        write_whole(pickle.dumps(solve), self._file(self._count))
        self._count += 1

    def solves(self) -> Iterator[Snapshot]:
        """Full solves that were stored, in their order."""
        for number in range(self.stored):
            yield pickle.loads(self._file(number).read_bytes())

    def discard(self) -> None:
        """Remove the folder: its sweep is finished."""
        self._comm.barrier()
        if self._comm.rank == 0:
            shutil.rmtree(self.folder, ignore_errors=True)

    def _file(self, number: int) -> Path:
        return self.folder / f"solve-{number:04d}.rank{self._comm.rank}"


def fingerprint(scene: SweptScene) -> list[str]:
    """What a sweep rests on, the same on every rank: its scene, and norms of its matrices.

    A mesh or a matrix may change in its file, under the same name.
    """
    pencil = scene.pencil
    matrices = [term.matrix for term in pencil.terms]
    for each in pencil.forces:
        matrices += [each.closure, each.compliance]
    norms = [f"{matrix.norm():.9e}" for matrix in matrices]
    given = sha256(as_json(as_data(scene.assembled.scene)).encode()).hexdigest()
    fixed = [f"{each.name} {each.value!r}" for each in pencil.parameters.values()]
    return [f"program {__version__}", f"scene {given}", *fixed, *norms]
