"""What is kept of a run of disc and pad: its modes seen at points that depend on no mesh."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.mode_matching import NEAR, GroupMatch, ModeSet, match_modes
from cea.errors import InputError
from comparisons.paper.disc_pad import DISC, PAD
from meshes.shapes import Annulus, Sector
from scenes import Result

Data = dict[str, Any]

_SHAPE_GRID = (7, 12)
"""Points across and along the contact at which shapes are compared."""
_CIRCLES, _AROUND = (0.2, 0.5, 0.8, 0.98), 36
"""Circles on the disc, by the part of its width, and points on each."""
_IN_PLANE = 1e-6
"""Normal motion below this part of all motion is rounding: the disc moves in its plane."""


@dataclass(frozen=True)
class Spectrum:
    """What is kept of a run.

    Parameters
    ----------
    data
        Plain data: ``dofs``, ``points``, ``seconds``, ``search`` (s); ``eigenvalues``, each with
        ``re``, ``im``, ``residual`` and ``condition``; ``unstable``, each with ``mode``,
        ``frequency`` and ``growth``; ``contact_motion`` and ``contact_gap`` of every mode.
    modes
        Eigenvalues, and shapes at points that do not depend on the mesh.
    """

    data: Data
    modes: ModeSet

    @property
    def unstable(self) -> ModeSet:
        """Its unstable modes."""
        chosen = [mode["mode"] for mode in self.data["unstable"]]
        return ModeSet(self.modes.eigenvalues[chosen], self.modes.shapes[:, chosen])


def spectrum_of(result: Result) -> Spectrum:
    """What is kept of a run; collective."""
    modes = result.modes
    shapes, motion, gap = _shapes(result)
    values = zip(modes.eigenvalues, modes.residuals, modes.conditions, strict=True)
    data = {
        "dofs": result.system.size,
        "points": sum(len(interface.points) for interface in result.interfaces.values()),
        "seconds": result.timer.total,
        "search": result.timer.seconds["search"],
        "eigenvalues": [
            {"re": value.real, "im": value.imag, "residual": residual, "condition": condition}
            for value, residual, condition in values
        ],
        "unstable": [
            {
                "mode": int(mode),
                "frequency": float(result.frequencies[mode]),
                "growth": float(result.growth_rates[mode]),
            }
            for mode in np.flatnonzero(result.unstable)
        ],
        "contact_motion": motion,
        "contact_gap": gap,
    }
    return Spectrum(data, ModeSet(modes.eigenvalues, shapes))


def compare_spectra(first: Spectrum, second: Spectrum) -> Data:
    """Pair the modes of two runs.

    Returns
    -------
    dict
        Plain data: ``groups``, all modes that stand for one another with mean eigenvalues
        [re, im] of both and the assurance; ``unstable``, the unstable ones mode by mode, all
        that can be paired; ``only_first`` and ``only_second``, unstable modes without a partner;
        ``unpaired``, how many modes of either run have none.
    """
    every = match_modes(first.modes, second.modes, NEAR)
    alone = match_modes(first.unstable, second.unstable, near=0.0, limit=None)
    return {
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


def _shapes(result: Result) -> tuple[Complexes, list[float | None], list[float | None]]:
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
    radii, angles = (
        start + (end - start) * (np.arange(n) + 0.5) / n
        for start, end, n in (
            (pad.inner_radius, pad.outer_radius, _SHAPE_GRID[0]),
            (pad.start, pad.end, _SHAPE_GRID[1]),
        )
    )
    contact = _polar(radii, angles, disc.top)
    width = disc.outer_radius - disc.inner_radius
    around = np.linspace(0.0, 360.0, _AROUND, endpoint=False)
    circles = _polar(disc.inner_radius + width * np.array(_CIRCLES), around, disc.top)
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
    motion = _rms(side_b[2::3])
    gap = _rms(side_b[2::3] - side_a[2::3])
    return shapes, _ratios(motion, _rms(rest[2::3][outside]), least), _ratios(gap, motion, least)


def _ratios(motion: Floats, relative_to: Floats, least: Floats) -> list[float | None]:
    """Of two motions in each mode, where the second is more than the least."""
    every = zip(motion.tolist(), relative_to.tolist(), least.tolist(), strict=True)
    return [above / below if below > small else None for above, below, small in every]


def _rms(values: Complexes) -> Floats:
    """Root mean square over the rows, shape (modes,)."""
    return np.sqrt((np.abs(values) ** 2).mean(axis=0))


def _polar(r: Floats, theta: Floats, z: float) -> Floats:
    """Points at all radii (m) and angles (degrees), shape (n, 3)."""
    radius, angle = (part.ravel() for part in np.meshgrid(r, np.radians(theta)))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), z)])


def displacements(
    result: Result, body: str, surface: str, x: Floats, modes: Sequence[int] | None = None
) -> tuple[Complexes, Any]:
    """Displacements of modes at points of a surface that the z axis meets.

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
    found = side.locate(x, np.tile([0.0, 0.0, 1.0], (len(x), 1)), side.mesh_size)
    hit = ~found.missed
    if not hit.any():
        raise InputError("x", f"{len(x)} points", f"points on {body}.{surface}")
    u = result.mode_shapes(f"{body}.{surface}", found.at[hit], modes)
    return u.reshape(-1, u.shape[-1]), hit
