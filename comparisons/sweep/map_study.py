"""A map: eigenvalues of a scene over one or more parameters, by few full solves and a basis."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from cea.eigen.krylov_schur import KrylovSchur
from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from cea.reduced.branches import Branches
from cea.reduced.greedy import TOLERANCE, Enrichment, Snapshot
from cea.reduced.model import ReducedModel
from comparisons.sweep.axes import Axis
from comparisons.sweep.confirmed import confirmed
from comparisons.sweep.mapped import Mapped, mapped
from comparisons.sweep.rows import Row, map_row
from comparisons.sweep.store import Store
from comparisons.sweep.study import COMMAND
from scenes.stored import record

_TRAINING = 17
"""Values of an axis over decades at which bounds are looked at while the basis is made."""
_FEW = 5
"""The same of other axes."""
_ROUNDS = 4
"""Times that full solves may find fault with a basis before it is given up."""
_LOCAL = 0.5
"""Part of the tolerance that a local basis may use up."""


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
    """

    scene: str | Path
    axes: tuple[Axis, ...]
    overrides: tuple[str, ...] = ()
    data: str | None = None
    tolerance: float = TOLERANCE
    most: int = 150
    checks: int = 2
    confirm: int = 3

    def __post_init__(self) -> None:
        if not self.axes:
            raise InputError("axis", [], "one or more, e.g. mu=0:1:101")
        if not 1e-13 <= self.tolerance <= 1e-2:
            raise InputError("tolerance", self.tolerance, "1e-13 to 1e-2")
        for name, least in (("solves", 2), ("checks", 0), ("confirm", 0)):
            value = self.most if name == "solves" else getattr(self, name)
            if value < least:
                raise InputError(name, value, f"{least} or more")

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
    ConvergenceError
        When full solves keep passing the bounds.
    """
    begun = perf_counter()
    scene = mapped(asked.scene, asked.axes, asked.overrides, asked.data)
    size = scene.pencil.terms[0].matrix.getSize()[0]
    store = Store(out, asked.plain() | {"unknowns": size}, MPI.COMM_WORLD)
    run = _Run(asked, scene, store, progress)
    try:
        run.fill()
        rows = run.rows()
        data = run.told(rows)
    finally:
        run.free()
    seconds = perf_counter() - begun
    warnings = run.warnings(data)
    told = record(COMMAND, data, inputs=asked.plain(), seconds=seconds, warnings=warnings)
    return told, rows, store


class _Run:
    """One run: a basis, tested, and the rows made with it."""

    def __init__(
        self, asked: AskedMap, scene: Mapped, store: Store, progress: Callable[[str], None]
    ) -> None:
        self._asked, self._scene, self._store, self._progress = asked, scene, store, progress
        self._model = ReducedModel(scene.pencil, scene.box, scene.max_frequency)
        self._full = _Timed(scene.driver)
        self._basis = Enrichment(
            self._model,
            self._full,
            scene.max_frequency,
            asked.tolerance,
            asked.most,
            keep=self._keep,
            tell=self._tell,
        )
        self._online = (0.0, 0)
        self._kept = 0
        self._begun = process_time()
        for snapshot, safety in store.snapshots():
            progress(f"full solve {len(self._basis.snapshots) + 1}, stored before")
            self._kept += 1
            try:
                self._basis.restore(snapshot, safety)
            except ValueError as error:
                allowed = f"without what an interrupted sweep of something else left ({error})"
                raise InputError("out", str(store.folder), allowed) from error

    def fill(self) -> None:
        """Enrich the basis until bounds are small and full solves agree with them."""
        generator = np.random.default_rng(0)
        for _ in range(_ROUNDS):
            self._basis.cover(self._training())
            if len(self._basis.snapshots) >= self._asked.most:
                return
            picked = [
                [axis.values[generator.integers(axis.count)] for axis in self._asked.axes]
                for _ in range(self._asked.checks)
            ]
            if self._basis.confirm([self._scene.point(each) for each in picked]):
                return
        raise ConvergenceError(
            f"full solves found modes or errors that the reduced model had not told of, "
            f"{_ROUNDS} times; more solves at first, or a lower max_frequency, may help"
        )

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
            failed = [point for point, _ in self._basis.failed]
            points = [self._point(i, others[number]) for _, number, i in sorted(open_)[::-1]]
            points = [point for point in points if point not in failed]
            if not points or len(self._basis.snapshots) >= self._asked.most:
                return [rows[number] for number in range(len(others))]
            size = self._model.size
            self._basis.cover(points)
            if size == self._model.size:
                return [rows[number] for number in range(len(others))]
            for number in {number for _, number, _ in open_}:
                del rows[number]

    def _make(self, rows: dict[int, Row], others: Sequence[tuple[float, ...]]) -> None:
        """Rows that are not there yet, shared out among the ranks."""
        comm = MPI.COMM_WORLD
        starts = self._starts(others)
        missing = [number for number in range(len(others)) if number not in rows]
        made: dict[int, Row] = {}
        for number in missing[comm.rank :: comm.size]:
            row = self._store.row(number)
            if row is None or row.worst.max(initial=0.0) > self._asked.tolerance:
                self._progress(f"row {number + 1} of {len(others)}")
                before = process_time()
                row = map_row(
                    self._model.small,
                    self._scene,
                    others[number],
                    starts[number],
                    _LOCAL * self._asked.tolerance,
                )
                spent, values = self._online
                self._online = spent + process_time() - before, values + len(row.worst)
                self._store.keep_row(number, row)
            made[number] = row
        for part in comm.allgather(made):
            rows.update(part)

    def _starts(self, others: Sequence[tuple[float, ...]]) -> list[tuple[Any, int]]:
        """Branches at the first value of each row, and a number that no other row begins at."""
        first, branches, numbers = self._asked.axes[0].values[0], Branches(), []
        for each in others:
            found = self._basis.at(self._scene.point((first, *each)))
            numbers.append(branches.follow(found))
        room = 10 * max(len(each) for each in numbers) + 10
        return [(each, branches.next + i * room) for i, each in enumerate(numbers)]

    def _training(self) -> list[dict[str, float]]:
        chosen = []
        for axis in self._asked.axes:
            most = _TRAINING if axis.ends[1] > 100 * abs(axis.ends[0]) > 0 else _FEW
            number = np.unique(np.linspace(0, axis.count - 1, min(most, axis.count)).round())
            chosen.append([axis.values[int(i)] for i in number])
        return [self._scene.point(each) for each in product(*chosen)]

    def _point(self, number: int, others: Sequence[float]) -> dict[str, float]:
        return self._scene.point((self._asked.axes[0].values[number], *others))

    def _keep(self, snapshot: Snapshot) -> None:
        self._store.keep(snapshot, self._model.small.settings.safety)

    def _tell(self, point: Any, worst: float) -> None:
        shown = ", ".join(f"{name} = {value:.4g}" for name, value in point.items())
        self._progress(f"full solve {len(self._basis.snapshots) + 1}: {shown}, bound {worst:.1e}")

    def told(self, rows: Sequence[Row]) -> dict[str, Any]:
        """What the map is, without its values."""
        axes = self._asked.axes
        scene, basis = self._scene, self._basis
        full = process_time() - self._begun
        onsets = [
            {
                **{axis.name: value for axis, value in zip(axes[1:], others, strict=True)},
                "value": each.value,
                "error": each.error,
                "frequency": each.eigenvalue.imag / (2 * np.pi),
                "slope": each.slope,
                "begins": each.begins,
            }
            for others, row in zip(scene.rows(), rows, strict=True)
            for each in row.onsets
        ]
        places = [
            (onset, others)
            for others, row in zip(scene.rows(), rows, strict=True)
            for onset in row.onsets
        ]
        for number in _spread(len(places), self._asked.confirm):
            self._progress(f"threshold {number + 1} of {len(places)}, solved in full")
            onset, others = places[number]
            point = scene.point((onset.value, *others))
            onsets[number]["full_solve_differs"] = confirmed(scene.driver, point, onset)
        worst = np.concatenate([row.worst for row in rows])
        spent, values = self._online
        return {
            "axes": [{"name": axis.name, "values": axis.values} for axis in axes],
            "parameters": [list(each) for each in scene.names],
            "unknowns": scene.pencil.terms[0].matrix.getSize()[0],
            "max_frequency": scene.max_frequency,
            "basis": self._model.size,
            "snapshots": [
                {
                    "point": dict(each.point),
                    "tested": each.tested,
                    "complete": bool(each.complete),
                }
                for each in basis.snapshots
            ],
            "stored_before": self._kept,
            "failed": [{"point": dict(point), "reason": why} for point, why in basis.failed],
            "values": len(worst),
            "certified": int((worst <= self._asked.tolerance).sum()),
            "worst": float(worst.max(initial=0.0)),
            "onsets": onsets,
            "processor_seconds": {
                "full_solves": self._full.seconds,
                "basis": max(full - self._full.seconds - spent, 0.0),
                "values": spent,
                "a_value": spent / values if values else 0.0,
            },
        }

    def warnings(self, data: dict[str, Any]) -> list[dict[str, Any]]:
        """What the map must be read with."""
        found: list[tuple[str, str]] = []
        if data["certified"] < data["values"]:
            left = data["values"] - data["certified"]
            found.append(
                (
                    "not-certified",
                    f"{left} of {data['values']} values are not certified to "
                    f"{self._asked.tolerance:g}: their bounds say how far they may be off",
                )
            )
        if data["failed"]:
            found.append(("no-answer", f"{len(data['failed'])} full solves gave no answer"))
        incomplete = sum(not each["complete"] for each in data["snapshots"])
        if incomplete:
            found.append(
                (
                    "window-not-complete",
                    f"the windows of {incomplete} of {len(data['snapshots'])} full solves were not "
                    "shown to be complete",
                )
            )
        return [{"kind": kind, "message": message, "data": {}} for kind, message in found]

    def free(self) -> None:
        """Free factors."""
        self._model.free()
        self._scene.driver.free()


class _Timed:
    """A driver whose processor time is counted."""

    def __init__(self, driver: KrylovSchur) -> None:
        self._driver, self.seconds = driver, 0.0

    def solve(self, max_frequency: float, changes: Any, /, *, left: bool = False) -> Any:
        """All modes up to a frequency (Hz)."""
        before = process_time()
        try:
            return self._driver.solve(max_frequency, changes, left=left)
        finally:
            self.seconds += process_time() - before


def _spread(count: int, chosen: int) -> list[int]:
    """Some numbers below a count, far apart."""
    return np.unique(np.linspace(0, count - 1, min(chosen, count)).round()).astype(int).tolist()
