"""Forces that supports bear: what is left of the equilibrium at the dofs they hold.

    r = K u - F - (forces of the contacts),    zero but at held dofs

over all dofs of a body, its supports' included.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.body import Body
from cea.contact.operators import Contact
from cea.matrices import destroy, gather
from cea.petsc import MPI
from cea.supports.boundary import Support
from cea.supports.frames import Cartesian
from cea.system.coupled import CoupledSystem


def support_reactions(
    system: CoupledSystem, supports: Mapping[str, Sequence[Support]], x: Any
) -> dict[str, Floats]:
    """Resultant (N) of the forces of each support on its body; collective.

    The force at a dof that several supports hold along a component is shared evenly among them;
    their sum is that of the body whatever the shares. Components of other frames than x, y, z
    count as all held.

    Parameters
    ----------
    system
        The coupled system, linearised about its state of steady sliding where it has one.
    supports
        Supports by body.
    x
        Free displacements under the loads (m), PETSc vector.

    Returns
    -------
    dict
        Shape (supports, dim) each, in their order. Bodies whose contacts are tied, bonded or
        lumped are left out: the forces of these are not known at points. So are bodies whose
        rotation puts forces on displacements at rest in space, which are not known at held dofs.
    """
    forces = _contact_forces(system, x)
    for name, motion in system.pieces.motions.items():
        if motion.in_equilibrium:
            forces.pop(name, None)
    return {
        name: _shared(body, supports[name], _residual(system, name, x) - forces[name])
        for name, body in system.bodies.items()
        if supports.get(name) and name in forces
    }


def _residual(system: CoupledSystem, name: str, x: Any) -> Floats:
    """K u - F of a body on all its dofs (N), shape (num_scalar_dofs, dim), on every rank."""
    body = system.bodies[name]
    stiffness, load = body.full_stiffness(), body.full_load()
    u, force = body.expansion.createVecLeft(), body.expansion.createVecLeft()
    first, last = u.getOwnershipRange()
    u.array[:] = system.displacement(x, name)[first:last]
    stiffness.mult(u, force)
    force.axpy(-1.0, load)
    left = gather(force).reshape(-1, body.dim)
    destroy(stiffness, load, u, force)
    return left


def _contact_forces(system: CoupledSystem, x: Any) -> dict[str, Floats]:
    """Forces (N) of contacts on all dofs of the bodies of which all are known."""
    forces = {
        name: np.zeros((body.num_scalar_dofs, body.dim)) for name, body in system.bodies.items()
    }
    for contact in system.contacts:
        sides = (contact.half.a, contact.half.b)
        if not contact.has_pressure or contact.half.coupling == "lumped":
            for name in sides:
                forces.pop(name, None)
            continue
        interface = contact.interface
        on_a = _force_on_a(contact, _pressure(contact, x))[interface.rows]
        traces = (interface.trace_a, interface.trace_b)
        for name, trace, sign in zip(sides, traces, (1.0, -1.0), strict=True):
            if name in forces:
                part = sign * (trace.T @ on_a)
                forces[name] += interface.comm.allreduce(part, MPI.SUM)
    return forces


def _pressure(contact: Contact, x: Any) -> Floats:
    """Contact pressure at all points (N/m^2) as the traces of side a bear it."""
    if not contact.half.law.linear:
        return contact.reactions.met(contact.half.pressure)
    pressure = contact.pressure(x)
    if contact.prescribed is not None:
        pressure = pressure + contact.half.stiffness * contact.prescribed
    return pressure


def _force_on_a(contact: Contact, pressure: Floats) -> Floats:
    """Forces (N) on side a at all points, shape (n, dim)."""
    half, points = contact.half, contact.interface.points
    force = -(points.weight * pressure)[:, None] * points.normal
    if half.friction is not None and half.friction.acts:
        direction = half.friction.direction.at(points.x, points.normal)
        force += (points.weight * pressure * half.friction.mu)[:, None] * direction
    return force


def _shared(body: Body, supports: Sequence[Support], force: Floats) -> Floats:
    """Resultants of forces on all dofs, shared among the supports that hold these."""
    held = np.zeros((len(supports), body.num_scalar_dofs, body.dim), dtype=bool)
    for number, support in enumerate(supports):
        dofs = _dofs(body, support.surface)
        if isinstance(support.frame, Cartesian) and support.components is not None:
            held[number, dofs[:, None], list(set(support.components))] = True
        else:
            held[number, dofs] = True
    share = held / np.maximum(held.sum(axis=0), 1)
    return np.einsum("sij,ij->sj", share, force)


def _dofs(body: Body, surface: str) -> Ints:
    """Scalar dofs that move a surface."""
    trace = body.surfaces[surface].trace(body.surfaces[surface].gauss_points(2).at)
    return np.unique(trace.indices[trace.data != 0]).astype(np.int64)
