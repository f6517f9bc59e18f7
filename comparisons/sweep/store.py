"""What a map has come to so far, on disk: an interrupted one goes on from there.

Beside the folder of the result stands one with the ending ``.unfinished``. It holds what each full
solve added to the bases, a file for each rank, the pencil on the basis with the last of them, so
that nothing of either is computed again, and each row of the map as netCDF.
"""

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cea.files import write_whole
from cea.reduced.greedy import Snapshot
from cea.reduced.model import Growth
from cea.reduced.stored import Arrays
from cea.warned import ResultWarning
from comparisons.sweep.netcdf import ENGINE, INTERVALS, plain, threshold_of, unresolved_of
from comparisons.sweep.rows import Row

_ABOUT = "map.json"
_FIELDS = ("growth", "frequency", "uncertainty", "mean_error", "branch", "verdict", "worst")
_SLOPES = ("growth_slope", "frequency_slope")
_ABOVE = ("above_growth", "above_frequency")


class Store:
    """The folder of an unfinished map.

    Parameters
    ----------
    out
        Folder of the result.
    asked
        What the map is, as plain data; a folder of another one is emptied.
    comm
        Communicator (mpi4py).
    """

    def __init__(self, out: Path, asked: Mapping[str, Any], comm: Any) -> None:
        self.folder = out.with_name(out.name + ".unfinished")
        self._comm, self._count = comm, 0
        if comm.rank == 0:
            about = json.dumps({**asked, "ranks": comm.size}, sort_keys=True)
            file = self.folder / _ABOUT
            if not file.is_file() or file.read_text(encoding="utf-8") != about:
                shutil.rmtree(self.folder, ignore_errors=True)
                write_whole(about.encode(), file)
        comm.barrier()

    def keep(self, snapshot: Snapshot, small: Arrays) -> None:
        """Store a snapshot and the pencil on the basis; it counts once every rank has written."""
        grown = snapshot.grown
        blocks = grown.vectors, grown.residuals, *grown.forces
        with self._part(self._count).open("wb") as stream:
            np.savez(stream, *blocks)
        self._comm.barrier()
        if self._comm.rank == 0:
            with self._small(self._count).open("wb") as stream:
                np.savez(stream, **small)  # type: ignore[arg-type]
            write_whole(json.dumps(snapshot.plain()).encode(), self._told(self._count))
            self._small(self._count - 1).unlink(missing_ok=True)
        self._count += 1

    def arrays(self) -> Arrays:
        """The pencil on the basis, with the last snapshot."""
        found = None
        if self._comm.rank == 0:
            with np.load(self._small(self._count - 1)) as stored:
                found = dict(stored)
        arrays: Arrays = self._comm.bcast(found)
        return arrays

    def snapshots(self) -> list[Snapshot]:
        """Snapshots that were stored, in their order."""
        found = []
        while self._comm.bcast(self._told(self._count).is_file()):
            told = self._comm.bcast(json.loads(self._told(self._count).read_text()))
            with np.load(self._part(self._count)) as stored:
                vectors, residuals, *forces = (stored[name] for name in stored.files)
            grown = Growth(vectors, residuals, tuple(forces))
            fields = {name: told[name] for name in ("point", "rounding", "tested", "complete")}
            warnings = tuple(ResultWarning(**each) for each in told["warnings"])
            found.append(Snapshot(grown=grown, warnings=warnings, **fields))
            self._count += 1
        return found

    def keep_row(self, number: int, row: Row) -> None:
        """Store a row of the map, by the rank that made it."""
        import xarray

        over = ("value", "mode")
        data = {
            "growth": (over, row.growth),
            "frequency": (over, row.frequency),
            "uncertainty": (over, row.uncertainty),
            "mean_error": (over, row.mean_error),
            "branch": (over, row.branch),
            "verdict": (over, row.verdict),
            "worst": (("value",), row.worst),
            **{name: ((*over, "axis"), getattr(row, name)) for name in _SLOPES},
            **{name: (("value",), getattr(row, name)) for name in _ABOVE},
        }
        told = {
            kind: json.dumps([plain(each) for each in getattr(row, kind)]) for kind in INTERVALS
        }
        file = self._row(number)
        part = file.with_suffix(f".{os.getpid()}.part")
        attributes = told | {"resolution": row.resolution}
        xarray.Dataset(data, attrs=attributes).to_netcdf(part, engine=ENGINE)
        part.replace(file)

    def row(self, number: int) -> Row | None:
        """A row that was stored; None where there is none."""
        import xarray

        if not self._row(number).is_file():
            return None
        with xarray.open_dataset(self._row(number), engine=ENGINE) as data:
            get: dict[str, Any] = {name: np.array(data[name]) for name in data.variables}
            told = dict(data.attrs)
        fields = {name: get[name] for name in (*_FIELDS, *_SLOPES, *_ABOVE)}
        thresholds = tuple(map(threshold_of, json.loads(told["thresholds"])))
        unresolved = tuple(map(unresolved_of, json.loads(told["unresolved"])))
        return Row(
            **fields,
            thresholds=thresholds,
            unresolved=unresolved,
            resolution=float(told["resolution"]),
        )

    def discard(self) -> None:
        """Remove the folder: its map is finished."""
        self._comm.barrier()
        if self._comm.rank == 0:
            shutil.rmtree(self.folder, ignore_errors=True)

    def _part(self, number: int) -> Path:
        return self.folder / f"grown-{number:04d}.rank{self._comm.rank}.npz"

    def _small(self, number: int) -> Path:
        return self.folder / f"small-{number:04d}.npz"

    def _told(self, number: int) -> Path:
        return self.folder / f"snapshot-{number:04d}.json"

    def _row(self, number: int) -> Path:
        return self.folder / f"row-{number:05d}.nc"
