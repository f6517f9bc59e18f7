"""Study of the crowned pad: equilibrium, contact stiffness and growth against the load.

The paper gives p(x) and sets aside what a scheme makes of steady sliding (sections 2.3 and 3). Here
each formulation finds its own state, whose p(x) its small motions meet.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cea.body import Body
from comparisons.kit.numbers import number
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.families import FAMILIES, Family
from comparisons.paper.common.figure import Data, Number
from comparisons.paper.crowned_pad.case import (
    COLLOCATION,
    EXACT,
    FINER,
    PAD,
    PRESSURES,
    QUADRATURE,
    WEIGHTED,
    CrownedCase,
    formulations,
)
from comparisons.paper.crowned_pad.drawing import draw_study
from comparisons.paper.crowned_pad.measures import ANGLES, RADII, common_points, distance, kept, off
from meshes.shapes import Crowned
from scenes import run_modes
from scenes.spec.body import Backend
from scenes.spec.plain import as_data


@dataclass(frozen=True)
class CrownedPadStudy:
    """Steady sliding and its small motions by formulation, against the pressure on the pad's back.

    Parameters
    ----------
    name, title
        Name of the study, and what it shows.
    """

    name: str
    title: str

    def inputs(self, backend: Backend) -> Data:
        """Scenes of all cases on every kind of mesh, and the points of comparison."""
        scenes = {
            family: {
                f"{label}, {pressure:g}": as_data(case.scene(family))
                for pressure in PRESSURES
                for label, case in _cases(family, pressure).items()
            }
            for family in FAMILIES[backend]
        }
        return {"scenes": scenes, "points": [RADII, ANGLES]}

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Run every case; those of one load share their bodies."""
        families: Data = {}
        for family in FAMILIES[backend]:
            cases: dict[str, list[Data]] = {}
            for pressure in PRESSURES:
                bodies: dict[bool, dict[str, Body]] = {}
                for label, case in _cases(family, pressure).items():
                    progress.step(f"crowned pad, {family}, {label}, {number(pressure)} N/m²")
                    result = run_modes(case.scene(family), bodies=bodies.get(case.finer))
                    bodies[case.finer] = dict(result.bodies)
                    cases.setdefault(label, []).append(kept(result))
            families[family] = cases
        pad = CrownedCase(formulations("NURBS")[EXACT], PRESSURES[0]).scene("NURBS").bodies[PAD]
        assert isinstance(pad.geometry, Crowned)
        r, theta, _ = common_points(pad.geometry)
        return {
            "pressures": list(PRESSURES),
            "radii": r.tolist(),
            "angles": theta.tolist(),
            "families": families,
        }

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw closed area, pressure and growth by formulation."""
        return [draw_study(data, stem.with_suffix(".png"), self.title)]

    def numbers(self, data: Data) -> list[Number]:
        """What each formulation changes, at the worst of all loads."""
        return list(self._numbers(data))

    def _numbers(self, data: Data) -> Iterator[Number]:
        for family, cases in data["families"].items():
            exact = cases[EXACT]
            low, high = (number(100 * case["closed"]) for case in (exact[0], exact[-1]))
            yield Number(
                f"{family}: closed part of the pad, largest load",
                None,
                100 * exact[-1]["closed"],
                "%",
                f"{low} at the smallest, {high} at the largest",
            )
            for label in (COLLOCATION, WEIGHTED, QUADRATURE, "grid", "mortar", FINER):
                pairs = list(zip(cases[label], exact, strict=True))
                far = max(distance(*pair) for pair in pairs)
                yield Number(f"{family}, {label}: pressure off segments", None, 100 * far, "%")
                far = max(abs(off(*pair, "P")) for pair in pairs)
                yield Number(f"{family}, {label}: P off segments", None, 100 * far, "%")
                far = max(abs(a["growth"] - b["growth"]) for a, b in pairs)
                yield Number(f"{family}, {label}: largest growth off segments", None, far, "1/s")

    def note(self, data: Data) -> str:
        """What the numbers mean."""
        return (
            "Largest differences over all loads, each formulation in the state of steady sliding "
            "that it finds itself, from the exact integration (segments) on the same mesh. The "
            "pressure is that of the law at the closures of the displacements, at "
            f"{RADII} × {ANGLES} points of the pad, in the mean square; P is the integral of p. "
            "Tetrahedra are those of hexahedra each divided into six. The paper has no numbers "
            "of it."
        )

    def tables(self, data: Data, stem: str) -> list[Table]:
        """Every case at every load; pressure and stiffness along the middle circle."""
        return [self._cases_table(data, stem), self._line_table(data, stem)]

    def _cases_table(self, data: Data, stem: str) -> Table:
        columns = [
            *(Column(n, n) for n in ("mesh", "formulation")),
            Column("load", "pressure on the back", number, "N/m^2"),
            *(Column(n, n) for n in ("dofs", "points")),
            Column("closed", "closed part", number),
            Column("force", "normal force", number, "N"),
            Column("P", "P", number, "N/m"),
            Column("pressure_off", "pressure off segments", number),
            Column("growth", "largest growth rate", number, "1/s"),
            Column("unstable", "unstable modes"),
        ]
        rows = [
            (
                *(family, label, load),
                *(case[n] for n in ("dofs", "points", "closed", "force", "P")),
                distance(case, exact),
                case["growth"],
                len(case["unstable"]),
            )
            for family, cases in data["families"].items()
            for label, row in cases.items()
            for load, case, exact in zip(data["pressures"], row, cases[EXACT], strict=True)
        ]
        return Table(f"{stem}_cases", self.title, tuple(columns), rows)

    def _line_table(self, data: Data, stem: str) -> Table:
        columns = (
            *(Column(n, n) for n in ("mesh", "formulation", "load", "angle")),
            Column("pressure", "pressure", number, "N/m^2"),
            Column("p", "p", number, "N/m^3"),
        )
        middle = slice(ANGLES * (RADII // 2), ANGLES * (RADII // 2 + 1))
        rows = [
            (family, label, load, *values)
            for family, cases in data["families"].items()
            for label, row in cases.items()
            for load, case in zip(data["pressures"], row, strict=True)
            for values in zip(
                data["angles"], case["pressure"][middle], case["stiffness"][middle], strict=True
            )
        ]
        caption = f"{self.title}: along the middle circle"
        return Table(f"{stem}_line", caption, columns, rows, compressed=True)


def _cases(family: Family, pressure: float) -> dict[str, CrownedCase]:
    """Cases by label under a load, the finer mesh last."""
    named = formulations(family)
    cases = {label: CrownedCase(each, pressure) for label, each in named.items()}
    return cases | {FINER: CrownedCase(named[EXACT], pressure, finer=True)}


CROWNED_PAD = CrownedPadStudy(
    "crowned", "Steady sliding of a crowned pad: closed area, pressure and growth by formulation"
)
"""The study."""
