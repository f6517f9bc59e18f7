"""Figures 4 and 5: a mode of disc and pad with and without lumping, at low contact stiffness.

Of the modes that both runs have in common, the one whose disc moves most along the normal in the
contact, relative to elsewhere. Figure 4 shows it, Figure 5 its normal displacement along a line on
the disc that crosses the boundary of the pad twice.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import tau
from pathlib import Path
from typing import Any, Literal

import numpy as np

from cea.arrays import Complexes, Floats
from cea.volume import VolumeSample
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.families import FAMILIES, Family
from comparisons.paper.common.figure import Data, Number, as_lists
from comparisons.paper.disc_pad.case import DISC, PAD, CeaCase
from comparisons.paper.disc_pad.figures import GPTS, LUMPED
from comparisons.paper.disc_pad.measures import motion_ratio
from comparisons.paper.disc_pad.runs import RUNS, compare_spectra, displacements
from comparisons.paper.disc_pad.shape_drawing import draw_lines, draw_shapes
from scenes import Result
from scenes.spec.body import Backend
from scenes.spec.plain import as_data

P = 1e6
"""Contact stiffness of the figures (N/m)."""
_PLAIN, _LUMPED = replace(GPTS, P=P), replace(LUMPED, P=P)
_NAMES = ("plain", "lumped")
"""Runs that are compared."""

_MIDDLE = (0.115, 45.0)
"""Radius (m) and angle (degrees) of the middle of the line, which is tangential there."""
_HALF = 0.07
"""Half the length of the line (m)."""
_EDGE = 0.115 * np.tan(np.radians(20.0))
"""Distance from the middle at which the line crosses the boundary of the pad (m)."""
_NEAR_EDGE = 0.004
_SAMPLES = 281
_ALIKE = 0.5
"""Modal assurance of modes that have the same characteristics."""
_DIGITS = 6
"""Decimals (m) by which points of the bodies are told apart."""
_SHAPE_DIGITS = 4
"""Decimals of displacements relative to the largest."""

_COMPUTED: dict[tuple[CeaCase, CeaCase, Backend], Data] = {}
"""What both figures show of two cases, kept while the program runs."""


@dataclass(frozen=True)
class ShapeFigure:
    """A mode with and without lumping.

    Parameters
    ----------
    name, title
        Number of the figure, and what it shows.
    kind
        Deformed bodies, or normal displacement along the line.
    plain, lumped
        The runs that are compared.
    """

    name: str
    title: str
    kind: Literal["shapes", "line"]
    plain: CeaCase = _PLAIN
    lumped: CeaCase = _LUMPED

    @property
    def cases(self) -> dict[str, CeaCase]:
        """The runs by name."""
        return dict(zip(_NAMES, (self.plain, self.lumped), strict=True))

    def inputs(self, backend: Backend) -> Data:
        """Scenes of both runs on every kind of mesh, and the line."""
        scenes = {
            family: {name: as_data(case.scene(family)) for name, case in self.cases.items()}
            for family in FAMILIES[backend]
        }
        return {"scenes": scenes, "line": [*_MIDDLE, _HALF, _SAMPLES], "alike": _ALIKE}

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Run both cases on every kind of mesh and take the mode from each."""
        key = (self.plain, self.lumped, backend)
        if key not in _COMPUTED:
            families = {}
            for family in FAMILIES[backend]:
                progress.step(f"figures 4 and 5, {family}")
                families[family] = _compute(self.cases, family)
            _COMPUTED[key] = {"families": families}
        if self.kind == "shapes":
            return _COMPUTED[key]
        return {
            "families": {
                family: found | {name: _without_bodies(found[name]) for name in _NAMES}
                for family, found in _COMPUTED[key]["families"].items()
            }
        }

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw the shapes or the lines."""
        if self.kind == "shapes":
            return [draw_shapes(self.title, data["families"], stem)]
        return [draw_lines(self.title, data["families"], _EDGE, stem)]

    def numbers(self, data: Data) -> list[Number]:
        """The modes, and how much the contact moves in them."""
        return list((self._shapes if self.kind == "shapes" else self._lines)(data))

    def _shapes(self, data: Data) -> Iterator[Number]:
        for family, found in data["families"].items():
            for name in _NAMES:
                mode = found[name]
                yield Number(f"{family}, {name}: frequency", None, mode["frequency"], "Hz")
                yield Number(f"{family}, {name}: growth rate", None, mode["growth"], "1/s")
            lumped, plain = found["lumped"], found["plain"]
            motion = lumped["contact_motion"] / plain["contact_motion"]
            what = "motion of the disc in the contact, lumped over plain"
            yield Number(f"{family}: {what}", "much below 1", motion)
            yield Number(f"{family}: {what}, median of all modes", None, found["motion"])
            yield Number(f"{family}: gap, lumped over plain, median", None, found["gap"])

    def _lines(self, data: Data) -> Iterator[Number]:
        for family, found in data["families"].items():
            slopes = [_slope_at_edge(found[name]["line"]) for name in ("lumped", "plain")]
            what = "slope of the disc at the boundary of the pad, lumped over plain"
            yield Number(f"{family}: {what}", "above 1", slopes[0] / slopes[1])
            lines = [np.array(found[name]["line"]["disc"]) for name in ("lumped", "plain")]
            far = float(np.abs(lines[0] - lines[1]).max())
            what = "largest difference of the disc's lines, of 1"
            yield Number(f"{family}: {what}", None, far)

    def note(self, data: Data) -> str:
        """What is shown and what the numbers mean."""
        return (
            "The mode common to both runs whose disc moves most along the normal in the contact. "
            "Motion is along the normal, relative to that elsewhere on the disc; the gap is "
            "relative to the motion. Lines are scaled to a largest displacement of the disc of 1."
        )

    def tables(self, data: Data, stem: str) -> list[Table]:
        """The lines; of the shapes, where the points of both bodies are and move too."""
        every = [
            (family, name, found[name])
            for family, found in data["families"].items()
            for name in _NAMES
        ]
        lines = [
            (family, name, *row)
            for family, name, mode in every
            for row in zip(*(mode["line"][c] for c in ("arc", "disc", "pad")), strict=True)
        ]
        tables = [_table(f"{stem}_line", self.title, "mesh case arc disc pad", lines)]
        if self.kind == "shapes":
            points = [
                (family, name, body, *point, *u)
                for family, name, mode in every
                for body, shape in mode["bodies"].items()
                for point, u in zip(shape["points"], shape["displacement"], strict=True)
            ]
            columns = "mesh case body x y z u_x u_y u_z"
            tables.append(_table(f"{stem}_shapes", self.title, columns, points, compressed=True))
        return tables


def _table(
    name: str, title: str, columns: str, rows: list[tuple[Any, ...]], *, compressed: bool = False
) -> Table:
    return Table(name, title, tuple(Column(c, c) for c in columns.split()), rows, compressed)


def _without_bodies(mode: Data) -> Data:
    return {key: value for key, value in mode.items() if key != "bodies"}


def _compute(cases: Mapping[str, CeaCase], family: Family) -> Data:
    results = {name: RUNS.result(case, family) for name, case in cases.items()}
    spectra = {name: RUNS.spectrum(case, family) for name, case in cases.items()}
    match = compare_spectra(spectra["lumped"], spectra["plain"])
    pair = _common_mode(match, spectra["plain"].data)
    found: Data = {
        name: _mode(results[name], mode) | {"contact_motion": data["contact_motion"][mode]}
        for name, mode, data in zip(
            ("lumped", "plain"), pair, (spectra[n].data for n in ("lumped", "plain")), strict=True
        )
    }
    data = (spectra["plain"].data, spectra["lumped"].data)
    for key in ("motion", "gap"):
        found[key] = motion_ratio(*data, match, f"contact_{key}")
    return found


def _common_mode(match: Data, reference: Data) -> tuple[int, int]:
    """Numbers of a mode in the lumped and in the plain run."""
    pairs = [
        (group["modes"][0][0], group["modes"][1][0])
        for group in match["groups"]
        if len(group["modes"][0]) == len(group["modes"][1]) == 1 and group["assurance"] > _ALIKE
    ]
    return max(pairs, key=lambda pair: reference["contact_motion"][pair[1]] or 0.0)


def _mode(result: Result, mode: int) -> Data:
    value = result.eigenvalues[mode]
    return {
        "frequency": float(value.imag / tau),
        "growth": float(value.real),
        "line": _line(result, mode),
        "bodies": _bodies(result, mode),
    }


def _line(result: Result, mode: int) -> Data:
    """Normal displacements of disc and pad, the largest of the disc 1, on the disc's normal."""
    arc = np.linspace(-_HALF, _HALF, _SAMPLES)
    angle = np.radians(_MIDDLE[1])
    radial = np.array([np.cos(angle), np.sin(angle), 0.0])
    tangent = np.array([-np.sin(angle), np.cos(angle), 0.0])
    geometry: Any = result.scene.bodies[DISC].geometry
    x = _MIDDLE[0] * radial + arc[:, None] * tangent + [0.0, 0.0, geometry.top]
    lines = {}
    for body, surface in ((DISC, "top"), (PAD, "bottom")):
        u, hit = displacements(result, body, surface, x, [mode])
        lines[body] = np.full(_SAMPLES, np.nan + 0j)
        lines[body][hit] = u[2::3, 0]
    peak = lines[DISC][np.argmax(np.abs(lines[DISC]))]
    return {"arc": arc.tolist()} | {n: as_lists((u / peak).real) for n, u in lines.items()}


