"""What a sweep has come to so far, on disk: an interrupted one goes on from there.

Beside the folder of the result stands one with the ending ``.unfinished``. It holds every full
solve, a file for each rank, and every part of the table of points that is done: bases are made
anew of the full solves. What the sweep rests on is told by matrices too, for a scene, a mesh or a
matrix may change under its name: each is multiplied from both sides by vectors that are the same
each time.
"""

import json
import shutil
from collections.abc import Iterator, Mapping
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea import __version__
from cea.files import write_whole
from cea.reduced.model import Snapshot
from cea.reduced.pieces import Pieces
from comparisons.sweep.scene import Mapped
from scenes.results.record import as_json

_ABOUT = "sweep.json"
_VECTORS = ("right", "left", "forces", "left_forces")
_ARRAYS = ("eigenvalues", "speeds", "uncertainties", "conditions", *_VECTORS)


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
        while comm.allreduce(self._file(self._solve(self.stored)).is_file()) == comm.size:
            self.stored += 1
        self._count = self.stored

    def keep(self, name: str, told: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
        """Store plain data and arrays by a name, on the rank that made them."""
        text, stream = np.frombuffer(json.dumps(told).encode(), dtype=np.uint8), BytesIO()
        np.savez(stream, told=text, **arrays)
        write_whole(stream.getvalue(), self._file(name))

    def part(self, name: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]] | None:
        """What was stored by a name; None where there is nothing."""
        if not self._file(name).is_file():
            return None
        with np.load(self._file(name)) as stored:
            arrays = dict(stored)
        return json.loads(arrays.pop("told").tobytes()), arrays

    def keep_solve(self, solve: Snapshot) -> None:
        """Store a full solve; it counts once every rank has written."""
        arrays = {name: getattr(solve, name) for name in _ARRAYS}
        self.keep(self._solve(self._count), solve.about, arrays)
        self._count += 1

    def solves(self) -> Iterator[Snapshot]:
        """Full solves that were stored, in their order."""
        for number in range(self._count):
            stored = self.part(self._solve(number))
            assert stored is not None
            yield Snapshot(stored[0], **stored[1])

    def discard(self) -> None:
        """Remove the folder: its sweep is finished."""
        self._comm.barrier()
        if self._comm.rank == 0:
            shutil.rmtree(self.folder, ignore_errors=True)

    def _solve(self, number: int) -> str:
        return f"solve-{number:04d}.rank{self._comm.rank}"

    def _file(self, name: str) -> Path:
        return self.folder / f"{name}.npz"


def fingerprint(scene: Mapped) -> list[str]:
    """What a sweep rests on, the same on every rank: u^T A v of its pieces, and its parameters."""
    pencil, free = scene.pencil, [name for names in scene.names for name in names]
    points = np.array(scene.points.ends).T
    values = [pencil.values(scene.point(each.tolist())) for each in (*points, points.mean(axis=0))]
    pieces = Pieces(pencil, free)
    first = pencil.terms[0].matrix.getOwnershipRange()[0]
    u, v = np.random.default_rng(first).standard_normal((2, pieces.rows, 1))
    told = []
    for piece in pieces.all:
        image = piece.times(v)
        both = np.array([np.vdot(u, image), np.vdot(image, image)])
        inner, square = pieces.comm.bcast(pieces.comm.allreduce(both)).tolist()
        sizes = f"{square:.6e} {inner / max(np.sqrt(square), 1e-300):.5f}"
        told.append(f"{sizes} {[f'{piece.coefficient.at(each):.10e}' for each in values]}")
    pieces.free()
    window = (scene.max_frequency, scene.min_growth, scene.growth_threshold)
    given = sha256(as_json(scene.scene).encode()).hexdigest()
    fixed = [f"{each.name} {each.value!r}" for each in pencil.parameters.values()]
    return [f"program {__version__}", f"window {window!r}", f"scene {given}", *fixed, *told]
