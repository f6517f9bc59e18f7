"""What is kept of a state of steady sliding: the pressure at points that depend on no mesh."""

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from comparisons.paper.common.figure import Data, as_lists
from comparisons.paper.crowned_pad.case import CONTACT, COUNTER, DISC, FACE, PAD
from meshes.shapes import Crowned, Sector
from scenes import Result

RADII, ANGLES = 9, 60
"""Points across and along the pad."""


def common_points(pad: Crowned) -> tuple[Floats, Floats, Floats]:
    """Points of the crowned face at the midpoints of equal parts.

    Parameters
    ----------
    pad
        The crowned sector.

    Returns
    -------
    ndarray
        Radii (m), shape (RADII,).
    ndarray
        Angles (degrees), shape (ANGLES,).
    ndarray
        Points (m), radius by radius, shape (RADII * ANGLES, 3).
    """
    base = pad.base
    assert isinstance(base, Sector)
    r = _middles(base.inner_radius, base.outer_radius, RADII)
    theta = _middles(base.start, base.end, ANGLES)
    radius, angle = (part.ravel() for part in np.meshgrid(r, np.deg2rad(theta), indexing="ij"))
    flat = [radius * np.cos(angle), radius * np.sin(angle), np.full(radius.size, base.bottom)]
    return r, theta, pad.crown(np.column_stack(flat))


def _middles(low: float, high: float, count: int) -> Floats:
    return low + (high - low) * (np.arange(count) + 0.5) / count


def closures(result: Result, x: Floats) -> Floats:
    """Closures u_n - g_n (m) that the displacements of a state of steady sliding give at points.

    Parameters
    ----------
    result
        A run with steady sliding.
    x
        Points on the face of the pad (m), shape (n, 3).

    Raises
    ------
    InputError
        When a point lies on no side.
    """
    assert result.steady is not None
    bodies, system, state = result.system.bodies, result.system, result.steady.displacement
    pad, disc = bodies[PAD].surfaces[FACE], bodies[DISC].surfaces[COUNTER]
    up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    own = pad.locate(x, up, pad.mesh_size)
    normal = pad.normal(own.at)
    opposite = disc.locate(x + own.distance[:, None] * up, normal, disc.mesh_size)
    if own.missed.any() or opposite.missed.any():
        raise InputError("x", f"{len(x)} points", "points between both sides of the contact")
    moved = pad.trace(own.at) @ system.displacement(state, PAD).reshape(-1, 3)
    moved -= disc.trace(opposite.at) @ system.displacement(state, DISC).reshape(-1, 3)
    gap = opposite.distance + disc.offset(opposite.at, normal) - pad.offset(own.at, normal)
    return np.einsum("ij,ij->i", normal, moved) - gap


def kept(result: Result) -> Data:
    """What is kept of a run, plain data: the equilibrium, the contact stiffness, the growth."""
    assert result.steady is not None
    law = result.scene.contacts[CONTACT].law
    pad = result.scene.bodies[PAD].geometry
    assert law is not None
    assert isinstance(pad, Crowned)
    state = result.steady.contacts[CONTACT]
    weight = result.interfaces[CONTACT].points.weight
    _, _, x = common_points(pad)
    closed = closures(result, x)
    unstable = np.flatnonzero(result.unstable)
    return {
        "dofs": result.system.size,
        "points": len(weight),
        "closed": state.closed_fraction,
        "force": state.normal_force,
        "P": float(weight @ state.stiffness),
        "pressure": as_lists(law.pressure(closed)),
        "stiffness": as_lists(law.slope(closed)),
        "iterations": result.steady.iterations,
        "seconds": result.timer.total,
        "growth": float(result.growth_rates.max(initial=0.0)),
        "unstable": [
            [float(result.frequencies[mode]), float(result.growth_rates[mode])] for mode in unstable
        ],
    }


def distance(case: Data, exact: Data) -> float:
    """Distance of the pressure of a case from the exact integration, in the mean square."""
    ours, theirs = np.array(case["pressure"]), np.array(exact["pressure"])
    return float(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs))


def off(case: Data, exact: Data, what: str) -> float:
    """A number of a case relative to that of the exact integration, less 1."""
    return float(case[what] / exact[what] - 1)
