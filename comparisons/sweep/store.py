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
from cea.arrays import Floats
from cea.eigen.pencil import Pencil
from cea.errors import ResultWarning
from cea.files import write_whole
from cea.reduced.pieces import Pieces
from cea.reduced.snapshots import Snapshot
from comparisons.sweep.scene import Mapped
from scenes.results.record import as_json

_ABOUT = "sweep.json"
_ARRAYS = (
    *("eigenvalues", "speeds", "uncertainties", "conditions"),
    *("right", "left", "forces", "left_forces"),
)
_PLACES = (0.0, 0.381966, 1.0)
"""Where between the ends of all fields coefficients are looked at."""


class Store:
    """The folder of an unfinished sweep; that of another one than ``about`` says is emptied."""

    def __init__(self, out: Path, about: Mapping[str, Any], comm: Any) -> None:
        self.folder = out.with_name(out.name + ".unfinished")
        self._comm, self._count = comm, 0
        if comm.rank == 0:
            told = json.dumps({**about, "ranks": comm.size}, sort_keys=True)
            file = self.folder / _ABOUT
            if not file.is_file() or file.read_text(encoding="utf-8") != told:
                shutil.rmtree(self.folder, ignore_errors=True)
                write_whole(told.encode(), file)
        comm.barrier()
        while comm.bcast(self._told(self._count).is_file()):
            self._count += 1
        self.stored = self._count

    def keep(self, solve: Snapshot) -> None:
        """Store a full solve; it counts once every rank has written."""
        arrays = {name: getattr(solve, name) for name in _ARRAYS}
        write_whole(_packed(arrays), self._arrays(self._count))
        self._comm.barrier()
        if self._comm.rank == 0:
            write_whole(json.dumps(solve.plain()).encode(), self._told(self._count))
        self._count += 1

    def solves(self) -> Iterator[Snapshot]:
        """Full solves that were stored, in their order."""
        for number in range(self._count):
            told = self._comm.bcast(
                json.loads(self._told(number).read_text()) if self._comm.rank == 0 else None
            )
            with np.load(self._arrays(number)) as stored:
                arrays: dict[str, Any] = {name: stored[name] for name in _ARRAYS}
            yield Snapshot(
                point=told["point"],
                complete=told["complete"],
                max_growth=np.inf if told["max_growth"] is None else told["max_growth"],
                warnings=tuple(ResultWarning(**each) for each in told["warnings"]),
                **arrays,
            )

    def keep_part(self, name: str, told: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
        """Store what is done: plain data and arrays, by the rank that made it."""
        text = np.frombuffer(json.dumps(told).encode(), dtype=np.uint8)
        write_whole(_packed({**arrays, "told": text}), self.folder / f"{name}.npz")

    def part(self, name: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]] | None:
        """What was stored by a name; None where there is nothing."""
        file = self.folder / f"{name}.npz"
        if not file.is_file():
            return None
        with np.load(file) as stored:
            arrays = dict(stored)
        return json.loads(arrays.pop("told").tobytes()), arrays

    def discard(self) -> None:
        """Remove the folder: its sweep is finished."""
        self._comm.barrier()
        if self._comm.rank == 0:
            shutil.rmtree(self.folder, ignore_errors=True)

    def _arrays(self, number: int) -> Path:
        return self.folder / f"solve-{number:04d}.rank{self._comm.rank}.npz"

    def _told(self, number: int) -> Path:
        return self.folder / f"solve-{number:04d}.json"


def _packed(arrays: Mapping[str, Any]) -> bytes:
    stream = BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def fingerprint(scene: Mapped) -> list[str]:
    """What a sweep rests on, number by number, the same on every rank."""
    pencil, free = scene.pencil, [name for names in scene.names for name in names]
    ends = np.array(scene.points.ends)
    places = [ends[:, 0] + part * (ends[:, 1] - ends[:, 0]) for part in _PLACES]
    values = [pencil.values(scene.point(place.tolist())) for place in places]
    window = (scene.max_frequency, scene.min_growth, scene.growth_threshold)
    pieces = Pieces(pencil, free)
    try:
        told = list(_products(pencil, pieces, values))
    finally:
        pieces.free()
    return [
        f"program {__version__}",
        *(f"{each.name} {each.value!r}" for each in pencil.parameters.values()),
        *told,
        f"window {window!r}",
        f"scene {sha256(as_json(scene.scene).encode()).hexdigest()}",
    ]


def _products(pencil: Pencil, pieces: Pieces, values: list[dict[str, float]]) -> Iterator[str]:
    """u^T A v of all pieces, and their coefficients."""
    rows = pencil.terms[0].matrix.getLocalSize()[0]
    first, comm = pencil.terms[0].matrix.getOwnershipRange()[0], pencil.comm.tompi4py()

    def product(times: Any, right: Floats, left: Floats) -> str:
        image = times(right)
        both = np.array([np.vdot(left, image), np.vdot(image, image)])
        inner, square = comm.bcast(comm.allreduce(both)).tolist()
        return f"{square:.6e} {inner / max(np.sqrt(square), 1e-300):.5f}"

    v, u = _tested(rows, first, 0), _tested(rows, first, 1)
    for piece in pieces.all:
        told = " ".join(f"{piece.coefficient.at(each):.10e}" for each in values)
        yield f"{piece.role} {piece.symmetric} {product(piece.times, v, u)} {told}"
    for contact in pieces.contacts:
        f = _tested(contact.closes.rows, contact.rows.start, 2)
        of_gaps = product(contact.closes.times, v, f)
        of_slip = "" if contact.slides is None else product(contact.slides.times, v, f)
        of_forces = product(contact.compliance, f, f)
        both = contact.inverse_stiffness, contact.friction
        told = " ".join(f"{each.at(at):.10e}" for each in both for at in values)
        yield f"forces {of_gaps} {of_slip} {of_forces} {told}"


def _tested(rows: int, first: int, which: int) -> Floats:
    """Rows of a vector that is the same each time, as a block of one column."""
    return np.random.default_rng((first, which)).standard_normal((rows, 1))
