"""Runs of disc and pad, made once, and what is kept of them: modes seen at common points."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.body import Body
from cea.eigen.matching import NEAR, GroupMatch, ModeSet, match_modes
from cea.errors import InputError
from comparisons.paper.common.families import Family
from comparisons.paper.common.figure import Data
from comparisons.paper.common.store import fingerprint
from comparisons.paper.disc_pad.case import DISC, PAD, CeaCase
from meshes.shapes import Annulus, Sector
from scenes import Result, run_modes
from scenes.results.describe import describe_modes
from scenes.spec.plain import as_data

_SHAPE_GRID = (7, 12)
"""Points across and along the contact at which shapes are compared."""
_CIRCLES = ((0.2, 0.5, 0.8, 0.98), 36)
"""Circles on the disc, by the part of its width, and points on each."""
_IN_PLANE = 1e-6
"""Normal motion below this part of all motion is rounding: the disc moves in its plane."""

type Ratios = list[float | None]
"""One for each mode, none where the motion it would be relative to vanishes."""


@dataclass(frozen=True)
class Spectrum:
    """What is kept of a run.

    Parameters
    ----------
    label
        Label of the case.
    data
        Plain data: dofs, points, seconds, eigenvalues, unstable modes.
    modes
        Eigenvalues, and shapes at points that do not depend on the mesh.
    """

    label: str
    data: Data
    modes: ModeSet

    @property
    def unstable(self) -> ModeSet:
        """Its unstable modes."""
        chosen = [mode["mode"] for mode in self.data["unstable"]]
        return ModeSet(self.modes.eigenvalues[chosen], self.modes.shapes[:, chosen])


@dataclass
class Runs:
    """Runs already made, so that figures which share a case compute it once.

    Bodies of the last discretisation only are kept, spectra of all.
    """

    _spectra: dict[str, Spectrum] = field(default_factory=dict)
    _bodies: tuple[str, Mapping[str, Body]] | None = None

    def spectrum(self, case: CeaCase, family: Family) -> Spectrum:
        """Modes of a case, computed where they are not known."""
        mark = fingerprint(as_data(case.scene(family)))
        if mark not in self._spectra:
            self.result(case, family)
        return self._spectra[mark]

    def result(self, case: CeaCase, family: Family) -> Result:
        """Run a case; its spectrum is kept."""
        scene = case.scene(family)
        mesh = fingerprint({name: as_data(body) for name, body in scene.bodies.items()})
        known = self._bodies[1] if self._bodies and self._bodies[0] == mesh else None
        self._bodies = None
        result = run_modes(scene, bodies=known)
        self._bodies = mesh, result.system.bodies
        self._spectra[fingerprint(as_data(scene))] = _spectrum(case.on(family).label, result)
        return result


RUNS = Runs()
"""Runs of this process."""

_OF_A_VALUE = ("re", "im", "residual", "condition", "uncertainty", "verdict")
"""What is stored of an eigenvalue; figures refer to one by its index, from 0."""


def _spectrum(label: str, result: Result) -> Spectrum:
    modes = result.modes
    described = describe_modes(modes, result.analysis.growth_threshold)
    data = {
        "dofs": result.system.size,
        "points": sum(len(interface.points) for interface in result.interfaces.values()),
        "seconds": result.timer.total,
        "timings": dict(result.timer.seconds),
        "eigenvalues": [{key: e[key] for key in _OF_A_VALUE} for e in described["eigenvalues"]],
        "unstable": [
            {"mode": mode["mode"] - 1, "frequency": mode["frequency"], "growth": mode["growth"]}
            for mode in described["unstable"]
        ],
        "growth_uncertainty": float(modes.growth_uncertainties.max(initial=0.0)),
    }
    shapes, data["contact_motion"], data["contact_gap"] = _shapes(result)
    return Spectrum(label, data, ModeSet(modes.eigenvalues, shapes))


def _shapes(result: Result) -> tuple[Complexes, Ratios, Ratios]:
    """What all modes look like at points that do not depend on the mesh.

    Returns
    -------
    ndarray
        Displacements on both sides of the contact and on circles of the disc, (rows, modes).
    list
        Normal motion of the disc in the contact relative to that on the rest of the circles.
    list
        Gap in the contact relative to the normal motion of the disc there. Both None for modes
        in which the disc moves in its plane only.
    """
    disc, pad = (result.scene.bodies[name].geometry for name in (DISC, PAD))
    assert isinstance(disc, Annulus)
    assert isinstance(pad, Sector)
    r, theta = (
        _inside(*ends, n)
        for ends, n in zip(
            ((pad.inner_radius, pad.outer_radius), (pad.start, pad.end)), _SHAPE_GRID, strict=True
        )
    )
    contact = _polar(r, theta, disc.top)
    parts, angles = _CIRCLES
    width = disc.outer_radius - disc.inner_radius
    radii = disc.inner_radius + width * np.array(parts)
    around = np.linspace(0.0, 360.0, angles, endpoint=False)
    circles = _polar(radii, around, disc.top)
    side_b = displacements(result, DISC, "top", contact)[0]
    rest = displacements(result, DISC, "top", circles)[0]
    side_a = displacements(result, PAD, "bottom", contact)[0]
    radius, angle = np.hypot(*circles[:, :2].T), np.degrees(np.arctan2(*circles[:, 1::-1].T))
    outside = (
        (radius < pad.inner_radius)
        | (radius > pad.outer_radius)
        | ((angle - pad.start) % 360 > pad.end - pad.start)
    )
    shapes = np.concatenate([side_b, rest, side_a])
    least = _IN_PLANE * _rms(shapes)
    disc_motion = _rms(side_b[2::3])
    motion = _ratios(disc_motion, _rms(rest[2::3][outside]), least)
    return shapes, motion, _ratios(_rms(side_b[2::3] - side_a[2::3]), disc_motion, least)


def _ratios(motion: Floats, relative_to: Floats, least: Floats) -> Ratios:
    """Of two motions in each mode, where the second is more than the least."""
    return [
        above / below if below > small else None
        for above, below, small in zip(
            motion.tolist(), relative_to.tolist(), least.tolist(), strict=True
        )
    ]


def _rms(values: Complexes) -> Floats:
    """Root mean square over the rows, shape (modes,)."""
    return np.sqrt((np.abs(values) ** 2).mean(axis=0))


def _inside(start: float, end: float, n: int) -> Floats:
    """Midpoints of n equal parts."""
    return start + (end - start) * (np.arange(n) + 0.5) / n


def _polar(r: Floats, theta: Floats, z: float) -> Floats:
    """Points at all radii (m) and angles (degrees), shape (n, 3)."""
    radius, angle = (part.ravel() for part in np.meshgrid(r, np.radians(theta)))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), z)])


def displacements(
    result: Result,
    body: str,
    surface: str,
    x: Floats,
    modes: Sequence[int] | None = None,
    *,
    axis: int = 2,
) -> tuple[Complexes, Any]:
    """Displacements of modes at points of a surface that an axis meets.

    Parameters
    ----------
    result
        A run with modes.
    body, surface
        The surface.
    x
        Points (m), shape (n, 3).
    modes
        Numbers of the modes; None takes all.
    axis
        Axis along which they are looked for.

    Returns
    -------
    ndarray
        Components of the points that were found, point by point, shape (3 found, modes).
    ndarray
        Which points were found, shape (n,).

    Raises
    ------
    InputError
        When none was.
    """
    side = result.system.bodies[body].surfaces[surface]
    found = side.locate(x, np.tile(np.eye(3)[axis], (len(x), 1)), side.mesh_size)
    hit = ~found.missed
    if not hit.any():
        raise InputError("x", f"{len(x)} points", f"points on {body}.{surface}")
    u = result.mode_shapes(f"{body}.{surface}", found.at[hit], modes)
    return u.reshape(-1, u.shape[-1]), hit


def compare_spectra(first: Spectrum, second: Spectrum) -> Data:
    """Pair the modes of two runs.

    Returns
    -------
    dict
        Plain data: ``groups``, all modes that stand for one another with mean eigenvalues
        [re, im] of both and the assurance; ``unstable``, the unstable ones mode by mode, all
        that can be paired; ``only_first`` and ``only_second``, unstable modes without a partner.
    """
    every = match_modes(first.modes, second.modes, NEAR)
    alone = match_modes(first.unstable, second.unstable, near=0.0, limit=None)
    return {
        "first": first.label,
        "second": second.label,
        "groups": [_group(group) for group in every.groups],
        "unpaired": [len(every.only_first), len(every.only_second)],
        "unstable": [_group(group) for group in alone.groups],
        "only_first": len(alone.only_first),
        "only_second": len(alone.only_second),
    }


def _group(match: GroupMatch) -> Data:
    return {
        "modes": [match.first.tolist(), match.second.tolist()],
        "lambda": [[value.real, value.imag] for value in match.means],
        "assurance": match.assurance,
    }
