"""Stability diagrams of disc and pad, and measures of each run relative to a reference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, tau
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.errors import require
from comparisons.paper.disc_pad import DISC, PAD, DiscPad
from comparisons.paper.figure import Figure, Mesh, Row, Tables, polar_points, sector_points
from comparisons.study.study import Session
from meshes.shapes import Annulus, Sector
from scenes import Result
from scenes.results.matching import NEAR, ModeMatch, ModeSet, match_modes
from scenes.spec.reading import Scene

WITHIN = 0.01  # relative difference below which modes coincide
_CONTACT_GRID = (7, 12)  # points across and along the contact at which shapes are compared
_CIRCLES, _AROUND = (0.2, 0.5, 0.8, 0.98), 36
"""Circles on the disc, by fraction of its width, and points on each."""
_IN_PLANE = 1e-6  # normal motion relative to all motion, below which it is rounding


@dataclass(frozen=True)
class Spectrum:
    """Data of a run; motion and gap are NaN for modes in the plane of the disc."""

    modes: ModeSet  # eigenvalues, and shapes at points independent of the mesh
    unstable: Ints  # numbers of the unstable modes
    motion: Floats  # normal motion of the disc in the contact over that elsewhere
    gap: Floats  # gap over the normal motion in the contact
    residuals: Floats
    conditions: Floats
    run: Row  # dofs, points, seconds, and seconds of the search

    @classmethod
    def of(cls, result: Result) -> "Spectrum":
        """Return the data of a run; collective."""
        modes = result.modes
        shapes, motion, gap = _shapes(result)
        run = {
            "dofs": result.system.size,
            "points": sum(len(interface.points) for interface in result.interfaces.values()),
            "seconds": result.timer.total,
            "search": result.timer.seconds["search"],
        }
        kept = ModeSet(modes.eigenvalues, shapes)
        unstable = np.flatnonzero(result.unstable)
        return cls(kept, unstable, motion, gap, modes.residuals, modes.conditions, run)

    @property
    def unstable_modes(self) -> ModeSet:
        """The unstable modes."""
        return ModeSet(self.modes.eigenvalues[self.unstable], self.modes.shapes[:, self.unstable])


def paired(first: Spectrum, second: Spectrum) -> ModeMatch:
    """Match all modes of two runs; nearly coalescing modes are matched by their mean."""
    return match_modes(first.modes, second.modes, NEAR)


def means_of(match: ModeMatch) -> tuple[Complexes, Complexes]:
    """Return the mean eigenvalues of the matched groups in each run."""
    first, second = np.array([group.means for group in match.groups]).reshape(-1, 2).T
    return first, second


def measures(own: Spectrum, reference: Spectrum, match: ModeMatch) -> Row:
    """Return the measures of a run relative to its reference, from matched modes.

    Shares of unstable modes that coincide within 1 per cent in frequency, and also in growth;
    largest relative frequency shifts and distances of eigenvalues (of means where modes nearly
    coalesce); number of unmatched modes; largest difference of growth rates (1/s; an unmatched mode
    counts with all of its growth), also over the largest growth rate; and ratios to the reference
    of sums of growth rates, motions in the contact and gaps (medians), search time and points.
    """
    values, others = means_of(match)
    shift, hertz = np.abs(values.imag / others.imag - 1), others.imag / tau
    # Unstable modes are matched one by one, without a limit of distance.
    unstable = match_modes(own.unstable_modes, reference.unstable_modes, near=0.0, limit=None)
    mine, its = means_of(unstable)
    close = np.abs(mine.imag - its.imag) <= WITHIN * its.imag
    grows_alike = np.abs(mine.real - its.real) <= WITHIN * np.abs(its.real)
    growth, reference_growth = (run.unstable_modes.eigenvalues.real for run in (own, reference))
    alone = [*growth[unstable.only_first], *reference_growth[unstable.only_second]]
    far = _largest([*np.abs(mine.real - its.real), *alone])
    total = len(close) + len(alone)
    return {
        "share_frequency": float(close.sum() / total) if total else 1.0,
        "share_both": float((close & grows_alike).sum() / total) if total else 1.0,
        "shift": _largest(shift),
        "shift_below_13k": _largest(shift[hertz < 13e3]),
        "shift_above_13k": _largest(shift[hertz >= 13e3]),
        "distance": _largest(np.abs(values - others) / np.abs(others)),
        "alone": len(match.only_first) + len(match.only_second),
        "growth_difference": far,
        "growth_part": far / max(reference_growth, default=inf),
        "growth_below_10k": _growth(own, 10e3, reference),
        "growth_over": _growth(own, inf, reference),
        "contact_motion": _median_over(match, own.motion, reference.motion),
        "contact_gap": _median_over(match, own.gap, reference.gap),
        "search_over": own.run["search"] / reference.run["search"],
        "points_over": own.run["points"] / reference.run["points"],
    }


def _largest(values: Any) -> float:
    return float(max(values, default=0.0))


def _growth(own: Spectrum, below: float, reference: Spectrum) -> float:
    """Return the sum of growth rates below a frequency (Hz) over that of the reference."""
    ours, its = (
        values.real[values.imag / tau < below].sum()
        for values in (run.unstable_modes.eigenvalues for run in (own, reference))
    )
    return float(ours / its) if its else inf


def _median_over(match: ModeMatch, own: Floats, reference: Floats) -> float | None:
    """Return the median over matched modes of a measure over that of the reference."""
    ratios = np.array(
        [own[pair.first].mean() / reference[pair.second].mean() for pair in match.groups]
    )
    found = ratios[np.isfinite(ratios)]
    return float(np.median(found)) if len(found) else None


def _shapes(result: Result) -> tuple[Complexes, Floats, Floats]:
    """Return displacements on both contact sides and on circles of the disc; motion; gap."""
    disc, pad = (result.scene.bodies[name].geometry for name in (DISC, PAD))
    assert isinstance(disc, Annulus)
    assert isinstance(pad, Sector)
    contact = sector_points(pad, *_CONTACT_GRID, disc.top)
    r = disc.inner_radius + (disc.outer_radius - disc.inner_radius) * np.array(_CIRCLES)
    theta = np.linspace(0.0, 360.0, _AROUND, endpoint=False)
    side_b = displacements(result, DISC, "top", contact)[0]
    side_a = displacements(result, PAD, "bottom", contact)[0]
    rest = displacements(result, DISC, "top", polar_points(r, theta, disc.top))[0]
    beside = ~np.logical_and.outer(
        (r >= pad.inner_radius) & (r <= pad.outer_radius),
        (theta - pad.start) % 360 <= pad.end - pad.start,
    ).ravel()
    shapes = np.concatenate([side_b, rest, side_a])
    least = _IN_PLANE * _rms(shapes)
    motion, elsewhere = _rms(side_b[2::3]), _rms(rest[2::3][beside])
    ratios = [
        np.divide(above, below, out=np.full(len(least), np.nan), where=below > least)
        for above, below in ((motion, elsewhere), (_rms(side_b[2::3] - side_a[2::3]), motion))
    ]
    return shapes, ratios[0], ratios[1]


def _rms(values: Complexes) -> Floats:
    """Return the root mean square over the rows, shape (modes,)."""
    return np.sqrt((np.abs(values) ** 2).mean(axis=0))


def displacements(
    result: Result, body: str, surface: str, x: Floats, modes: Sequence[int] | None = None
) -> tuple[Complexes, Any]:
    """Return displacements of modes at points projected along z, and which points are found.

    The shape is (3 found, modes).
    """
    side = result.system.bodies[body].surfaces[surface]
    found = side.locate(x, np.tile([0.0, 0.0, 1.0], (len(x), 1)), side.mesh_size)
    hit = ~found.missed
    require(bool(hit.any()), "x", f"{len(x)} points", f"points on {body}.{surface}")
    u = result.mode_shapes(f"{body}.{surface}", found.at[hit], modes)
    return u.reshape(-1, u.shape[-1]), hit


@dataclass(frozen=True)
class Diagram(Figure):
    """Growth rates against frequencies of several formulations."""

    cases: tuple[DiscPad, ...]  # the first is the reference
    stiffnesses: tuple[float, ...] = ()  # a diagram for each P (N/m); empty: P of the cases
    # statement of the paper about a case and the reference, by P and number of the case
    paper: Mapping[tuple[float, int], str] = field(default_factory=dict)

    def panels(self, mesh: Mesh) -> dict[float, dict[int, DiscPad]]:
        """Return cases by P and number; of cases that become equal on a mesh, the first."""
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
        """Return the scenes of all cases."""
        return {
            f"{case.label}, P = {P:g}": case.scene(mesh)
            for P, cases in self.panels(mesh).items()
            for case in cases.values()
        }

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return the modes of every case, their matches with the reference, and measures."""
        every = [(P, n, c) for P, cases in self.panels(mesh).items() for n, c in cases.items()]
        spectra = {}
        # Cases with the same bodies are run one after the other.
        for P, n, case in sorted(every, key=lambda each: (each[2].degree, each[2].boundary)):
            scene = session.scene[f"{case.label}, P = {P:g}"]
            spectra[P, n] = Spectrum.of(session.solve(scene))
        tables: Tables = {"runs": [], "modes": [], "matches": [], "measures": []}
        for P, n, case in every:
            label, own, reference = case_row(P, n, case), spectra[P, n], spectra[P, 0]
            run, modes = run_tables(label, own)
            tables["runs"].append(run)
            tables["modes"] += modes
            if n:
                match = paired(own, reference)
                for pair, (mine, its) in ((group, group.means) for group in match.groups):
                    tables["matches"].append(
                        {
                            **label,
                            "frequency": mine.imag / tau,
                            "growth": mine.real,
                            "reference_frequency": its.imag / tau,
                            "reference_growth": its.real,
                            "assurance": pair.assurance,
                        }
                    )
                said = {"paper": self.paper.get((P, n))}
                tables["measures"].append(label | measures(own, reference, match) | said)
        return tables


def case_row(P: float, number: int, case: DiscPad) -> Row:
    """Return the labels of a case of a diagram."""
    return {"P": P, "number": number, "case": case.label, "degree": case.degree}


def run_tables(label: Row, spectrum: Spectrum) -> tuple[Row, list[Row]]:
    """Return a row of a run, and rows of its modes."""
    unstable = set(spectrum.unstable.tolist())
    columns = spectrum.modes.eigenvalues, spectrum.residuals, spectrum.conditions
    modes = [
        {
            **label,
            "frequency": value.imag / tau,
            "growth": value.real,
            "residual": residual,
            "condition": condition,
            "unstable": i in unstable,
        }
        for i, (value, residual, condition) in enumerate(zip(*columns, strict=True))
    ]
    run = {name: spectrum.run[name] for name in ("dofs", "points", "seconds")}
    return label | run | {"unstable": len(unstable)}, modes
