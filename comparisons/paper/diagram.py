"""Stability diagrams of disc and pad: growth rates against frequencies, runs overlaid."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import tau

from comparisons.paper.disc_pad import DiscPad
from comparisons.paper.figure import Figure, Mesh, Row, Tables
from comparisons.paper.spectra import Spectrum, measures, pair_row, paired
from comparisons.study.session import Session
from scenes.spec.reading import Scene

_SPECTRA: dict[str, Spectrum] = {}
"""Spectra of this process by scene: figures that share a case compute it once."""


@dataclass(frozen=True)
class Diagram(Figure):
    """Growth rates against frequencies, formulations overlaid."""

    cases: tuple[DiscPad, ...]  # the first is the reference of the others
    stiffnesses: tuple[float, ...] = ()  # a diagram for each P (N/m); empty: that of the cases
    # what the paper says of a case beside its reference, by P and number of the case
    paper: Mapping[tuple[float, int], str] = field(default_factory=dict)

    def panels(self, mesh: Mesh) -> dict[float, dict[int, DiscPad]]:
        """Cases by P and number; of those that become equal on a kind of mesh, the first."""
        panels = {}
        for P in self.stiffnesses or (self.cases[0].P,):
            found: dict[str, tuple[int, DiscPad]] = {}
            for number, case in enumerate(self.cases):
                if case.exists_on(mesh):
                    own = replace(case, P=P).on(mesh)
                    found.setdefault(own.label, (number, own))
            panels[P] = dict(found.values())
        return panels

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Scenes of all cases."""
        return {
            f"{case.label}, P = {P:g}": case.scene(mesh)
            for P, cases in self.panels(mesh).items()
            for case in cases.values()
        }

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Modes of every case, pairs of them with those of the reference, measures."""
        every = [(P, n, c) for P, cases in self.panels(mesh).items() for n, c in cases.items()]
        spectra = {}
        # Cases of equal bodies follow each other.
        for P, n, case in sorted(every, key=lambda each: (each[2].degree, each[2].boundary)):
            spectra[P, n] = _spectrum(session, session.scene[f"{case.label}, P = {P:g}"])
        tables: Tables = {"runs": [], "modes": [], "matches": [], "measures": []}
        for P, n, case in every:
            label, own, reference = case_row(P, n, case), spectra[P, n], spectra[P, 0]
            run, modes = run_tables(label, own)
            tables["runs"].append(run)
            tables["modes"] += modes
            if n:
                match = paired(own, reference)
                tables["matches"] += [label | pair_row(pair) for pair in match.groups]
                said = {"paper": self.paper.get((P, n))}
                tables["measures"].append(label | measures(own, reference, match) | said)
        return tables


def case_row(P: float, number: int, case: DiscPad) -> Row:
    """Labels of a case of a diagram."""
    return {"P": P, "number": number, "case": case.label, "degree": case.degree}


def run_tables(label: Row, spectrum: Spectrum) -> tuple[Row, list[Row]]:
    """A run as a row, and rows of its modes."""
    unstable = set(spectrum.unstable.tolist())
    values, of = spectrum.modes.eigenvalues, (spectrum.residuals, spectrum.conditions)
    modes = [
        {
            **label,
            "frequency": value.imag / tau,
            "growth": value.real,
            "residual": residual,
            "condition": condition,
            "unstable": i in unstable,
        }
        for i, (value, residual, condition) in enumerate(zip(values, *of, strict=True))
    ]
    run = {name: spectrum.run[name] for name in ("dofs", "points", "seconds")}
    return label | run | {"unstable": len(unstable)}, modes


def _spectrum(session: Session, scene: Scene) -> Spectrum:
    key = repr(scene)
    if key not in _SPECTRA:
        _SPECTRA[key] = Spectrum.of(session.solve(scene))
    return _SPECTRA[key]
