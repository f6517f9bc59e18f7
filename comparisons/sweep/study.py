"""A sweep: modes of a scene at a table of points, by a reduced model or by full solves."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Ints
from cea.errors import ConvergenceError, require
from cea.petsc import MPI
from cea.ranks import agreed
from cea.reduced.crossings import Threshold
from cea.reduced.full_solves import SpectraAlong, confirm, line_of_model
from cea.reduced.greedy import TOLERANCE, Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.spectrum import ReducedSpectrum
from cea.reduced.thresholds import thresholds_along
from comparisons.study.run_warnings import Run
from comparisons.sweep.points import Axis, Field, Points, as_plain
from comparisons.sweep.probabilities import continued, probabilities
from comparisons.sweep.record import FoundAlong, between_points, common_record, warnings_of
from comparisons.sweep.scene import NoMapError, SweptScene, in_full, mapped
from comparisons.sweep.spectra import Spectra, row_of_model, row_of_result
from comparisons.sweep.store import Store, fingerprint
from scenes.checking.memory import factors_of
from scenes.results.record import record
from scenes.running.assembled import AssembledScene

COMMAND = "sweep"
_AT_FIRST = 0.5
"""Target of error bounds at the training points relative to the tolerance; elsewhere they are
larger."""
_MOST_SAMPLES = 1_000_000
_Part = tuple[FoundAlong | None, list[dict[str, Any]]]
"""Thresholds of a part that is a line, and rows of :class:`Spectra` of its points."""


@dataclass(frozen=True)
class Asked:
    """Options of a sweep.

    ``fields`` are axes, along the first of which thresholds are computed, or distributions with the
    number of ``samples`` and a ``seed``. A point is certified if its relative error bound of lambda
    is at most ``tolerance``. ``most`` is the largest number of full solves of a basis, ``checks``
    that of full solves at random points that test it, and ``confirm`` the number of thresholds
    confirmed by full solves. With ``full`` every point is solved in full.
    """

    scene: str | Path
    fields: tuple[Field, ...]
    overrides: tuple[str, ...] = ()
    data: str | None = None
    samples: int = 2000
    seed: int = 0
    tolerance: float = TOLERANCE
    most: int = 150
    checks: int = 2
    confirm: int = 3
    full: bool = False

    def __post_init__(self) -> None:
        some = "one or more, e.g. mu=0:1:101 or mu~normal:0.4:0.05"
        require(bool(self.fields), "axis", [], some)
        require(1e-13 <= self.tolerance <= 1e-2, "tolerance", self.tolerance, "1e-13 to 1e-2")
        enough = 2 <= self.samples <= _MOST_SAMPLES
        require(enough, "samples", self.samples, f"2 to {_MOST_SAMPLES}")
        require(self.seed >= 0, "seed", self.seed, "zero or more")
        require(self.most >= 2, "solves", self.most, "2 or more")
        require(self.checks >= 0, "checks", self.checks, "0 or more")
        require(self.confirm >= 0, "confirm", self.confirm, "0 or more")
        on_basis = "left out for samples, which are solved by a reduced model"
        require(self.grid or not self.full, "full", True, on_basis)

    @property
    def grid(self) -> bool:
        """Whether points are a grid of axes rather than samples."""
        return isinstance(self.fields[0], Axis)

    def plain(self) -> dict[str, Any]:
        """Return the options as plain data."""
        fields = list(map(as_plain, self.fields))
        told: dict[str, Any] = {"scene": str(self.scene), "fields": fields}
        told |= {"set": list(self.overrides), "data": self.data, "full": self.full}
        if not self.grid:
            told |= {"samples": self.samples, "seed": self.seed}
        names = ("tolerance", "checks", "confirm")
        return told | {"solves": self.most} | {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class Swept:
    """A sweep: its record, points, modes, and the store, to be discarded after writing."""

    record: dict[str, Any]
    points: Points
    spectra: Spectra
    store: Store | None


def run(asked: Asked, out: Path, progress: Callable[[str], None] = lambda _: None) -> Swept:
    """Run a sweep; results of an interrupted one, stored beside ``out``, are reused.

    Along a single axis without a reduced model each point is solved in full. InputError when there
    is no reduced model over several fields, or a value is not allowed; ConvergenceError when full
    solves keep violating the error bounds.
    """
    begun, given = perf_counter(), (asked.scene, asked.fields, asked.overrides, asked.data)
    why = "--full" if asked.full else ""
    if not why:
        try:
            scene = mapped(*given, (asked.samples, asked.seed))
        except NoMapError as error:
            if len(asked.fields) > 1 or not asked.grid:
                raise
            why = str(error)
    if why:
        scene = in_full(*given)
    store: Store | None = None
    room: AbstractContextManager[None] = nullcontext()
    if isinstance(scene.assembled, AssembledScene):
        room = factors_of(scene.assembled.scene)
    try:
        with room:
            if why:
                data, spectra, solves = _run_in_full(scene, why, progress)
            else:
                store = Store(out, asked.plain() | {"pencil": fingerprint(scene)}, MPI.COMM_WORLD)
                data, spectra = _OnBasis(asked, scene, store, progress).run()
                solves = [(each["point"], each["warnings"]) for each in data["snapshots"]]
    finally:
        scene.driver.free()
    told = record(
        COMMAND,
        data,
        inputs=asked.plain(),
        seconds=perf_counter() - begun,
        warnings=warnings_of(data, scene.points, spectra, asked.tolerance, solves),
    )
    return Swept(told, scene.points, spectra, store)


class _OnBasis:
    """A sweep on a basis of full solves."""

    def __init__(
        self, asked: Asked, scene: SweptScene, store: Store, progress: Callable[[str], None]
    ) -> None:
        self._asked, self._scene, self._progress = asked, scene, progress
        self._store, self._parts = store, scene.points.parts
        low, high = (scene.point(each) for each in zip(*scene.points.ends, strict=True))
        box = {name: (low[name], high[name]) for name in low}
        top, low_growth = scene.window.max_frequency, scene.window.min_growth
        level = scene.window.growth_threshold or 0.0
        model = ReducedModel(scene.pencil, box, top, low_growth, level)
        settings = asked.tolerance, asked.most, scene.warnings
        self.basis = Enrichment(model, scene.driver, *settings, self._begin, store.keep_solve)
        for solve in store.solves():
            self.basis.take(solve)
        self._stored = len(self.basis.solves)

    def run(self) -> tuple[dict[str, Any], Spectra]:
        """Return the record of the sweep, and the modes at all points."""
        asked, scene = self._asked, self._scene
        try:
            self._train()
            rows, lines = self._covered()
        finally:
            self.basis.model.free()
        spectra = Spectra.of_rows(rows)
        basis, bound = self.basis, spectra.bound
        growths = [each["max_growth"] for each in basis.solves]
        data = common_record(scene, spectra, lines, basis.failed, growths) | {
            "parameters": [list(each) for each in scene.names],
            "unknowns": scene.pencil.terms[0].matrix.getSize()[0],
            "vectors": [basis.model.size],
            "snapshots": basis.solves,
            "certified": int((bound <= basis.tolerance).sum()),
            "worst": float(bound.max()),
            "stored_before": self._stored,
        }
        if not asked.grid:
            level, damped = scene.window.growth_threshold, scene.pencil.damped
            data |= probabilities(spectra, level, damped=damped)
        places = [(others, each) for others, line in lines for each in line.thresholds]
        chosen = np.linspace(0, len(places) - 1, min(asked.confirm, len(places))).round()
        for number in np.unique(chosen).astype(int).tolist():
            self._progress(f"threshold {number + 1} of {len(places)}, solved in full")
            data["thresholds"][number]["full_solve_differs"] = self._difference(*places[number])
        return data, spectra

    def _covered(self) -> tuple[list[dict[str, Any]], list[FoundAlong]]:
        """Return the rows of all points and the thresholds, once the basis is trained.

        The basis is enriched until all points are certified or the full solves are used up; parts
        with an uncertified point are recomputed.
        """
        model, tolerance = self.basis.model, self._asked.tolerance
        parts, done = self._parts, dict[int, _Part]()
        numbers = np.concatenate(parts)
        while True:
            done |= self._made([i for i in range(len(parts)) if i not in done])
            rows = [row for i in range(len(parts)) for row in done[i][1]]
            worst = np.array([row["worst"] for row in rows])
            solves, safety = len(self.basis.solves), model.safety
            self.basis.cover([self._point(i) for i in numbers[worst > tolerance].tolist()])
            if len(self.basis.solves) == solves:
                lines = [line for i in range(len(parts)) if (line := done[i][0])]
                return [rows[i] for i in np.argsort(numbers).tolist()], lines
            sure = [i for i in done if max(row["worst"] for row in done[i][1]) <= tolerance]
            done = {i: done[i] for i in sure if model.safety == safety}

    def _train(self) -> None:
        """Enrich the basis until bounds are small at the training points, and full solves agree.

        ConvergenceError when the last full solves violate the bounds.
        """
        asked, points, basis = self._asked, self._scene.points, self.basis
        training = [self._point(i) for i in points.training]
        generator = np.random.default_rng(asked.seed)
        while True:
            basis.cover(training, _AT_FIRST * asked.tolerance)
            checked = generator.choice(np.concatenate(self._parts), size=asked.checks)
            spent = len(basis.solves) >= asked.most
            if spent or basis.stands([self._point(i) for i in checked]):
                return
            if len(basis.solves) >= asked.most:
                raise ConvergenceError(
                    "full solves found missing modes, or errors above the bounds of the reduced "
                    "model; lower max_frequency, or allow more full solves"
                )

    def _begin(self, point: Mapping[str, float]) -> None:
        shown = ", ".join(f"{name} = {value:.4g}" for name, value in point.items())
        self._progress(f"full solve: {shown}")

    def _made(self, missing: list[int]) -> dict[int, _Part]:
        """Compute missing parts, distributed over the ranks; stored ones are read."""
        comm, model = MPI.COMM_WORLD, self.basis.model
        basis = f"{len(self.basis.solves)}-solves-{model.safety:g}"
        values, middle = self._scene.points.values, None
        if not self._asked.grid:
            nearest = np.abs(values - np.median(values, axis=0)) / np.ptp(values, axis=0)
            middle = model.at(self._point(int(nearest.max(axis=1).argmin())))

        with agreed(comm):
            own = np.array_split(missing, comm.size)[comm.rank].tolist()
            part = partial(self._part, middle)
            made = {i: self._store.once(f"{basis}-part-{i:05d}", partial(part, i)) for i in own}
        return {i: each for share in comm.allgather(made) for i, each in share.items()}

    def _part(self, middle: ReducedSpectrum | None, number: int) -> _Part:
        """Return the thresholds of a part, and the rows of its points."""
        self._progress(f"{number + 1} of {len(self._parts)} lines or groups of samples")
        scene, numbers = self._scene, self._parts[number]
        points, rows = [self._point(i) for i in numbers], []
        on_line = points if middle is None else ()
        spectra = SpectraAlong(self.basis.model, on_line, self._asked.tolerance)
        known = dict[float, tuple[ReducedSpectrum, ReducedModel]]()
        for value, point in zip(scene.points.values[numbers, 0].tolist(), points, strict=True):
            found, model = spectra.at(point)
            own = found.window
            moved = np.array([model.slopes(own, point, names) for names in scene.names])
            slopes = model.window.root_slopes(own.z, moved).T
            alike = np.full(len(found), -1) if middle is None else continued(middle, found)
            rows.append(row_of_model(found, slopes, alike, scene.window.growth_threshold))
            known[value] = found, model
        return self._line(numbers, spectra, known) if middle is None else None, rows

    def _line(
        self,
        numbers: Ints,
        spectra: SpectraAlong,
        known: Mapping[float, tuple[ReducedSpectrum, ReducedModel]],
    ) -> FoundAlong:
        """Return the thresholds along a line, with the values of the other fields."""
        points, rates = self._scene.points, self._scene.names[0]
        values, others = points.values[numbers, 0].tolist(), points.values[numbers[0], 1:].tolist()
        line = line_of_model(spectra, self._along(others), rates, known)
        axis = self._asked.fields[0]
        logarithmic = isinstance(axis, Axis) and axis.log
        found = thresholds_along(line, values, logarithmic=logarithmic)
        return dict(zip(points.names[1:], others, strict=True)), found

    def _along(self, others: Iterable[float]) -> Callable[[float], dict[str, float]]:
        """Return a function of the first field at given values of the others: the parameters."""
        return lambda value: self._scene.point((value, *others))

    def _difference(self, others: Mapping[str, float], found: Threshold) -> float | None:
        """Return the change of a threshold by full solves; None where it cannot be confirmed."""
        model = self.basis.model
        told = confirm(self._scene.driver, self._along(others.values()), found, model.window)
        return None if told is None else told[0] - found.value

    def _point(self, number: int) -> dict[str, float]:
        return self._scene.point(self._scene.points.values[number].tolist())


def _run_in_full(
    scene: SweptScene, why: str, progress: Callable[[str], None]
) -> tuple[dict[str, Any], Spectra, list[Run]]:
    """Return the record, modes and warnings of a sweep with a full solve at each point."""
    points, rows, solves = scene.points, list[dict[str, Any]](), list[Run]()
    failed, growths = list[dict[str, Any]](), list[float | None]()
    for values in points.values.tolist():
        at, result = dict(zip(points.names, values, strict=True)), None
        progress(", ".join(f"{name} = {value:g}" for name, value in at.items()))
        try:
            result = scene.run(values)
            solves.append((at, [warning.plain() for warning in result.warnings]))
            growth = float(result.modes.window.max_growth)
            growths.append(growth if np.isfinite(growth) else None)
        except ConvergenceError as error:
            failed.append({"point": at, "reason": str(error)})
        rows.append(row_of_result(result, len(points.names)))
    spectra = Spectra.of_rows(rows)
    lines = [between_points(points, spectra, line) for line in points.parts]
    told = {"why": why, "snapshots": [], "certified": len(solves)}
    return common_record(scene, spectra, lines, failed, growths) | told, spectra, solves
