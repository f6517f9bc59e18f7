"""Study beside Figures 8 and 9: error of GPTS against Gauss points in a span.

Traces of side b are smooth but at its knots, where the derivative of order c + 1 jumps when they
are C^c. Gauss quadrature over spans of side a, which hold such knots, then converges like
n^-(c + 2) in the n points of a direction, whatever the degree, and this carries over to the
oscillation of the normal stress. How far the knots lie from Gauss points changes the error from
one n to the next by up to a factor of 10, so that the slope is fitted over all n of a range.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from cea.contact.formulations import GaussPointToSurface
from comparisons.paper.figure import Figure, Mesh, Tables, quoted
from comparisons.paper.patch_test import INTERFACE, PatchTest
from comparisons.study.result import StudyResult
from comparisons.study.session import Session
from scenes.spec.reading import Scene, StaticAnalysis

_SAMPLES = 31
"""Samples across the interface: stresses are polynomials in each span."""
_SPACES = {
    "NURBS": ((1, 0), (2, 1), (3, 2), (4, 3), (5, 4), (3, 0), (4, 1)),
    "hexahedra": ((1, 0), (2, 0), (3, 0), (4, 0)),
}
"""Degree and continuity on each kind of mesh."""


@dataclass(frozen=True)
class Quadrature(Figure):
    """Oscillation of the normal stress against the number of Gauss points in a span.

    Parameters
    ----------
    points
        Points per direction in a span, rising.
    """

    points: tuple[int, ...]

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Scenes of every space with every number of points."""
        cases = [
            PatchTest(GaussPointToSurface(n), degree=degree, continuity=continuity)
            for degree, continuity in _SPACES[mesh]
            for n in self.points
        ]
        analysis = StaticAnalysis("static", _SAMPLES)
        return {
            f"{case.space}, {n}": replace(case.scene(mesh), analysis=analysis)
            for case, n in zip(cases, self.points * len(_SPACES[mesh]), strict=True)
        }

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Oscillation on the worse side for each number of points, and the fitted slopes."""
        rows, numbers = [], []
        for degree, c in _SPACES[mesh]:
            space, errors = f"D{degree}C{c}", []
            for n in self.points:
                sides = session.solve(session.scene[f"{space}, {n}"]).stresses[INTERFACE].values()
                errors.append(max(side.oscillation for side in sides))
                rows.append({"space": space, "c": c, "points": n, "oscillation": errors[-1]})
            slope = fitted_slope(self.points, errors)
            numbers.append(quoted(f"slope, {space}", None, slope, "", f"-(c + 2) = {-(c + 2)}"))
        return {"quadrature": rows, "numbers": numbers}


def fitted_slope(points: tuple[int, ...], errors: list[float]) -> float:
    """Least squares slope of log error against log points."""
    return float(np.polyfit(np.log(points), np.log(errors), 1)[0])


def expected(result: StudyResult) -> pd.DataFrame:
    """Lines of the slopes -(c + 2) through the middle of the errors of each space."""
    frame = result.frame("quadrature")
    if frame.empty:
        return frame
    line = frame["points"] ** -(frame["c"] + 2.0)
    keys = [frame["mesh"], frame["space"]]
    level = np.exp(np.log(frame["oscillation"] / line).groupby(keys).transform("mean"))
    return frame.assign(oscillation=level * line)


QUADRATURE = Quadrature(
    "points",
    "Error of GPTS against Gauss points in a span, P = 10⁶",
    tuple(range(5, 33)),
    meshes=("NURBS", "hexahedra"),
)
"""The study over all numbers of points from 5 to 32."""
