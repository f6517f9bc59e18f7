"""Stability diagrams of disc and pad: what tells the spectrum of a case from its reference's.

Every measure of every match is one row: figures and claims look numbers up.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf, tau
from statistics import mean, median
from typing import Any

from comparisons.paper.disc_pad import DiscPad
from comparisons.paper.figure import MESHES, Mesh, Row, Tables
from comparisons.paper.spectra import Data, Spectrum, compare_spectra, spectrum_of
from comparisons.study.session import Session
from scenes.spec.reading import Scene

WITHIN = 0.01
"""Relative difference below which modes coincide."""
_SPECTRA: dict[str, Spectrum] = {}
"""Spectra of this process by scene: figures that share a case compute it once."""


@dataclass(frozen=True)
class Diagram:
    """Growth rates against frequencies, formulations overlaid.

    Parameters
    ----------
    name, title
        Number of the figure or name of the study, and what it shows.
    cases
        Runs of a diagram; the first is the reference of the others.
    stiffnesses
        A diagram for each contact stiffness (N/m); empty: that of the cases.
    paper
        What the paper says of a case beside its reference, by P and number of the case.
    """

    name: str
    title: str
    cases: tuple[DiscPad, ...]
    stiffnesses: tuple[float, ...] = ()
    paper: Mapping[tuple[float, int], str] = field(default_factory=dict)
    meshes: tuple[Mesh, ...] = MESHES

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
        panels, spectra = self.panels(mesh), {}
        every = [(P, n, case) for P, cases in panels.items() for n, case in cases.items()]
        # Cases of equal bodies follow each other.
        for P, n, case in sorted(every, key=lambda each: (each[2].degree, each[2].boundary)):
            spectra[P, n] = _spectrum(session, session.scene[f"{case.label}, P = {P:g}"])
        tables: Tables = {"runs": [], "modes": [], "matches": [], "measures": []}
        for P, n, case in every:
            label, own, reference = case_row(P, n, case), spectra[P, n], spectra[P, 0]
            match = compare_spectra(own, reference) if n else None
            said = self.paper.get((P, n))
            for name, rows in tables_of(label, own.data, reference.data, match, said).items():
                tables[name] += rows
        return tables


def case_row(P: float, number: int, case: DiscPad) -> Row:
    """Labels of a case of a diagram."""
    return {"P": P, "number": number, "case": case.label, "degree": case.degree}


def tables_of(
    label: Row, case: Data, reference: Data, match: Data | None, paper: str | None
) -> Tables:
    """Rows of a case: its run and modes; beside another, pairs of modes and measures."""
    unstable = {mode["mode"] for mode in case["unstable"]}
    run = {name: case[name] for name in ("dofs", "points", "seconds")}
    values = enumerate(case["eigenvalues"])
    modes = [
        {
            **label,
            "frequency": value["im"] / tau,
            "growth": value["re"],
            "residual": value["residual"],
            "condition": value["condition"],
            "unstable": i in unstable,
        }
        for i, value in values
    ]
    tables: Tables = {"runs": [label | run | {"unstable": len(unstable)}], "modes": modes}
    if match is not None:
        tables["matches"] = [{**label, **_pair(group)} for group in match["groups"]]
        tables["measures"] = [label | measures(case, reference, match) | {"paper": paper}]
    return tables


def _pair(group: Data) -> Row:
    (growth, omega), (other, reference) = group["lambda"]
    return {
        "frequency": omega / tau,
        "growth": growth,
        "reference_frequency": reference / tau,
        "reference_growth": other,
        "assurance": group["assurance"],
    }


def _spectrum(session: Session, scene: Scene) -> Spectrum:
    key = repr(scene)
    if key not in _SPECTRA:
        _SPECTRA[key] = spectrum_of(session.solve(scene))
    return _SPECTRA[key]


def measures(case: Data, reference: Data, match: Data) -> Row:
    """Every number that tells a case from its reference.

    Parameters
    ----------
    case, reference
        Data of a :class:`~comparisons.paper.spectra.Spectrum`.
    match
        Their pairs of modes (:func:`~comparisons.paper.spectra.compare_spectra`).

    Returns
    -------
    dict
        Shares of the unstable modes of either run that coincide within 1 per cent in frequency,
        and in growth too; largest relative shifts of frequencies (means where modes nearly
        coalesce), below and above 13 kHz; largest relative distance of eigenvalues; modes of
        either run without a partner; largest difference of growth rates (1/s), and its part of
        the largest; sums of growth rates, of motions of the disc in the contact and of gaps
        (medians of all modes), seconds of the search and points over those of the reference.
    """
    far = growth_difference(case, reference, match)
    largest = max((mode["growth"] for mode in reference["unstable"]), default=inf)
    return {
        "share_frequency": coinciding(match),
        "share_both": coinciding(match, growth=True),
        "shift": largest_shift(match),
        "shift_below_13k": largest_shift(match, below=13e3),
        "shift_above_13k": largest_shift(match, above=13e3),
        "distance": largest_distance(match),
        "alone": sum(match["unpaired"]),
        "growth_difference": far,
        "growth_part": far / largest,
        "growth_below_10k": _over(growth_sum(case, 10e3), growth_sum(reference, 10e3)),
        "growth_over": _over(growth_sum(case), growth_sum(reference)),
        "contact_motion": motion_ratio(case, reference, match, "contact_motion"),
        "contact_gap": motion_ratio(case, reference, match, "contact_gap"),
        "search_over": case["search"] / reference["search"],
        "points_over": case["points"] / reference["points"],
    }


def _over(ours: float, reference: float) -> float:
    return ours / reference if reference else inf


def growth_sum(case: Data, below: float = inf) -> float:
    """Sum of the growth rates (1/s) of unstable modes below a frequency (Hz)."""
    return sum(m["growth"] for m in case["unstable"] if m["frequency"] < below)


def coinciding(match: Data, *, growth: bool = False) -> float:
    """Part of the unstable modes that coincide within 1 per cent, growth too if asked."""
    total = len(match["unstable"]) + match["only_first"] + match["only_second"]
    agreed = sum(
        abs(omega - other) <= WITHIN * other
        and (not growth or abs(rate - its) <= WITHIN * abs(its))
        for (rate, omega), (its, other) in (pair["lambda"] for pair in match["unstable"])
    )
    return agreed / total if total else 1.0


def largest_shift(match: Data, above: float = 0.0, below: float = inf) -> float:
    """Largest relative difference of frequencies in a band (Hz) of the reference; 0 in none."""
    pairs = ((ours[1], its[1]) for ours, its in (group["lambda"] for group in match["groups"]))
    return max((abs(a / b - 1) for a, b in pairs if above <= b / tau < below), default=0.0)


def largest_distance(match: Data) -> float:
    """Largest distance of eigenvalues relative to the reference; means where they nearly meet."""
    pairs = ((complex(*a), complex(*b)) for a, b in (group["lambda"] for group in match["groups"]))
    return max((abs(a - b) / abs(b) for a, b in pairs), default=0.0)


def growth_difference(case: Data, reference: Data, match: Data) -> float:
    """Largest difference of growth rates (1/s); unstable modes without a partner lose theirs."""
    paired = (abs(a[0] - b[0]) for a, b in (pair["lambda"] for pair in match["unstable"]))
    alone = (g for side, run in enumerate((case, reference)) for g in _alone(run, match, side))
    return max([0.0, *paired, *alone])


def _alone(run: Data, match: Data, side: int) -> Iterator[float]:
    """Growth rates (1/s) of the unstable modes of the first or second run without a partner."""
    paired = {i for group in match["unstable"] for i in group["modes"][side]}
    yield from (mode["growth"] for i, mode in enumerate(run["unstable"]) if i not in paired)


def motion_ratio(case: Data, reference: Data, match: Data, what: str) -> float | None:
    """Median over paired modes of a case's part of motion over the reference's.

    Modes in which the disc moves in its plane only have no part, and do not count.

    Parameters
    ----------
    case, reference, match
        Data of both runs and of their match.
    what
        ``contact_motion``, normal motion of the disc in the contact relative to elsewhere; or
        ``contact_gap``, the gap relative to the motion of the disc.
    """
    ratios = []
    for ours, its in (group["modes"] for group in match["groups"]):
        parts: Any = [case[what][i] for i in ours], [reference[what][j] for j in its]
        if None not in (*parts[0], *parts[1]):
            ratios.append(mean(parts[0]) / mean(parts[1]))
    return median(ratios) if ratios else None
