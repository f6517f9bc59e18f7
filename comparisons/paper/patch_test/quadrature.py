"""Study beside Figures 8 and 9: error of GPTS against Gauss points in a span.

Traces of side b are smooth but at its knots, where the derivative of order c + 1 jumps when they
are C^c. Gauss quadrature over spans of side a, which hold such knots, then converges like
n^-(c + 2) in the n points of a direction, whatever the degree, and this carries over to the
oscillation of the normal stress. How far the knots lie from Gauss points changes the error from
one n to the next by up to a factor of 10, so that the slope is fitted over all n of a range.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cea.body import Body
from cea.contact.formulations import GaussPointToSurface
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.figure import Data, Number
from comparisons.paper.common.style import COLOURS, drawing
from comparisons.paper.patch_test.case import INTERFACE, PatchTestCase
from scenes import run_static
from scenes.spec.analysis import StaticAnalysis
from scenes.spec.body import Backend
from scenes.spec.plain import as_data
from scenes.spec.reading import Scene

_SAMPLES = 31
"""Samples across the interface: stresses are polynomials in each span."""
_SPACES = {
    "iga": ((1, 0), (2, 1), (3, 2), (4, 3), (5, 4), (3, 0), (4, 1)),
    "fe": ((1, 0), (2, 0), (3, 0), (4, 0)),
}
"""Degree and continuity by backend."""


@dataclass(frozen=True)
class QuadratureStudy:
    """Oscillation of the normal stress against the number of Gauss points in a span.

    Parameters
    ----------
    name, title
        Name of the study, and what it shows.
    points
        Points per direction in a span, rising.
    P
        Global contact stiffness (N/m).
    """

    name: str
    title: str
    points: tuple[int, ...]
    P: float = 1e6

    def inputs(self, backend: Backend) -> Data:
        """Scenes of all spaces at the first number of points, and the numbers of points."""
        first = {
            f"D{p}C{c}": as_data(self._scene(p, c, self.points[0], backend))
            for p, c in _SPACES[backend]
        }
        return {"points": list(self.points), "scenes": first}

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Run every space with every number of points, and fit the slopes."""
        spaces = {}
        for degree, continuity in _SPACES[backend]:
            space = f"D{degree}C{continuity}"
            progress.step(f"{self.name}, {backend}, {space}")
            errors = self.errors(degree, continuity, backend)
            spaces[space] = {
                "continuity": continuity,
                "oscillation": errors,
                "slope": fitted_slope(self.points, errors),
            }
        return {"points": list(self.points), "spaces": spaces}

    def errors(self, degree: int, continuity: int, backend: Backend) -> list[float]:
        """Oscillation on the worse side (N/m^2) for each number of points."""
        bodies: Mapping[str, Body] | None = None
        found = []
        for n in self.points:
            result = run_static(self._scene(degree, continuity, n, backend), bodies=bodies)
            bodies = result.bodies
            found.append(max(s.oscillation for s in result.stresses[INTERFACE].values()))
        return found

    def _scene(self, degree: int, continuity: int, n: int, backend: Backend) -> Scene:
        case = PatchTestCase(GaussPointToSurface(n), self.P, degree, continuity)
        scene = case.scene(backend)
        return replace(scene, analysis=StaticAnalysis("static", _SAMPLES))

    def numbers(self, data: Data) -> list[Number]:
        """Fitted slopes beside -(c + 2)."""
        return [
            Number(
                f"slope, {space}",
                None,
                found["slope"],
                "",
                f"-(c + 2) = {-(found['continuity'] + 2)}",
            )
            for space, found in data["spaces"].items()
        ]

    def note(self, data: Data) -> str:
        """How slopes were found."""
        first, last = data["points"][0], data["points"][-1]
        return (
            "Slopes of the oscillation of σₙ on the worse side, fitted over all numbers of points "
            f"from {first} to {last}."
        )

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw the errors with lines of the expected slopes."""
        file = stem.with_suffix(".png")
        n = np.array(data["points"], dtype=float)
        with drawing(file, (7.5, 5.0)) as figure:
            axes = figure.subplots()
            for i, (space, found) in enumerate(data["spaces"].items()):
                colour = COLOURS[i % len(COLOURS)]
                label = f"{space}: slope {found['slope']:.2f}"
                error = np.array(found["oscillation"])
                marker = "os^"[i // len(COLOURS)]
                axes.loglog(n, error, marker, color=colour, markersize=3, label=label)
                expected = n ** -(found["continuity"] + 2.0)
                level = np.exp(np.log(error / expected).mean())
                axes.loglog(n, level * expected, color=colour, linewidth=0.9)
            axes.set(xlabel="Gauss points per direction in a span")
            axes.set(ylabel=r"oscillation of $\sigma_n$, worse side (N/m²)", title=data["title"])
            axes.grid(visible=True)
            ticks = [t for t in (5, 10, 20, 40) if n[0] <= t <= n[-1]]
            axes.set_xticks(ticks, list(map(str, ticks)))
            axes.set_xticks([], minor=True)
            figure.legend(title=r"lines: $n^{-(c + 2)}$", loc="outside right upper")
        return [file]

    def tables(self, data: Data, stem: str) -> list[Table]:
        """Errors of every space and number of points."""
        names = ("space", "points", "oscillation")
        rows = [
            (space, n, error)
            for space, found in data["spaces"].items()
            for n, error in zip(data["points"], found["oscillation"], strict=True)
        ]
        return [Table(f"{stem}_errors", self.title, tuple(Column(c, c) for c in names), rows)]


def fitted_slope(points: Sequence[int], errors: Iterable[float]) -> float:
    """Least squares slope of log error against log points."""
    return float(np.polyfit(np.log(points), np.log(list(errors)), 1)[0])


QUADRATURE = QuadratureStudy(
    "points",
    "Error of GPTS against Gauss points in a span, P = 10⁶",
    tuple(range(5, 33)),
)
"""The study over all numbers of points from 5 to 32."""
