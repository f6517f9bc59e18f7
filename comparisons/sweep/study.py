"""A sweep: modes of a scene at a table of points, by bases of few full solves or in full."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Ints
from cea.eigen.mumps import NoRoomError
from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from cea.ranks import agreed
from cea.reduced.full_solves import confirm, line_of_model
from cea.reduced.greedy import TOLERANCE, Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.spectrum import ReducedSpectrum, SmallPencil
from cea.reduced.thresholds import thresholds_along
from cea.reduced.window import Window
from comparisons.sweep.points import Axis, Box, Field, Points, boxes_of
from comparisons.sweep.probabilities import continued, probabilities
from comparisons.sweep.record import plain, record_of, record_of_full, threshold_of, warnings_of
from comparisons.sweep.scene import InFull, Mapped, mapped
from comparisons.sweep.spectra import Spectra, row_of_model, row_of_result
from comparisons.sweep.store import Store, fingerprint
from scenes import Result
from scenes.checking.memory import factors_of
from scenes.results.record import record
from scenes.spec.reading import read_scene

COMMAND = "sweep"
_AT_FIRST = 0.5
"""Bound, relative to the tolerance, of a basis where it is made: elsewhere it is larger."""
_AT_ONCE = 64
"""Points without a certificate, the worst, that a basis takes in before all are looked at again."""
_MOST_SAMPLES = 1_000_000
_Part = tuple[dict[str, Any], dict[str, Any]]
"""What a part says of thresholds as plain data, and its modes as arrays."""


@dataclass(frozen=True)
class Asked:
    """What is swept, and how well.

    Axes, along whose first one thresholds are sought, or distributions with their number of samples
    and seed; a point is certified up to ``tolerance``, an error of lambda relative to its speed; at
    most so many full solves make a basis, ``checks`` at random points test them, and ``confirm``
    thresholds are solved in full. Where there is a reason, each point is.
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
    why_in_full: str = ""

    def __post_init__(self) -> None:
        if not self.fields:
            raise InputError("axis", [], "one or more, e.g. mu=0:1:101 or mu~normal:0.4:0.05")
        if not 1e-13 <= self.tolerance <= 1e-2:
            raise InputError("tolerance", self.tolerance, "1e-13 to 1e-2")
        if not 2 <= self.samples <= _MOST_SAMPLES:
            raise InputError("samples", self.samples, f"2 to {_MOST_SAMPLES}")
        if self.seed < 0:
            raise InputError("seed", self.seed, "zero or more")
        for name, least in (("most", 2), ("checks", 0), ("confirm", 0)):
            count = getattr(self, name)
            if count < least:
                raise InputError("solves" if name == "most" else name, count, f"{least} or more")

    @property
    def grid(self) -> bool:
        """Whether points are a grid of axes rather than samples."""
        return isinstance(self.fields[0], Axis)

    def plain(self) -> dict[str, Any]:
        """As plain data."""
        fields = [each.plain() for each in self.fields]
        told: dict[str, Any] = {"scene": str(self.scene), "fields": fields}
        told |= {"set": list(self.overrides), "data": self.data, "full": bool(self.why_in_full)}
        if not self.grid:
            told |= {"samples": self.samples, "seed": self.seed}
        names = ("tolerance", "checks", "confirm")
        return told | {"solves": self.most} | {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class Swept:
    """A sweep: its record, points, modes, and the store, to be discarded once it is written."""

    record: dict[str, Any]
    points: Points
    spectra: Spectra
    store: Store | None


def run(asked: Asked, out: Path, progress: Callable[[str], None] = lambda _: None) -> Swept:
    """Make a sweep; what an interrupted one left beside ``out`` is used again.

    Raises InputError when the scene has no reduced model over these fields or refuses a value, and
    ConvergenceError when full solves keep passing the bounds.
    """
    begun = perf_counter()
    if asked.why_in_full:
        return _run_in_full(asked, progress, begun)
    scene = mapped(
        asked.scene, asked.fields, asked.overrides, asked.data, (asked.samples, asked.seed)
    )
    store = Store(out, asked.plain() | {"pencil": fingerprint(scene)}, MPI.COMM_WORLD)
    made = _Run(asked, scene, store, progress)
    try:
        spectra, intervals = made.parts()
        data = record_of(scene, spectra, intervals, made.bases, asked.tolerance)
        data["stored_before"] = store.stored
        if not asked.grid:
            damped = scene.pencil.damped
            data |= probabilities(spectra, scene.growth_threshold, damped=damped)
        made.confirm(data["thresholds"], asked.confirm)
        if not spectra.there.any():
            data["lowest"] = made.lowest()
    except NoRoomError:
        if "bodies" not in scene.scene:
            raise
        with factors_of(read_scene(scene.scene)):  # told by the field of a mesh
            raise
    finally:
        scene.driver.free()
    told = record(
        COMMAND,
        data,
        inputs=asked.plain(),
        seconds=perf_counter() - begun,
        warnings=warnings_of(data, asked.tolerance),
    )
    return Swept(told, scene.points, spectra, store)


class _Run:
    """One run: bases, tested, and the points solved on them."""

    def __init__(
        self, asked: Asked, scene: Mapped, store: Store, progress: Callable[[str], None]
    ) -> None:
        self._asked, self._scene, self._store, self._progress = asked, scene, store, progress
        self._generator = np.random.default_rng(asked.seed)
        count = len(scene.points.values)
        self._checked = self._generator.integers(count, size=asked.checks)
        self.bases: list[dict[str, Any]] = []

    def parts(self) -> tuple[Spectra, list[dict[str, Any]]]:
        """Modes at all points, and what is known of thresholds, box by box."""
        made: list[tuple[Ints, Spectra]] = []
        intervals: list[dict[str, Any]] = []
        for number, box in enumerate(boxes_of(self._scene.points)):
            for part, (told, arrays) in zip(box.parts, self._box(number, box), strict=True):
                made.append((part, Spectra(**arrays)))
                intervals.append(told)
        return Spectra.joined(made, len(self._scene.points.values)), intervals

    def _box(self, number: int, box: Box) -> list[_Part]:
        """All parts of a box; those that were stored are made anew where a bound is too large."""
        tolerance = self._asked.tolerance
        names = [f"box-{number:03d}-part-{i:05d}" for i in range(len(box.parts))]
        done = {i: kept for i, each in enumerate(names) if (kept := self._store.part(each))}
        basis = self._basis(box)
        try:
            self._fill(basis, box)
            while True:
                done = {i: e for i, e in done.items() if e[1]["worst"].max() <= tolerance}
                self._make(box, names, basis, done)
                worst = np.concatenate([done[i][1]["worst"] for i in range(len(names))])
                order = np.argsort(-worst, kind="stable")
                order = order[worst[order] > tolerance][:_AT_ONCE]
                settings, size = basis.model.small.settings, basis.model.size
                worst_of_all = np.concatenate(box.parts)[order].tolist()
                basis.cover([self._point(i) for i in worst_of_all])
                if basis.model.size == size:
                    break
                if basis.model.small.settings != settings:
                    done.clear()
        finally:
            basis.model.free()
        told = {"vectors": basis.model.size, "solves": basis.solves, "failed": basis.failed}
        self.bases.append(told)
        return [done[i] for i in range(len(names))]

    def _basis(self, box: Box) -> Enrichment:
        """A basis of a box with nothing in it yet."""
        scene, asked = self._scene, self._asked
        low, high = (scene.point(each) for each in zip(*box.ends, strict=True))
        ends = {name: (low[name], high[name]) for name in low}
        model = ReducedModel(scene.pencil, ends, scene.max_frequency, scene.min_growth)
        settings = asked.tolerance, asked.most, scene.warnings
        return Enrichment(model, scene.driver, *settings, self._begin, self._store.keep_solve)

    def _fill(self, basis: Enrichment, box: Box) -> None:
        """Solve until bounds are small at the training points of a box, and full solves agree.

        Raises ConvergenceError when the last full solves passed the bounds.
        """
        asked, own = self._asked, np.concatenate(box.parts)
        low, high = (self._scene.point(each) for each in zip(*box.ends, strict=True))
        for solve in self._store.solves():
            at = solve.about["point"]
            if all(low[name] <= at[name] <= high[name] for name in at):
                basis.take(solve)
        checked = self._checked[np.isin(self._checked, own)]
        while True:
            basis.cover([self._point(i) for i in box.training], _AT_FIRST * asked.tolerance)
            spent = len(basis.solves) >= asked.most
            if spent or basis.stands([self._point(i) for i in checked]):
                return
            if len(basis.solves) >= asked.most:
                raise ConvergenceError(
                    "full solves found modes or errors that the reduced model had not told of; "
                    "a lower max_frequency may help"
                )
            checked = self._generator.choice(own, size=len(checked))

    def _begin(self, point: Mapping[str, float]) -> None:
        shown = ", ".join(f"{name} = {value:.4g}" for name, value in point.items())
        self._progress(f"full solve: {shown}")

    def _make(self, box: Box, names: list[str], basis: Enrichment, done: dict[int, _Part]) -> None:
        """Parts that are not there yet, shared out among the ranks."""
        comm, small = MPI.COMM_WORLD, basis.model.small
        missing = [i for i in range(len(box.parts)) if i not in done]
        made: dict[int, _Part] = {}
        middle = None
        if not self._asked.grid:
            values = self._scene.points.values
            nearest = np.abs(values - np.median(values, axis=0)) / np.ptp(values, axis=0)
            middle = small.at(self._values(int(nearest.max(axis=1).argmin())))
        with agreed(comm):
            for i in np.array_split(missing, comm.size)[comm.rank].tolist():
                self._progress(f"{i + 1} of {len(box.parts)} parts of a box")
                made[i] = self._part(box.parts[i], small, middle)
                self._store.keep(names[i], *made[i])
        for part in comm.allgather(made):
            done.update(part)

    def _part(self, numbers: Ints, small: SmallPencil, middle: ReducedSpectrum | None) -> _Part:
        """Thresholds of a part as plain data, and its modes as arrays."""
        scene, spectra, rows = self._scene, list[ReducedSpectrum](), []
        for values in (self._values(int(number)) for number in numbers):
            found = small.at(values)
            window, own = small.settings.window, found.window
            moved = [
                window.root_slopes(own.z, small.slopes(own, values, names)) for names in scene.names
            ]
            alike = np.full(len(found), -1) if middle is None else continued(middle, found)
            slopes = np.stack(moved, axis=1)
            rows.append(row_of_model(found, slopes, alike, scene.growth_threshold))
            spectra.append(found)
        told = self._thresholds(numbers, small, spectra) if middle is None else {}
        return told, Spectra.of_rows(rows).arrays()

    def _thresholds(
        self, numbers: Ints, small: SmallPencil, spectra: list[ReducedSpectrum]
    ) -> dict[str, Any]:
        """Thresholds along a line, and what is not resolved."""
        scene, points = self._scene, self._scene.points
        values, others = points.values[numbers, 0].tolist(), points.values[numbers[0], 1:].tolist()
        line = line_of_model(
            small,
            lambda value: scene.pencil.values(scene.point((value, *others))),
            scene.names[0],
            scene.growth_threshold or 0.0,
            dict(zip(values, spectra, strict=True)),
        )
        found = thresholds_along(line, values, logarithmic=points.logarithmic)
        at = dict(zip(points.names[1:], others, strict=True))
        return {
            "thresholds": [at | plain(each) for each in found.thresholds],
            "unresolved": [at | plain(each) for each in found.unresolved],
            "resolution": found.resolution,
        }

    def confirm(self, thresholds: list[dict[str, Any]], most: int) -> None:
        """Solve in full at some thresholds, far apart, and note by how much they differ."""
        scene = self._scene
        level, damped = scene.growth_threshold or 0.0, scene.pencil.damped
        window = Window.up_to(scene.max_frequency, damped=damped, level=level)
        chosen = np.linspace(0, len(thresholds) - 1, min(most, len(thresholds))).round()
        for number in np.unique(chosen).astype(int).tolist():
            self._progress(f"threshold {number + 1} of {len(thresholds)}, solved in full")
            told = thresholds[number]
            others = [told[name] for name in scene.points.names[1:]]

            def at(value: float, others: list[float] = others) -> dict[str, float]:
                return scene.point((value, *others))

            found = confirm(scene.driver, at, threshold_of(told), window)
            told["full_solve_differs"] = None if found is None else found[0] - told["value"]

    def lowest(self) -> float | None:
        """Frequency (Hz) of the lowest mode at the first point, where the window is empty."""
        end = 2 * np.pi * self._scene.max_frequency
        try:
            modes = self._scene.driver.nearest(0.5 * end**2, 1, self._point(0))
        except ConvergenceError:  # there may be no mode at all
            return None
        return min(modes.frequencies.tolist(), default=None)

    def _point(self, number: int) -> dict[str, float]:
        return self._scene.point(self._scene.points.values[number].tolist())

    def _values(self, number: int) -> dict[str, float]:
        """Values of all parameters at a point."""
        return self._scene.pencil.values(self._point(number))


def _run_in_full(asked: Asked, progress: Callable[[str], None], begun: float) -> Swept:
    """Each point by a run of its own; one without an answer is kept with the reason."""
    if not asked.grid:
        raise InputError("full", True, "left out for samples: they are solved on a basis")
    scene = InFull(asked.scene, asked.fields, asked.overrides, asked.data)
    points, results = scene.points, list[Result | None]()
    failed: list[dict[str, Any]] = []
    try:
        for values in points.values.tolist():
            at = dict(zip(points.names, values, strict=True))
            progress(", ".join(f"{name} = {value:g}" for name, value in at.items()))
            try:
                results.append(scene.run(values))
            except ConvergenceError as error:
                results.append(None)
                failed.append({"point": at, "reason": str(error)})
    finally:
        scene.free()
    spectra = Spectra.of_rows([row_of_result(each, len(points.names)) for each in results])
    data = record_of_full(points, spectra, results, failed, asked.why_in_full)
    seconds, warnings = perf_counter() - begun, data.pop("warnings")
    told = record(COMMAND, data, inputs=asked.plain(), seconds=seconds, warnings=warnings)
    return Swept(told, points, spectra, None)
