"""Figures 2, 3 and 7 to 12: the contact patch test, its normal stress, its Gauss points.

Section 3 of the paper: the exact normal stress on the interface is -1000 N/m^2. The error measure
is the oscillation, the largest minus the smallest value over the interface.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import floor, log10
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Picture
from matplotlib.figure import SubFigure
from matplotlib.lines import Line2D

from cea.arrays import Floats
from cea.contact.formulations import Formulation, GaussPointToSurface, Greville, Grid
from cea.system.contact_stresses import pressure_along, stresses_at
from cea.timing import StageTimer
from comparisons.paper.figure import (
    BACKENDS,
    MOST_LAGRANGE,
    Figure,
    Mesh,
    Row,
    Tables,
    as_lagrange,
    quoted,
)
from comparisons.study.numbers import number
from comparisons.study.plots import BLUE, GREY, VERMILION
from comparisons.study.result import StudyResult
from comparisons.study.session import Session
from scenes import Result
from scenes.building.build import build_bodies, half_passes
from scenes.spec.body import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene, StaticAnalysis, load_scene

EXACT = -1000.0  # normal stress on the interface (N/m^2)
INTERFACE = "interface"  # name of the contact in the scene
SIDES = (("b", BLUE, "-"), ("a", VERMILION, "--"))
"""Sides of the contact with colour and line style, as in the paper."""
_MAP_SAMPLES, _MAP_DIGITS = 61, 3
"""Points across a map, and significant digits stored, relative to its range."""
_WIDTH = 9.0  # width of the interface (m)
_ACROSS, _SIZE = 5, (2.9, 6.8)
"""Cases in a row; width and height of the three panels of a case (inches)."""


@dataclass(frozen=True)
class PatchTest:
    """A run of the contact patch test; Lagrange elements have continuity 0."""

    formulation: Formulation  # points and weights on side a
    P: float = 1e6  # global contact stiffness (N/m)
    degree: int = 2  # of both bodies in every direction
    continuity: int = 1
    elements: tuple[int, int] = (3, 5)  # along each side of the interface, of a and of b
    paper: float | str | None = None  # oscillation in the paper (N/m^2), or in words
    remark: str = ""  # note on the comparison

    def on(self, mesh: Mesh) -> "PatchTest":
        """Return the case as it is on a kind of mesh."""
        if mesh == "NURBS":
            return self
        return replace(self, continuity=0, formulation=as_lagrange(self.formulation))

    @property
    def space(self) -> str:
        """Degree and continuity in the paper's notation."""
        return f"D{self.degree}C{self.continuity}"

    @property
    def label(self) -> str:
        """Label that is unique among cases."""
        return f"{self.space}, {self.formulation.label}, P = {number(self.P, 1)}"

    def scene(self, mesh: Mesh) -> Scene:
        """Return the scene of the case on a kind of mesh."""
        changes: dict[str, Any] = {"contacts.interface.form": "penalty"}
        changes |= {f"contacts.interface.{f}": getattr(self, f) for f in ("formulation", "P")}
        degree = min(self.degree, MOST_LAGRANGE)
        for name, n in zip(("upper", "lower"), self.elements, strict=True):
            elements = (n, n, 1)
            fe = FeMesh("hexahedron", degree, elements=elements)
            if mesh == "tetrahedra":
                fe = FeMesh("tetrahedron", degree, size=_WIDTH / n)
            iga = IgaMesh((self.degree,) * 3, elements, (self.continuity,) * 3)
            changes[f"bodies.{name}.mesh"] = MeshSpec(fe=fe, iga=iga)
        return load_scene("patch_test", backend=BACKENDS[mesh]).change(changes)


@dataclass(frozen=True)
class PatchTests(Figure):
    """A figure of the patch test, with ratios of oscillations that the paper claims below 1."""

    cases: tuple[PatchTest, ...]  # cases with the same meshes are adjacent and share bodies
    ratios: tuple[tuple[int, int], ...] = ()  # indices of two cases, numerator first

    def on(self, mesh: Mesh) -> dict[str, PatchTest]:
        """Return cases by label on a kind of mesh; of cases that become equal, the first."""
        cases: dict[str, PatchTest] = {}
        for case in (case.on(mesh) for case in self.cases):
            cases.setdefault(case.label, case)
        return cases

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Return the scenes of all cases."""
        return {label: case.scene(mesh) for label, case in self.on(mesh).items()}

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return oscillations of every case; keep stresses on the diagonal and the interface."""
        rows, lines, maps = [], [], []
        for label, case in self.on(mesh).items():
            line, plane, row = stresses(session.solve(session.scene[label]))
            lines.append(line)
            maps.append(plane)
            rows.append({"case": label, "paper": case.paper, **row, "remark": case.remark})
        session.keep("lines", np.stack(lines))
        session.keep("maps", np.stack(maps))
        worse, numbers = {row["case"]: row["oscillation"] for row in rows}, []
        for pair in self.ratios:
            over, under = (self.cases[i].on(mesh).label for i in pair)
            if over != under:
                ratio = worse[over] / worse[under]
                numbers.append(quoted(f"{over} over {under}", "below 1", ratio))
        return {"patch_tests": rows, "numbers": numbers}


