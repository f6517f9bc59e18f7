"""Contact operators of one interface from its points: closures, slips, projections."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.body.unknowns import system_operator
from cea.contact.half_pass import HalfPass, friction_at
from cea.contact.interface import jump_along
from cea.contact.lumping import lumped_matrices
from cea.contact.mortar import MortarProjection
from cea.contact.operators import Contact
from cea.matrices import destroy, gather, one_below_the_other
from cea.ranks import agreed


def assemble_contact(
    bodies: Mapping[str, Body], name: str, half: HalfPass, *, leave_out: bool = True
) -> Contact:
    """Contact operators of one half pass.

    Parameters
    ----------
    bodies
        All bodies of the system by name, in the order of the unknowns.
    name
        Name of the half pass.
    half
        The half pass.
    leave_out
        Whether the slip operator and K_f are left out where mu = 0.
    """
    interface, sides = half.interface, (half.a, half.b)
    points = interface.local_points
    projection = None
    if half.projected:
        # Of a linear law, open points have no part in the projection: their compliance is infinite.
        bearing = half.stiffness > 0 if half.law.linear else None
        # Bonded sides close the jump along fixed axes: no normal splits their traces.
        bonded = half.coupling == "bonded"
        traces = interface.trace_a if bonded else interface.a.split_trace(points.at)
        projection = MortarProjection.of(interface, traces, bearing)

    def operator(direction: Floats) -> Any:
        parts = dict(zip(sides, jump_along(interface, direction), strict=True))
        jump = system_operator(bodies, parts, len(points))
        if projection is None:
            return jump
        integrals = projection.integrals(jump)
        destroy(jump)
        return integrals

    if half.coupling == "bonded":
        axes = [operator(np.tile(axis, (len(points), 1))) for axis in np.eye(interface.a.dim)]
        gap = one_below_the_other(axes)
        destroy(*axes)
    else:
        gap = operator(points.normal)
    slip = direction = None
    field, mu = friction_at(half)
    keeps = not leave_out and half.coupling != "bonded"
    if half.friction is not None and (half.friction.acts or keeps):
        with agreed(interface.comm):
            direction = half.friction.direction.at(points.x, points.normal)
        slip = operator(field[:, None] * direction)
    lumped = None
    if half.coupling == "lumped":
        weight = points.weight * half.stiffness[interface.rows]
        lumped = lumped_matrices(bodies, sides, interface, weight, direction, field)
    closed = prescribed_closure(bodies, half)
    return Contact(name, half, gap, slip, mu, projection, lumped, closed)


def prescribed_closure(bodies: Mapping[str, Body], half: HalfPass) -> Floats | None:
    """What displacements that supports prescribe close of the gap at all points (m), shape (n,).

    None where nothing is prescribed, or nothing of it reaches the contact.
    """
    closed = _closed_by_supports(bodies, half, half.interface.local_points.normal)
    if closed is None:
        return None
    every = np.concatenate(half.interface.comm.allgather(closed))
    return every if every.any() else None


def approach_along(bodies: Mapping[str, Body], half: HalfPass, direction: Floats, x: Any) -> Floats:
    """What the bodies approach each other along given directions at all points (m), shape (n,).

    Parameters
    ----------
    bodies, half
        As for :func:`assemble_contact`.
    direction
        Vectors at the points of this rank, shape (n_local, dim).
    x
        Unknowns of the system (m), PETSc vector; what supports prescribe is added.
    """
    interface = half.interface
    parts = dict(zip((half.a, half.b), jump_along(interface, direction), strict=True))
    jump = system_operator(bodies, parts, len(interface.local_points))
    approach = jump.createVecLeft()
    jump.mult(x, approach)
    values = gather(approach)
    destroy(jump, approach)
    closed = _closed_by_supports(bodies, half, direction)
    return values if closed is None else values + np.concatenate(interface.comm.allgather(closed))


def _closed_by_supports(
    bodies: Mapping[str, Body], half: HalfPass, direction: Floats
) -> Floats | None:
    """What prescribed displacements approach along directions at the points of this rank (m)."""
    if all(bodies[name].prescribed is None for name in (half.a, half.b)):
        return None
    closed = np.zeros(len(direction))
    for name, jump in zip((half.a, half.b), jump_along(half.interface, direction), strict=True):
        prescribed = bodies[name].prescribed
        if prescribed is not None:
            closed += jump @ gather(prescribed)
    return closed
