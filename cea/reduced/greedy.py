"""Greedy enrichment of a basis where error bounds are largest, until all are below a tolerance.

Each full solve first tests the reduced model before it extends the basis. If an error exceeds its
bound, the safety factor of all bounds is raised.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.modes import Modes
from cea.eigen.spectrum import Spectrum
from cea.errors import ConvergenceError, ResultWarning
from cea.reduced.model import ReducedModel
from cea.reduced.spectrum import MARGIN, ReducedSpectrum

Point = Mapping[str, float]
"""Values of the parameters that vary."""
FullSolve = tuple[dict[str, Any], Modes]
"""A full solve: plain data, and modes with left vectors, without pencil so that they can be stored.

The data are the "point", whether the window is "complete", "max_growth" (1/s) up to which it is
(None: any), and "warnings"."""

TOLERANCE = 1e-8
"""Relative error bound of lambda up to which a value counts as certified."""
_MEANINGFUL = 1e-3
"""Relative error bound up to which a full solve tests the reduced model."""
_REACH = 0.5
"""Distance relative to abs(lambda) of the nearest eigenvalue above which a mode is missing."""


@dataclass
class Enrichment:
    """Greedy enrichment of a reduced model by at most ``most`` full solves.

    ``tolerance`` is the target of relative error bounds of lambda. ``warnings`` returns the
    warnings about modes at a point; ``begin`` is called before each full solve, and ``keep`` with
    its number and it. ``solves`` lists all full solves as plain data; its "tested" is the largest
    error of the reduced model there relative to its bound: infinite where a mode was missing, None
    where the bounds were too large for a test. ``failed`` lists points where the full solve failed,
    with the reason.
    """

    model: ReducedModel
    driver: EigenSolver
    tolerance: float = TOLERANCE
    most: int = 100
    warnings: Callable[[Modes, Point], tuple[ResultWarning, ...]] = lambda modes, _: modes.warnings
    begin: Callable[[Point], None] = lambda _: None
    keep: Callable[[int, FullSolve], None] = lambda *_: None
    solves: list[dict[str, Any]] = field(default_factory=list)
    failed: list[dict[str, Any]] = field(default_factory=list)

    def at(self, point: Point) -> ReducedSpectrum:
        """Return the spectrum of the reduced model at a point."""
        return self.model.at(point)

    def cover(self, points: Sequence[Point], tolerance: float | None = None) -> None:
        """Solve where bounds are largest until all are small or ``most`` solves are made.

        Bounds hardly rise as the basis grows: after a solve only the largest are evaluated again,
        and a point with a small bound is not checked again.
        """
        tolerance = self.tolerance if tolerance is None else tolerance
        if points and not self.solves:
            self.solve(points[len(points) // 2])
        done = [each["point"] for each in (*self.solves, *self.failed)]
        left = [dict(each) for each in points if dict(each) not in done]
        bounds, known = [np.inf] * len(left), [-1] * len(left)
        while left and len(self.solves) < self.most:
            worst, tried = int(np.argmax(bounds)), len(self.solves) + len(self.failed)
            if bounds[worst] <= tolerance:
                return
            if known[worst] < tried:
                bounds[worst], known[worst] = self.worst(left[worst]), tried
            else:
                self.solve(left[worst])
                del left[worst], bounds[worst], known[worst]

    def solve(self, point: Point) -> float | None:
        """Solve the full pencil at a point, test the model and extend it; return the test."""
        self.begin(point)
        window = self.model.window
        least = -window.reach if window.damped else None
        try:
            top = MARGIN * (window.end / (2 * np.pi))
            modes = self.driver.solve(top, point, min_growth=least, left=True)
        except ConvergenceError as error:
            self.failed.append({"point": dict(point), "reason": str(error)})
            return None
        growth, nothing = float(modes.window.max_growth), cast(Any, None)
        about = {
            "point": {name: float(value) for name, value in point.items()},
            "complete": bool(modes.window.complete),
            "max_growth": growth if np.isfinite(growth) else None,
            "warnings": [warning.plain() for warning in self.warnings(modes, point)],
        }
        solved = about, replace(modes, pencil=nothing, template=nothing)
        self.keep(len(self.solves), solved)
        return self.take(solved)

    def take(self, solved: FullSolve) -> float | None:
        """Test the reduced model by a full solve and extend it; return "tested" (see the class)."""
        about, modes = solved
        point, tested = about["point"], None
        if self.worst(point) <= _MEANINGFUL:
            ratio = largest_ratio(self.at(point), modes)
            tested = self.model.norms.states.comm.bcast(ratio)
            if 1 < tested < np.inf:
                self.model.safety *= 2 * tested
        self.model.take(modes)
        self.solves.append({"tested": tested, **about})
        return tested

    def stands(self, points: Sequence[Point]) -> bool:
        """Test the model at points by full solves, once each; return whether all bounds held."""
        stood = True
        for point in points:
            known = [each["tested"] for each in self.solves if each["point"] == point]
            tested = known[0] if known else self.solve(point)
            stood = stood and (tested is None or tested <= 1)
        return stood

    def worst(self, point: Point) -> float:
        """Return the largest bound at a point, the same on every rank; infinite without a basis."""
        if not self.model.size:
            return np.inf
        return float(self.model.norms.states.comm.bcast(self.at(point).worst))


def largest_ratio(found: ReducedSpectrum, full: Spectrum) -> float:
    """Return the largest error of eigenvalues relative to their bounds; infinite if one is missing.

    Clusters are compared by their means. Both lists extend beyond the window, so that eigenvalues
    near its end have partners.
    """
    window = found.looked_at
    theirs = full.eigenvalues if window.damped else -(full.eigenvalues**2)
    speeds = full.speeds if window.damped else full.speeds**2
    distance = np.abs(theirs[:, None] - found.z) / speeds[:, None]
    rows, columns = assign(distance, _REACH)
    alone = np.setdiff1d(np.arange(len(theirs)), rows)
    extra = np.setdiff1d(np.arange(len(found)), columns)
    if not window.far(theirs[alone]).all() or found.inside[extra].any():
        return np.inf
    ratio, clusters = 0.0, found.clusters[columns]
    for number in np.unique(clusters):
        members = clusters == number
        mine = columns[members]
        if not found.inside[mine].any():
            continue
        error = abs((found.z[mine] - theirs[rows[members]]).mean())
        known = full.growth_uncertainties[rows[members]]
        if members.sum() > 1:  # the mean is less sensitive than its members
            known = known / full.conditions[rows[members]]
        known = known.max() * (1.0 if window.damped else 2 * full.speeds[rows[members]].max())
        ratio = max(ratio, error / (found.means[mine].max() + known))
    return float(ratio)