def stresses(result: Result) -> tuple[Floats, Floats, Row]:
    """Return stresses along the diagonal and over the interface, and a row of oscillations.

    On the diagonal of side a: arc (m), sigma_n of a and b, p g (N/m^2), NaN off a surface, shape
    (4, n). On the interface: sigma_n of a and b, rows along y, shape (2, m, m).
    """
    sides, interface = result.stresses[INTERFACE], result.interfaces[INTERFACE]
    x, system, P = result.displacement, result.system, result.scene.contacts[INTERFACE].P
    assert P is not None
    ticks = np.linspace(0.0, _WIDTH, _MAP_SAMPLES)
    across = np.stack(np.meshgrid(ticks, ticks, interface.points.x[0, 2:]), axis=-1)
    plane = stresses_at(system, INTERFACE, x, across.reshape(-1, 3))
    p_gap = pressure_along(system, INTERFACE, x, P / interface.a.area, result.analysis.samples)
    line = [sides["a"].arc, *(sides[side].sigma_n_along for side in "ab"), p_gap]
    a, b = (sides[side].oscillation for side in "ab")
    row = {
        "P": P,
        "points": len(interface.points),
        "dofs": result.dofs,
        "oscillation": max(a, b),
        "oscillation_a": a,
        "oscillation_b": b,
        "b_over_a": b / a,
        "oscillation_p_gap": float(np.ptp(p_gap[np.isfinite(p_gap)])),
        "seconds": result.timer.total,
    }
    maps = [shown(plane[side]).reshape(_MAP_SAMPLES, -1) for side in "ab"]
    return np.stack(line), np.stack(maps), row


def shown(stress: Floats) -> Floats:
    """Round a map to some digits of its range, so that it compresses well."""
    extent = float(np.ptp(stress[np.isfinite(stress)]))
    return np.round(stress, _MAP_DIGITS - floor(log10(extent))) if extent else stress


