"""Stability diagrams of disc and pad: growth rate against frequency, formulations overlaid."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import tau
from pathlib import Path

from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.families import FAMILIES, Family
from comparisons.paper.common.figure import Data, Number
from comparisons.paper.disc_pad.case import CeaCase
from comparisons.paper.disc_pad.diagram_drawing import draw_diagrams
from comparisons.paper.disc_pad.runs import RUNS, compare_spectra
from scenes.spec.body import Backend


@dataclass(frozen=True)
class Panel:
    """Runs in one diagram.

    Parameters
    ----------
    title
        What they have in common.
    cases
        The runs; the first is the reference of the others.
    """

    title: str
    cases: tuple[CeaCase, ...]

    def on(self, family: Family) -> dict[str, CeaCase]:
        """Cases by label as a kind of mesh has them; those that become equal there are one."""
        cases = (case.on(family) for case in self.cases if case.exists_on(family))
        return {case.label: case for case in cases}


@dataclass(frozen=True)
class Measure:
    """A number of a diagram: of one case beside the reference of its panel.

    Parameters
    ----------
    what
        What it is, in words.
    panel
        Number of the panel.
    case
        Number of the case in it.
    of
        Takes data of the reference, of the case, and of their match.
    paper
        What the paper says of it.
    unit
        Its unit.
    """

    what: str
    panel: int
    case: int
    of: Callable[[Data, Data, Data], float]
    paper: float | str | None = None
    unit: str = ""


@dataclass(frozen=True)
class StabilityFigure:
    """Stability diagrams.

    Parameters
    ----------
    name, title
        Number of the figure or name of the study, and what it shows.
    panels
        Its diagrams.
    measures
        Numbers that decide what its text says.
    remark
        What a reader must know to compare them.
    """

    name: str
    title: str
    panels: tuple[Panel, ...]
    measures: tuple[Measure, ...] = ()
    remark: str = ""

    def inputs(self, backend: Backend) -> Data:
        """Scenes of all cases on every kind of mesh."""
        return {
            family: [
                {label: case.inputs(family) for label, case in panel.on(family).items()}
                for panel in self.panels
            ]
            for family in FAMILIES[backend]
        }

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Run every case, and pair its modes with those of its panel's reference."""
        families = {}
        for family in FAMILIES[backend]:
            # Cases of equal bodies follow each other, whatever the panels.
            cases = {
                label: case for panel in self.panels for label, case in panel.on(family).items()
            }
            spectra = {}
            for label in sorted(cases, key=lambda label: _mesh_key(cases[label])):
                progress.step(f"figure {self.name}, {family}, {label}")
                spectra[label] = RUNS.spectrum(cases[label], family)
            panels = []
            for panel in self.panels:
                reference, *others = panel.on(family)
                panels.append(
                    {
                        "title": panel.title,
                        "reference": reference,
                        "cases": {label: spectra[label].data for label in (reference, *others)},
                        "matches": {
                            label: compare_spectra(spectra[label], spectra[reference])
                            for label in others
                        },
                    }
                )
            families[family] = panels
        return {"families": families}

    def measure(self, data: Data, family: Family, measure: Measure) -> float | None:
        """Value of a measure on a kind of mesh; None where its case is an earlier one, or none."""
        stored = data["families"][family][measure.panel]
        labels = [case.on(family).label for case in self.panels[measure.panel].cases]
        label = labels[measure.case]
        if label in labels[: measure.case] or label not in stored["matches"]:
            return None
        cases = stored["cases"]
        return measure.of(cases[stored["reference"]], cases[label], stored["matches"][label])

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw a row of diagrams for each kind of mesh."""
        return [draw_diagrams(data["title"], [{f: p} for f, p in data["families"].items()], stem)]

    def draw_both(self, data: Mapping[Backend, Data], stem: Path) -> list[Path]:
        """Draw diagrams with all kinds of meshes overlaid."""
        overlaid = {f: p for each in data.values() for f, p in each["families"].items()}
        return [draw_diagrams(self.title, [overlaid], stem)]

    def numbers(self, data: Data) -> list[Number]:
        """All measures on every kind of mesh."""
        return list(self._numbers(data))

    def _numbers(self, data: Data) -> Iterator[Number]:
        for family in data["families"]:
            for measure in self.measures:
                value = self.measure(data, family, measure)
                if value is not None:
                    what = f"{family}: {measure.what}"
                    yield Number(what, measure.paper, float(value), measure.unit)

    def note(self, data: Data) -> str:
        """What the numbers mean."""
        return f"The paper's words are about NURBS. {self.remark}".rstrip()

    def tables(self, data: Data, stem: str) -> list[Table]:
        """All eigenvalues, the runs, and the matches."""
        runs = [
            (family, panel["title"], label, case)
            for family, panels in data["families"].items()
            for panel in panels
            for label, case in panel["cases"].items()
        ]
        return [
            _table(
                f"{stem}_modes",
                self.title,
                ("mesh", "panel", "case", "frequency", "growth", "residual", "condition"),
                [
                    (*run, value["im"] / tau, value["re"], value["residual"], value["condition"])
                    for *run, case in runs
                    for value in case["eigenvalues"]
                ],
            ),
            _table(
                f"{stem}_runs",
                self.title,
                ("mesh", "panel", "case", "dofs", "points", "seconds", "unstable"),
                [
                    (*run, case["dofs"], case["points"], case["seconds"], len(case["unstable"]))
                    for *run, case in runs
                ],
            ),
            _table(
                f"{stem}_matches",
                self.title,
                (
                    *("mesh", "panel", "case", "frequency", "growth"),
                    *("reference_frequency", "reference_growth", "assurance"),
                ),
                [
                    (
                        *(family, panel["title"], label),
                        *(part for re, im in group["lambda"] for part in (im / tau, re)),
                        group["assurance"],
                    )
                    for family, panels in data["families"].items()
                    for panel in panels
                    for label, match in panel["matches"].items()
                    for group in match["groups"]
                ],
            ),
        ]


def _mesh_key(case: CeaCase) -> tuple[int, str]:
    return case.degree, case.boundary


def _table(
    name: str, caption: str, columns: tuple[str, ...], rows: list[tuple[object, ...]]
) -> Table:
    return Table(name, caption, tuple(Column(c, c) for c in columns), rows)


def at_stiffness(case: CeaCase, *stiffnesses: float) -> tuple[CeaCase, ...]:
    """A case at several contact stiffnesses (N/m)."""
    return tuple(replace(case, P=P) for P in stiffnesses)
