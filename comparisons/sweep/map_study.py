"""A map: eigenvalues of a scene over one or more parameters, by few full solves and a basis."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from cea.errors import InputError
from cea.petsc import MPI
from cea.ranks import agreed
from cea.reduced.branches import Branches
from cea.reduced.greedy import TOLERANCE, Enrichment
from comparisons.sweep.axes import Axis
from comparisons.sweep.bands import Bands
from comparisons.sweep.filling import AT_FIRST, Filling, check_effort
from comparisons.sweep.fingerprints import fingerprint
from comparisons.sweep.map_record import Spent, confirm_some, record_of, warnings_of
from comparisons.sweep.map_words import words_where_most_grows
from comparisons.sweep.mapped import Mapped, mapped
from comparisons.sweep.rows import Row, Start, map_row
from comparisons.sweep.store import Store
from comparisons.sweep.study import COMMAND
from comparisons.sweep.thrift import BasisTooDearError, Thrift
from scenes.results.record import record

_TRAINING = 17
"""Values of an axis over decades at which bounds are looked at while the basis is made."""
_FEW = 5
"""The same of other axes."""
_MENDED = 3
"""Values of a row that the basis of its band takes in, at most, where some are not certified."""


@dataclass(frozen=True)
class AskedMap:
    """What is mapped, and how well.

    Parameters
    ----------
    scene
        Name of a scene, or its file.
    axes
        The axes; along the first one branches are followed and thresholds sought.
    overrides
        Other fields, as ``--set`` takes them.
    data
        Folder of the files of a scene of matrices.
    tolerance
        Error of lambda, relative to its speed, up to which a value is certified.
    most
        Most full solves.
    checks
        Full solves at random values of the map that test it in the end.
    confirm
        Thresholds that full solves confirm.
    thrifty
        Whether the basis is given up where full solves at all values are cheaper.
    """

    scene: str | Path
    axes: tuple[Axis, ...]
    overrides: tuple[str, ...] = ()
    data: str | None = None
    tolerance: float = TOLERANCE
    most: int = 150
    checks: int = 2
    confirm: int = 3
    thrifty: bool = False

    def __post_init__(self) -> None:
        if not self.axes:
            raise InputError("axis", [], "one or more, e.g. mu=0:1:101")
        check_effort(
            self.tolerance,
            solves=(self.most, 2),
            checks=(self.checks, 0),
            confirm=(self.confirm, 0),
        )

    def plain(self) -> dict[str, Any]:
        """It as plain data."""
        return {
            "scene": str(self.scene),
            "axes": [dict(axis.plain()) for axis in self.axes],
            "set": list(self.overrides),
            "data": self.data,
            "tolerance": self.tolerance,
            "solves": self.most,
            "checks": self.checks,
            "confirm": self.confirm,
        }


def run_map(
    asked: AskedMap, out: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[dict[str, Any], list[Row], Store]:
    """Make a map; what an interrupted one left beside ``out`` is used again.

    Parameters
    ----------
    asked
        What is mapped.
    out
        Folder of the result.
    progress
        Called with what begins.

    Returns
    -------
    tuple
        The record, the rows, and the store, to be discarded once the result is written.

    Raises
    ------
    InputError
        When the scene has no reduced model over these axes.
    BasisTooDearError
        When full solves at all values are cheaper, where the map is to be thrifty.
    ConvergenceError
        When full solves keep passing the bounds.
    """
    begun = perf_counter()
    scene = mapped(asked.scene, asked.axes, asked.overrides, asked.data)
    store = Store(out, asked.plain() | {"pencil": fingerprint(scene)}, MPI.COMM_WORLD)
    run = _Run(asked, scene, store, progress)
    try:
        run.fill()
        rows = run.rows()
        data = run.told(rows)
        data["words"] = words_where_most_grows(data, rows, scene.growth_threshold)
        confirm_some(data, scene, run.basis, rows, asked.confirm, progress)
    except BasisTooDearError:
        store.discard()
        raise
    finally:
        run.free()
    seconds = perf_counter() - begun
    warnings = warnings_of(data, asked.tolerance)
    told = record(COMMAND, data, inputs=asked.plain(), seconds=seconds, warnings=warnings)
    return told, rows, store


class _Run:
    """One run: a basis, tested, and the rows made with it."""

    def __init__(
        self, asked: AskedMap, scene: Mapped, store: Store, progress: Callable[[str], None]
    ) -> None:
        self._asked, self._scene, self._store, self._progress = asked, scene, store, progress
        self._filling = Filling(asked, scene, store, progress, self._thrift())
        self._online = (0.0, 0)
        self._bands = Bands(scene, asked.tolerance)

    def _thrift(self) -> Thrift | None:
        """What weighs the basis beside full solves, where that is asked for."""
        asked, scene = self._asked, self._scene
        if not asked.thrifty:
            return None
        values = int(np.prod([axis.count for axis in asked.axes]))

        def plain() -> float:
            self._progress("a full solve for its values alone, to see whether a basis pays")
            before = process_time()
            point = scene.point([axis.values[axis.count // 2] for axis in asked.axes])
            scene.driver.solve(scene.max_frequency, point, min_growth=scene.min_growth)
            return float(MPI.COMM_WORLD.bcast(process_time() - before))

        return Thrift(values, AT_FIRST * asked.tolerance, asked.checks, plain)

    def fill(self) -> None:
        """Enrich the basis until bounds are small and full solves agree with them."""
        generator = np.random.default_rng(0)

        def picked() -> list[dict[str, float]]:
            values = [
                [axis.values[generator.integers(len(axis.values))] for axis in self._scene.axes]
                for _ in range(self._asked.checks)
            ]
            return [self._scene.point(each) for each in values]

        self._filling.fill(self._training(), picked)

    def rows(self) -> list[Row]:
        """All rows; where a value is not certified the pencil itself is solved."""
        rows: dict[int, Row] = {}
        others = self._scene.rows()
        while True:
            self._make(rows, others)
            open_ = [
                (float(row.worst[i]), number, i)
                for number, row in rows.items()
                for i in np.flatnonzero(row.worst > self._asked.tolerance).tolist()
            ]
            points = [self._point(i, others[number]) for _, number, i in sorted(open_)[::-1]]
            if not self._filling.improve(points):
                return [rows[number] for number in range(len(others))]
            for number in {number for _, number, _ in open_}:
                del rows[number]

    def _make(self, rows: dict[int, Row], others: Sequence[tuple[float, ...]]) -> None:
        """Rows that are not there yet, shared out among the ranks."""
        comm = MPI.COMM_WORLD
        starts = self._starts(others)
        missing = [number for number in range(len(others)) if number not in rows]
        made: dict[int, Row] = {}
        with agreed(comm):
            for number in np.array_split(missing, comm.size)[comm.rank].tolist():
                made[number] = self._row(number, others, starts[number])
        for part in comm.allgather(made):
            rows.update(part)

    def _row(self, number: int, others: Sequence[tuple[float, ...]], start: Start) -> Row:
        """A row that was stored and is certified, or a new one."""
        row = self._store.row(number)
        if row is not None and row.worst.max(initial=0.0) <= self._asked.tolerance:
            return row
        self._progress(f"row {number + 1} of {len(others)}")
        before = process_time()
        tolerance = self._asked.tolerance
        small = self._filling.model.small
        band = self._bands.of(number, small)
        row = map_row(band, self._scene, others[number], start, tolerance)
        if row.worst.max(initial=0.0) > tolerance:
            self._bands.mend(number, _worst_apart(row, self._scene.axes[0].values, tolerance))
            band, whole = self._bands.of(number, small), self._bands.whole
            row = map_row(band, self._scene, others[number], start, tolerance, whole)
        spent, values = self._online
        self._online = spent + process_time() - before, values + len(row.worst)
        self._store.keep_row(number, row)
        return row

    def _starts(self, others: Sequence[tuple[float, ...]]) -> list[Start]:
        """Branches at the first value of each row, and a number that no other row begins at."""
        first, branches, numbers = self._asked.axes[0].values[0], Branches(), []
        for each in others:
            at = self._scene.pencil.values(self._scene.point((first, *each)))
            found = self._filling.model.small.at(at)
            numbers.append((found, branches.follow(found)))
        room = 10 * max(len(found) for found, _ in numbers) + 10
        return [(*each, branches.next + i * room) for i, each in enumerate(numbers)]

    def _training(self) -> list[dict[str, float]]:
        chosen = []
        for axis in self._asked.axes:
            most = _TRAINING if axis.ends[1] > 100 * abs(axis.ends[0]) > 0 else _FEW
            number = np.unique(np.linspace(0, axis.count - 1, min(most, axis.count)).round())
            chosen.append([axis.values[int(i)] for i in number])
        return [self._scene.point(each) for each in product(*chosen)]

    def _point(self, number: int, others: Sequence[float]) -> dict[str, float]:
        return self._scene.point((self._asked.axes[0].values[number], *others))

    def told(self, rows: Sequence[Row]) -> dict[str, Any]:
        """What the map is, without its values."""
        spent, values = self._online
        full, basis = self._filling.seconds(spent)
        took = Spent(full, basis, spent, values, self._filling.kept)
        return record_of(self._scene, self._filling.basis, rows, took)

    @property
    def basis(self) -> Enrichment:
        """What the map rests on."""
        return self._filling.basis

    def free(self) -> None:
        """Free factors."""
        self._filling.free()


def _worst_apart(row: Row, values: Sequence[float], tolerance: float) -> list[float]:
    """Values of a row that are not certified, the worst of each third of it."""
    worst = []
    for numbers in np.array_split(np.arange(len(values)), min(_MENDED, len(values))):
        number = int(numbers[np.argmax(row.worst[numbers])])
        if row.worst[number] > tolerance:
            worst.append(values[number])
    return worst
