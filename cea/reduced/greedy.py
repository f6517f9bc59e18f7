"""A basis enriched where its bounds are worst, until they are small over a whole map.

Each full solve is, before the basis takes it in, a test of what the reduced model says there. A
bound that was passed raises the factor that all bounds are made with.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from cea.eigen.matching import assign
from cea.eigen.modes import Modes
from cea.errors import ConvergenceError
from cea.reduced.model import Growth, ReducedModel
from cea.reduced.spectrum import MARGIN, ReducedSpectrum
from cea.reduced.stored import Arrays
from cea.warned import ResultWarning

Point = Mapping[str, float]
"""Values of the parameters that vary."""

TOLERANCE = 1e-8
"""Error of lambda relative to its speed up to which a value counts as certified."""
_MEANINGFUL = 1e-3
"""The same up to which a reduced model is tested by a full solve."""
_LOOKS = 12
"""Bounds above the tolerance that are computed anew before the largest is taken."""
_NEARLY = 0.5
"""Part of what all others may have that makes a bound the worst: a look costs as much as a tenth of
a solve, and a solve takes bounds down by decades."""
_REACH = 0.5
"""Distance of a partner, relative to a speed, beyond which a mode is missing."""


class FullDriver(Protocol):
    """What solves the pencil itself."""

    def solve(
        self,
        max_frequency: float,
        changes: Point,
        /,
        *,
        min_growth: float | None = None,
        left: bool = False,
    ) -> Modes:
        """All modes up to a frequency (Hz)."""
        ...


@dataclass(frozen=True)
class Snapshot:
    """A full solve that a basis took in.

    Parameters
    ----------
    point
        Where.
    grown
        What the basis grew by.
    rounding
        What rounding does to eigenvalues of condition one (1/s^2).
    tested
        Largest error of the reduced model relative to its bound, and infinite where a mode was
        missing; None where the bounds were too large to tell.
    complete
        Whether the window of the full solve was shown to be complete.
    warnings
        What the full solve must be read with.
    """

    point: Point
    grown: Growth
    rounding: float
    tested: float | None
    complete: bool
    warnings: tuple[ResultWarning, ...] = ()

    def plain(self) -> dict[str, Any]:
        """It as plain data, without the vectors."""
        return {
            "point": {name: float(value) for name, value in self.point.items()},
            "rounding": float(self.rounding),
            "tested": None if self.tested is None else float(self.tested),
            "complete": bool(self.complete),
            "warnings": [warning.plain() for warning in self.warnings],
        }


@dataclass
class Enrichment:
    """Greedy enrichment of a reduced model.

    Parameters
    ----------
    model
        The model.
    driver
        What solves the pencil itself.
    max_frequency
        Upper end of the window (Hz).
    tolerance
        Error of lambda, relative to its speed, to be reached.
    most
        Most full solves.
    keep
        Called with each snapshot once it is taken in.
    tell
        Called with each point that is solved, and the worst bound there.

    Attributes
    ----------
    snapshots
        What was taken in, without the vectors.
    failed
        Points whose full solve gave no answer, and why.
    """

    model: ReducedModel
    driver: FullDriver
    max_frequency: float
    tolerance: float = TOLERANCE
    most: int = 100
    keep: Callable[[Snapshot], None] = lambda _: None
    tell: Callable[[Point, float], None] = lambda point, worst: None
    snapshots: list[Snapshot] = field(default_factory=list)
    failed: list[tuple[Point, str]] = field(default_factory=list)

    def at(self, point: Point) -> ReducedSpectrum:
        """The reduced model at a point, residuals measured as stiff as contacts are there."""
        values, small = self.model.pencil.values(point), self.model.small
        return small.where(small.stiffness(values)).at(values)

    def cover(self, points: Sequence[Point], tolerance: float | None = None) -> float:
        """Solve where bounds are worst until all are small, there are solves enough, or none helps.

        Bounds hardly rise as a basis grows: those that were small stay, and of the others the
        largest is computed anew until one is known to be nearly the largest, or that of a dozen.

        Parameters
        ----------
        points
            Where bounds are to be small.
        tolerance
            Error of lambda, relative to its speed, up to which they are; None for that of all.

        Returns
        -------
        float
            The worst bound left.
        """
        tolerance = self.tolerance if tolerance is None else tolerance
        known = dict.fromkeys(_spread_out(len(points)), np.inf)
        if not self.snapshots and known:
            known.pop(len(points) // 2)
            self.solve(points[len(points) // 2], np.inf)
        while known:
            worst, fresh = self._worst_of(points, known, tolerance)
            if worst < 0:
                break
            if len(self.snapshots) >= self.most:
                return fresh
            before = self.model.size, len(self.failed)
            self.solve(points[worst], fresh)
            if before == (self.model.size, len(self.failed)):
                return fresh
            del known[worst]
        return 0.0

    def _worst_of(
        self, points: Sequence[Point], known: dict[int, float], tolerance: float
    ) -> tuple[int, float]:
        """Number of the point with nearly the largest bound, and that; -1 where all are small.

        Points whose bounds are small are taken out of those known.
        """
        looked: dict[int, float] = {}
        while known:
            number = max(known, key=lambda each: known[each])
            if looked:
                worst = max(looked.items(), key=lambda each: each[1])
                if worst[1] >= _NEARLY * known[number] or len(looked) == _LOOKS:
                    return worst
            bound = known[number] = self._worst(points[number])
            if bound <= tolerance:
                del known[number]
            else:
                looked[number] = bound
        return -1, 0.0

    def solve(self, point: Point, worst: float) -> float | None:
        """Solve in full, test the reduced model, take the modes in.

        Returns
        -------
        float or None
            The test, as :class:`Snapshot` has it.
        """
        self.tell(point, worst)
        try:
            modes = self.driver.solve(
                MARGIN * self.max_frequency, point, min_growth=self._least_growth, left=True
            )
        except ConvergenceError as error:
            self.failed.append((point, str(error)))
            return None
        tested = None
        if worst <= _MEANINGFUL:
            tested = self.model.norm.comm.bcast(largest_ratio(self.at(point), modes))
            if 1 < tested < np.inf:
                self.model.raise_safety(2 * tested * self.model.small.settings.safety)
        grown = self.model.take(modes)
        rounding = self.model.small.roundings[-1][0]
        taken = Snapshot(
            point, grown, rounding, tested, modes.window.complete, tuple(modes.warnings)
        )
        self.keep(taken)
        self.snapshots.append(replace(taken, grown=Growth.nothing()))
        return tested

    def restore(self, snapshots: Sequence[Snapshot], arrays: Arrays) -> None:
        """Take over snapshots that were stored, and the small pencil as it was with the last.

        Raises
        ------
        ValueError
            When they are none of this model.
        """
        self.model.restore([each.grown for each in snapshots], arrays)
        self.snapshots += [replace(each, grown=Growth.nothing()) for each in snapshots]

    def confirm(self, points: Sequence[Point]) -> bool:
        """Test the model at points by full solves; whether it stood them all.

        Where it was tested already, before an interruption, nothing is solved again.
        """
        stood = True
        for point in points:
            known = [each.tested for each in self.snapshots if dict(each.point) == dict(point)]
            tested = known[0] if known else self.solve(point, self._worst(point))
            stood = stood and (tested is None or tested <= 1)
        return stood

    @property
    def _least_growth(self) -> float | None:
        """Growth rate (1/s) down to which full solves go where there is damping or rotation."""
        return -self.model.small.settings.reach if self.model.small.damped else None

    def _worst(self, point: Point) -> float:
        """The worst bound at a point, the same on every rank."""
        return float(self.model.norm.comm.bcast(self.at(point).worst))


def _spread_out(count: int) -> list[int]:
    """Numbers up to a count in an order whose beginnings are spread over all of them."""
    golden = 0.5 * (np.sqrt(5) - 1)
    order: list[int] = np.argsort(np.arange(count) * golden % 1).tolist()
    return order


def largest_ratio(found: ReducedSpectrum, modes: Modes) -> float:
    """Largest error of eigenvalues of a window relative to their bounds; infinite if one misses.

    Clusters are compared by their means. Both lists reach beyond the window, so that nothing hangs
    on which side of its end an eigenvalue lies.

    Parameters
    ----------
    found
        What the reduced model says.
    modes
        The modes there.
    """
    damped = found.settings.decay < np.inf
    theirs, mine = -(modes.eigenvalues**2), found.kappa
    if damped:  # lambda and -lambda are not of one motion
        theirs, mine = modes.eigenvalues, found.eigenvalues
    distance = np.abs(theirs[:, None] - mine) / modes.speeds[:, None] ** (1 if damped else 2)
    rows, columns = assign(distance, _REACH)
    alone = np.setdiff1d(np.arange(len(theirs)), rows)
    extra = np.setdiff1d(np.arange(len(mine)), columns)
    holds = found.settings.holds
    if holds(modes.eigenvalues[alone]).any() or found.inside[extra].any():
        return np.inf
    ratio, bounds = 0.0, found.certificate
    for number in np.unique(bounds.clusters[columns]):
        members = bounds.clusters[columns] == number
        if not found.inside[columns[members]].any():
            continue
        error = abs((mine[columns[members]] - theirs[rows[members]]).mean())
        speeds = modes.speeds[rows[members]]
        if damped:
            error *= 2 * speeds.min() + error
        doubt = modes.growth_uncertainties[rows[members]] if members.sum() == 1 else 0.0
        known = float((2 * speeds * doubt).max(initial=0.0))
        ratio = max(ratio, error / (bounds.means[columns[members]].max() + known))
    return float(ratio)
