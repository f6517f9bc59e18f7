"""Samples of a scene whose fields are spread: how probable it is that each mode grows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from cea.errors import InputError
from cea.petsc import MPI
from cea.ranks import agreed
from cea.reduced.greedy import TOLERANCE
from cea.reduced.rows import along
from cea.reduced.small import SmallPencil
from comparisons.sweep.cells import Cell, cells_of, numbered, outermost
from comparisons.sweep.distributions import Distribution, Drawn, draw
from comparisons.sweep.filling import Filling, check_effort
from comparisons.sweep.fingerprints import fingerprint
from comparisons.sweep.mapped import Mapped, mapped
from comparisons.sweep.probabilities import record_of, warnings_of
from comparisons.sweep.sampled import Sampled, gathered, solved
from comparisons.sweep.store import Store
from comparisons.sweep.study import COMMAND
from scenes.results.record import record

_MOST = 1_000_000
"""Samples."""
_TRAINING = 48
"""Samples at which bounds are looked at first, beside those in the corners."""
_OF_A_DISTRICT = 16
"""Samples, beside the outermost, that a basis of a district is tested on."""
_AT_ONCE = 64
"""Samples without a certificate, the worst, at which bounds are looked at before all are again."""


@dataclass(frozen=True)
class AskedSamples:
    """What is sampled, and how well.

    Parameters
    ----------
    scene
        Name of a scene, or its file.
    distributions
        Distributions of its fields, independent of each other.
    count
        Number of samples.
    seed
        Of the generator that draws them.
    overrides, data, tolerance, most, checks
        As of :class:`comparisons.sweep.map_study.AskedMap`.
    """

    scene: str | Path
    distributions: tuple[Distribution, ...]
    count: int
    seed: int = 0
    overrides: tuple[str, ...] = ()
    data: str | None = None
    tolerance: float = TOLERANCE
    most: int = 150
    checks: int = 2

    def __post_init__(self) -> None:
        if not self.distributions:
            raise InputError("distribution", [], "one or more, e.g. mu~normal:0.4:0.05")
        if not 2 <= self.count <= _MOST:
            raise InputError("samples", self.count, f"2 to {_MOST}")
        if self.seed < 0:
            raise InputError("seed", self.seed, "zero or more")
        check_effort(self.tolerance, solves=(self.most, 2), checks=(self.checks, 0))

    def plain(self) -> dict[str, Any]:
        """It as plain data."""
        return {
            "scene": str(self.scene),
            "distributions": [dict(each.plain()) for each in self.distributions],
            "samples": self.count,
            "seed": self.seed,
            "set": list(self.overrides),
            "data": self.data,
            "tolerance": self.tolerance,
            "solves": self.most,
            "checks": self.checks,
        }


def run_samples(
    asked: AskedSamples, out: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[dict[str, Any], tuple[Drawn, ...], Sampled, Store]:
    """Solve all samples; what an interrupted run left beside ``out`` is used again.

    Parameters
    ----------
    asked
        What is sampled.
    out
        Folder of the result.
    progress
        Called with what begins.

    Returns
    -------
    tuple
        The record, what was drawn, the modes of the samples, and the store, to be discarded once
        the result is written.

    Raises
    ------
    InputError
        When the scene has no reduced model over these fields, or refuses a value that was drawn.
    ConvergenceError
        When full solves keep passing the bounds.
    """
    begun = perf_counter()
    drawn = draw(asked.distributions, asked.count, asked.seed)
    scene = mapped(asked.scene, drawn, asked.overrides, asked.data)
    store = Store(out, asked.plain() | {"pencil": fingerprint(scene)}, MPI.COMM_WORLD)
    run = _Run(asked, scene, drawn, store, progress)
    try:
        run.fill()
        found = run.samples()
        data = run.told(found)
    finally:
        run.free()
    seconds = perf_counter() - begun
    warnings = warnings_of(data, asked.tolerance)
    told = record(COMMAND, data, inputs=asked.plain(), seconds=seconds, warnings=warnings)
    return told, drawn, found, store


class _Run:
    """One run: a basis, tested, and the samples solved on it."""

    def __init__(
        self,
        asked: AskedSamples,
        scene: Mapped,
        drawn: Sequence[Drawn],
        store: Store,
        progress: Callable[[str], None],
    ) -> None:
        self._asked, self._scene, self._progress = asked, scene, progress
        self._values = np.array([each.values for each in drawn])
        self._spread = np.array([each.spread for each in drawn])
        self._filling = Filling(asked, scene, store, progress)
        self._online = (0.0, 0)

    def fill(self) -> None:
        """Enrich the basis until bounds are small and full solves agree with them."""
        generator = np.random.default_rng(self._asked.seed)

        def picked() -> list[dict[str, float]]:
            return [
                self._point(int(generator.integers(self._asked.count)))
                for _ in range(self._asked.checks)
            ]

        self._filling.fill([self._point(number) for number in self._training()], picked)

    def samples(self) -> Sampled:
        """All samples; where bounds are too large the pencil itself is solved."""
        while True:
            found = self._solved()
            open_ = np.flatnonzero(found.worst > self._asked.tolerance)
            worst_first = open_[np.argsort(-found.worst[open_], kind="stable")][:_AT_ONCE].tolist()
            if not self._filling.improve([self._point(number) for number in worst_first]):
                return found

    def _solved(self) -> Sampled:
        """All samples on the basis as it is, their cells shared out among the ranks."""
        comm, small = MPI.COMM_WORLD, self._filling.model.small
        before = process_time()
        cells = cells_of(self._spread)
        districts = self._districts(cells)
        middles = [districts[cell.district].at(self._all(cell.middle)) for cell in cells]
        numbers = numbered(middles, cells, self._spread)
        made: dict[int, Sampled] = {}
        with agreed(comm):
            for i in range(comm.rank, len(cells), comm.size):
                self._progress(f"samples, cell {i + 1} of {len(cells)}")
                made[i] = solved(
                    small,
                    districts[cells[i].district],
                    [self._all(int(n)) for n in cells[i].samples],
                    (middles[i], numbers[i]),
                    self._asked.tolerance,
                    self._scene.growth_threshold,
                )
        whole = {i: part for parts in comm.allgather(made) for i, part in parts.items()}
        spent, values = self._online
        mine = sum(len(cells[i].samples) for i in made)
        self._online = spent + process_time() - before, values + mine
        return gathered([(cell, whole[i]) for i, cell in enumerate(cells)])

    def _districts(self, cells: Sequence[Cell]) -> dict[int, SmallPencil]:
        """A local basis for each district, or the whole one where none holds."""
        small, made = self._filling.model.small, {}
        for number in {cell.district for cell in cells}:
            self._progress(f"samples, district {number + 1}")
            own = np.concatenate([cell.samples for cell in cells if cell.district == number])
            seen = {*outermost(self._spread, own), *np.sort(own)[:_OF_A_DISTRICT].tolist()}
            points = [self._all(each) for each in sorted(seen)]
            made[number] = along(small, points, self._asked.tolerance).basis
        return made

    def _training(self) -> list[int]:
        """Samples that lie in corners and at ends, and some at random: those drawn first."""
        every = np.arange(self._asked.count)
        return sorted({*outermost(self._spread, every), *every[:_TRAINING].tolist()})

    def _point(self, number: int) -> dict[str, float]:
        return self._scene.point(self._values[:, number].tolist())

    def _all(self, number: int) -> dict[str, float]:
        """Values of all parameters at a sample."""
        return self._scene.pencil.values(self._point(number))

    def told(self, found: Sampled) -> dict[str, Any]:
        """What the samples come to."""
        spent, values = self._online
        full, basis = self._filling.seconds(spent)
        seconds = {
            "full_solves": full,
            "basis": basis,
            "samples": spent,
            "a_sample": spent / values if values else 0.0,
        }
        return record_of(self._scene, self._filling, found, self._asked.tolerance, seconds)

    def free(self) -> None:
        """Free factors."""
        self._filling.free()