def _slope_at_edge(line: Data) -> float:
    """Largest slope of the disc near the boundary of the pad (1/m), largest displacement 1."""
    arc, disc = (np.array(line[name]) for name in ("arc", "disc"))
    slope = np.abs(np.gradient(disc, arc))
    return float(slope[np.abs(np.abs(arc) - _EDGE) < _NEAR_EDGE].max())


def _bodies(result: Result, mode: int) -> Data:
    """Points, cells and real displacements of both bodies at the phase of largest deflection."""
    from scenes.pictures.drawing import largest_deflection  # brings pyvista

    points, cells, shapes = {}, {}, {}
    for name, body in result.system.bodies.items():
        sample = body.volume_sample(1)
        u = result.mode_shapes(name, sample.values, [mode], everywhere=False)[..., 0]
        if body.comm.rank == 0:
            points[name], cells[name], shapes[name] = _merged(sample, u)
    comm = next(iter(result.system.bodies.values())).comm
    if comm.rank:
        return comm.bcast(None)
    turned, largest = largest_deflection(np.concatenate(list(shapes.values())))
    ends = np.cumsum([len(shape) for shape in shapes.values()])[:-1]
    real = dict(zip(shapes, np.split(turned.real / largest, ends), strict=True))
    return comm.bcast(
        {
            name: {
                "points": points[name].tolist(),
                "cells": cells[name].tolist(),
                "displacement": np.round(real[name], _SHAPE_DIGITS).tolist(),
            }
            for name in points
        }
    )


def _merged(sample: VolumeSample, u: Complexes) -> tuple[Floats, Any, Complexes]:
    """Points of a sample once each, with cells and displacements."""
    rounded = np.round(sample.points, _DIGITS)
    points, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return points, number.ravel()[sample.cells], u[first]


SHAPES = (
    ShapeFigure("4", "Figure 4: a mode with and without lumping, P = 10⁶", "shapes"),
    ShapeFigure(
        "5", "Figure 5: normal displacement across the boundary of the pad, P = 10⁶", "line"
    ),
)
"""Figures 4 and 5."""