def drawn(figure: PatchTests, mesh: Mesh, result: StudyResult) -> Picture:
    """Draw every case on a kind of mesh: error of sigma_n on the diagonal, maps below.

    Each panel has its own scale, because oscillations vary from 1e-9 to 3000 N/m^2.
    """
    labels = {"figure": figure.name, "mesh": mesh}
    frame = result.frame("patch_tests", **labels)
    lines, maps = (result.array(labels, name) for name in ("lines", "maps"))
    rows = -(-len(frame) // _ACROSS)
    columns = -(-len(frame) // rows)
    size = (max(_SIZE[0] * columns, 6.0), 0.6 + _SIZE[1] * rows)
    whole = Picture(figsize=size, layout="constrained")
    whole.suptitle(f"{figure.title}, {mesh}", fontsize=10)
    places = whole.subfigures(rows, columns, squeeze=False).ravel()
    for place, row, line, plane in zip(places, frame.to_dict("records"), lines, maps, strict=False):
        _draw(place, {str(name): value for name, value in row.items()}, line, plane)
    looks = [(rf"$\sigma_n^{{({side})}}$", colour, style) for side, colour, style in SIDES]
    handles = [
        Line2D([], [], color=colour, linestyle=style, label=label)
        for label, colour, style in (*looks, ("$-p g$", GREY, ":"))
    ]
    whole.legend(handles=handles, loc="outside lower center", ncols=3)
    return whole


def _draw(place: SubFigure, row: Row, line: Floats, plane: Floats) -> None:
    above, *below = place.subplots(3, 1, height_ratios=(1, 1.1, 1.1))
    arc, a, b, p_gap = line
    for stress, (_, colour, style) in zip((b, a), SIDES, strict=True):
        above.plot(arc, stress - EXACT, style, color=colour, linewidth=1.2)
    low, high = above.get_ylim()
    pressure = -p_gap - EXACT
    # For large P, p g is noise far beyond the panel and would fill it with vertical lines.
    pressure[(pressure < low) | (pressure > high)] = np.nan
    above.plot(arc, pressure, ":", color=GREY, linewidth=0.9)
    above.set(
        title=row["case"], xlabel="along the diagonal (m)", ylabel=r"$\sigma_n + 1000$ (N/m²)"
    )
    above.ticklabel_format(axis="y", scilimits=(-2, 3))
    for axes, side, sigma in zip(below, "ab", plane, strict=True):
        stress = sigma - np.nanmean(sigma)
        extreme = float(np.nanmax(np.abs(stress))) or 1.0
        extent = (0.0, _WIDTH, 0.0, _WIDTH)
        image = axes.imshow(
            stress, origin="lower", extent=extent, cmap="RdBu_r", vmin=-extreme, vmax=extreme
        )
        axes.grid(visible=False)
        axes.set_title(f"side {side}: oscillation {number(row[f'oscillation_{side}'])} N/m²")
        place.colorbar(image, ax=axes, shrink=0.85).formatter.set_powerlimits((-2, 3))


_POINTS = {"Greville points of a": Greville(), "grid points of a": Grid(9)}
_PAPER = {"height of a": 4.5, "E": 1e5, "nu": 0.0, "pressure": 1000.0}
"""Numbers of section 3 for both settings."""


@dataclass(frozen=True)
class Setting(Figure):
    """The setting of a contact patch test: sizes, material, load, elements, points."""

    case: PatchTest
    paper: Mapping[str, float] = field(default_factory=dict)  # further numbers of the paper

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Return the scene."""
        return {"scene": self.case.on(mesh).scene(mesh)}

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return numbers of the meshed bodies and of the points of side a."""
        scene: Scene = session.scene["scene"]
        bodies = build_bodies(scene, StageTimer())
        upper, lower = bodies["upper"].surfaces["z_min"], bodies["lower"].surfaces["z_max"]
        shapes: Any = [scene.bodies[name].geometry for name in ("upper", "lower")]
        material, paper = scene.bodies["upper"].material, {**_PAPER, **self.paper}
        numbers: list[tuple[str, Any, str, str]] = [
            ("length of the interface", shapes[0].size[0], "m", ""),
            ("width of the interface", shapes[0].size[1], "m", ""),
            ("height of a", shapes[0].size[2], "m", ""),
            ("height of b", shapes[1].size[2], "m", ""),
            ("E", material.means[0], "N/m²", ""),
            ("nu", material.means[2], "", ""),
            ("pressure", scene.loads[0].pressure, "N/m²", ""),
            ("elements of a", len(upper.cells.element), "", ""),
            ("elements of b", len(lower.cells.element), "", ""),
        ]
        for what, rule in _POINTS.items():
            own = rule if mesh == "NURBS" else as_lagrange(rule)
            contact = replace(scene.contacts[INTERFACE], formulation=own)
            (half,) = half_passes(INTERFACE, contact, bodies)
            points = len(half.interface.points)
            numbers.append((what, points, "", "" if own is rule else own.label))
        return {"numbers": [quoted(each[0], paper.get(each[0]), *each[1:]) for each in numbers]}


_ON: tuple[Mesh, ...] = ("NURBS", "hexahedra")
SETTINGS = (
    Setting(
        "2",
        "Figure 2: contact patch test",
        PatchTest(Greville()),
        {"Greville points of a": 25.0, "grid points of a": 81.0},
        meshes=_ON,
    ),
    Setting(
        "11",
        "Figure 11: second contact patch test",
        PatchTest(Greville(), elements=(5, 3)),
        meshes=_ON,
    ),
)
"""Settings of the two patch tests. The paper does not state the elements: 25 Greville points imply
3 x 3 quadratic spans; the second mesh, shown in a picture only, is a guess."""


_EACH = range(5, 33)  # Gauss points per direction in a span
_FEW_SAMPLES = 31  # samples across the interface: enough, as stresses are polynomial in spans
_SPACES = {
    "NURBS": ((1, 0), (2, 1), (3, 2), (4, 3), (5, 4), (3, 0), (4, 1)),
    "hexahedra": ((1, 0), (2, 0), (3, 0), (4, 0)),
}
"""Degree and continuity on each kind of mesh."""


@dataclass(frozen=True)
class Quadrature(Figure):
    """Oscillation of the normal stress against the number of Gauss points in a span.

    Derivatives of order c + 1 of the traces of side b jump at its knots, which lie inside spans of
    side a. Gauss quadrature, and the stress, then converge like n^-(c + 2) for any degree. The
    error varies by up to a factor of 10 between successive n, so that slopes are fitted.
    """

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Return the scenes of every space with every number of points."""
        analysis, scenes = StaticAnalysis("static", _FEW_SAMPLES), {}
        for degree, continuity in _SPACES[mesh]:
            for n in _EACH:
                case = PatchTest(GaussPointToSurface(n), degree=degree, continuity=continuity)
                scenes[f"{case.space}, {n}"] = replace(case.scene(mesh), analysis=analysis)
        return scenes

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return the oscillation on the worse side for each number of points, and fitted slopes."""
        rows, numbers = [], []
        for degree, c in _SPACES[mesh]:
            space, errors = f"D{degree}C{c}", []
            for n in _EACH:
                sides = session.solve(session.scene[f"{space}, {n}"]).stresses[INTERFACE].values()
                errors.append(max(side.oscillation for side in sides))
                rows.append({"space": space, "c": c, "points": n, "oscillation": errors[-1]})
            slope = float(np.polyfit(np.log(_EACH), np.log(errors), 1)[0])
            numbers.append(quoted(f"slope, {space}", None, slope, "", f"-(c + 2) = {-(c + 2)}"))
        return {"quadrature": rows, "numbers": numbers}


QUADRATURE = Quadrature(
    "points", "Error of GPTS against Gauss points in a span, P = 10⁶", meshes=_ON
)
"""The study of Gauss points."""
