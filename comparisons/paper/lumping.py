"""Effect of lumping on modes: Figures 4 and 5, and the false stiffness of rotations.

Figure 4 shows a mode of disc and pad with and without lumping, Figure 5 its normal displacement
along a line on the disc that crosses the boundary of the pad twice.

Lumping replaces sum_ij N_i N_j u_i u_j by sum_i N_i u_i^2 on each side. The difference is the
variance of the displacements of overlapping functions: zero for translations, but a false energy of
every other motion that both sides share, such as rotations. To first order it shifts an eigenvalue
kappa by x^H (K_lumped - K_n) x, with the mode x without lumping.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from math import tau
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.block_products import columns_inner, times, transposed_times
from cea.matrices import destroy, scaled_total
from comparisons.paper.disc_pad import DISC, GPTS, LOW, LUMPED, PAD
from comparisons.paper.figure import Figure, Mesh, Tables, quoted, rows_of
from comparisons.paper.spectra import Spectrum, case_row, displacements, means_of, measures, paired
from comparisons.study.session import Session
from scenes import Result
from scenes.results.matching import ModeMatch
from scenes.spec.reading import Scene

P = 1e6  # contact stiffness of Figures 4 and 5 (N/m)
EDGE = 0.115 * np.tan(np.radians(20.0))
"""Distance from its midpoint at which the line crosses the boundary of the pad (m)."""
_MIDDLE, _HALF, _SAMPLES = (0.115, 45.0), 0.07, 281
"""Radius (m) and angle (degrees) of the midpoint of the line, which is tangential; half its length
(m); number of points."""
_NEAR_EDGE = 0.004  # distance from the boundary within which the slope is taken (m)
_ALIKE = 0.5  # modal assurance above which modes of the two runs match


@dataclass(frozen=True)
class Pair(Figure):
    """A run without lumping, and one with it."""

    P: float  # contact stiffness (N/m)

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Return the scenes of both runs."""
        both = {"plain": GPTS, "lumped": LUMPED}
        return {name: replace(case, P=self.P).scene(mesh) for name, case in both.items()}


class ModeShapes(Pair):
    """A mode with and without lumping."""

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Run both cases and compare one mode of each."""
        results = {name: session.solve(scene) for name, scene in session.scene.items()}
        plain, lumped = (Spectrum.of(result) for result in results.values())
        match = paired(lumped, plain)
        label = case_row(self.P, 1, LUMPED.on(mesh))
        measured = label | measures(lumped, plain, match) | {"paper": "much below 1"}
        modes = common_mode(match, plain)[::-1]
        motion = lumped.motion[modes[1]] / plain.motion[modes[0]]
        lines, numbers, slopes = [], [], []
        curves: list[Floats] = []
        for (name, result), mode in zip(results.items(), modes, strict=True):
            value = result.eigenvalues[mode]
            numbers.append(quoted(f"{name}: frequency", None, value.imag / tau, "Hz"))
            numbers.append(quoted(f"{name}: growth rate", None, value.real, "1/s"))
            line = mode_line(result, mode)
            arc, disc = line["arc"], line["disc"]
            curves.append(disc)
            steepness = np.abs(np.gradient(disc, arc))
            slopes.append(steepness[np.abs(np.abs(arc) - EDGE) < _NEAR_EDGE].max())
            pad = [None if np.isnan(u) else u for u in line["pad"]]
            lines += [{"run": name, **row} for row in rows_of(line | {"pad": pad})]
            session.keep_modes(f"{name}-{mesh}", result, [mode], f"{name}, {mesh}")
        over = "lumped over plain"
        slope = "slope of the disc at the boundary of the pad"
        far = np.abs(curves[1] - curves[0]).max()
        numbers += [
            quoted(f"motion of the disc in the contact, {over}", "much below 1", motion),
            quoted(f"{slope}, {over}", "above 1", slopes[1] / slopes[0]),
            quoted("largest difference of the disc's lines, of 1", None, far),
        ]
        return {"measures": [measured], "lines": lines, "numbers": numbers}


def common_mode(match: ModeMatch, reference: Spectrum) -> tuple[int, int]:
    """Return the numbers, in both runs, of the matched mode with the largest contact motion."""
    pairs = [
        (int(pair.first[0]), int(pair.second[0]))
        for pair in match.groups
        if len(pair.first) == len(pair.second) == 1 and pair.assurance > _ALIKE
    ]
    return max(pairs, key=lambda pair: np.nan_to_num(reference.motion[pair[1]]))


def mode_line(result: Result, mode: int) -> dict[str, Floats]:
    """Return normal displacements of disc (largest 1) and pad along ``arc`` (m), or NaN."""
    arc, angle = np.linspace(-_HALF, _HALF, _SAMPLES), np.radians(_MIDDLE[1])
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
    return {"arc": arc} | {name: (u / peak).real for name, u in lines.items()}


SHAPES = ModeShapes("4 and 5", "Figures 4 and 5: a mode with and without lumping, P = 10⁶", P)
"""Figures 4 and 5."""


class Lumping(Pair):
    """False stiffness of lumped contact."""

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return shifts of all modes, and energies of a rotation."""
        plain, lumped = (session.solve(scene) for scene in session.scene.values())
        match = paired(Spectrum.of(lumped), Spectrum.of(plain))
        omega, reference = (values.imag for values in means_of(match))
        shifts, false = omega / reference - 1, false_shifts(plain, lumped)
        expected = np.array([false[pair.second].mean() for pair in match.groups])
        columns = {"frequency": reference / tau, "shift": shifts, "false_shift": expected}
        summary = {
            "rotation_plain": rotation_ratio(plain),
            "rotation_lumped": rotation_ratio(lumped),
            "largest_shift": float(np.abs(shifts).max()),
            "explained": float(1 - np.sum((shifts - expected) ** 2) / np.sum(shifts**2)),
        }
        return {"lumping": [summary], "lumping_shifts": rows_of(columns)}


def false_shifts(plain: Result, lumped: Result) -> Floats:
    """Return first-order relative frequency shifts by the stiffness that lumping adds, (modes,)."""
    modes = plain.modes
    parts = ((1.0, lumped), (-1.0, plain))
    difference = scaled_total([(sign, run.system.contacts[0].K_n) for sign, run in parts])
    images = times(difference, modes.vectors)
    energies = columns_inner(modes.vectors, images, difference.comm).real
    destroy(difference)
    return energies / (2 * np.abs(modes.eigenvalues) ** 2)


def rotation_ratio(result: Result) -> float:
    """Return the contact energy of a rotation of both bodies over that of the pad alone."""
    contact, bodies = result.system.contacts[0], result.system.bodies
    height = result.interfaces["pad_disc"].points.x[:, 1].mean()

    def rotation(moved: Collection[str]) -> Floats:
        """Free dofs of this rank of the field u_z = y - height of some bodies."""
        parts = []
        for name, body in bodies.items():
            x = body.space.dof_positions
            assert x is not None  # the geometry has at most the degree of the space
            u = np.zeros_like(x)
            u[:, 2] = (x[:, 1] - height) * (name in moved)
            own = slice(*body.expansion.getOwnershipRange())
            parts.append(transposed_times(body.expansion, u.reshape(-1, 1)[own])[:, 0])
        return np.concatenate(parts)

    both = np.asfortranarray(np.column_stack([rotation(bodies), rotation([PAD])]))
    energies = columns_inner(both, times(contact.K_n, both), contact.K_n.comm)
    return float(energies[0] / energies[1])


LUMPING = Lumping(
    "lumping", "Frequency shifts by lumping, and by its false stiffness alone, P = 10⁹", LOW
)
"""The study."""
