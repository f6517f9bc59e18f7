"""Forces of contacts on all dofs of the bodies they join, those that supports hold too.

A normal force s at a point pushes side a by - s (n - mu k) and side b by as much the other way; on
a body it is spread by the trace of its side. Where forces are unknowns of what was solved they are
taken from there, for gaps do not tell those of stiff and tied contacts:

    points:   s = sqrt(W p^) Q f,    so that    (n - mu k).N^T s = (Q^T sqrt(W p^) (n - mu k).N)^T f
    mortar:   s = w psi f.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, hstack

from cea.arrays import Floats
from cea.contact.half_pass import friction_at
from cea.contact.interface import along
from cea.contact.operators import Contact
from cea.contact.saddle import few_forces, keeping_forces
from cea.matrices import destroy
from cea.petsc import MPI


@dataclass(frozen=True)
class SideForces:
    """Forces of a contact on one of its bodies.

    Parameters
    ----------
    contact
        Name of the contact.
    body
        Name of the body.
    forces
        On all its dofs (N), the same on every rank, shape (num_scalar_dofs, dim).
    sizes
        Stiffness times displacements of the sides (N), of which they are small differences where
        gaps tell them, shape (num_scalar_dofs,).
    """

    contact: str
    body: str
    forces: Floats
    sizes: Floats


def forces_on_bodies(
    contacts: Sequence[Contact], displacements: Mapping[str, Floats], x: Any, multipliers: Floats
) -> Iterator[SideForces]:
    """Forces of contacts on both their sides in equilibrium; collective.

    Parameters
    ----------
    contacts
        The contacts, those with a law linearised about the equilibrium.
    displacements
        Displacement of all dofs of each body (m), shape (dim * num_scalar_dofs,).
    x
        Free displacements (m), PETSc vector.
    multipliers
        Contact forces that are unknowns, the rows of this rank, of all contacts of a linear law.
    """
    linear = [contact for contact in contacts if contact.half.law.linear]
    for contact in contacts:
        if contact.lumped is not None:
            yield from _lumped(contact, displacements)
            continue
        if not contact.half.law.linear:
            pressure = contact.reactions.met(contact.half.pressure)
            yield from _of_pressure(contact, pressure, displacements)
        elif not contact.keeps_forces:
            yield from _of_pressure(contact, contact.pressure(x), displacements)
        if contact.prescribed is not None and contact.half.law.linear:
            pressure = contact.half.stiffness * contact.prescribed
            yield from _of_pressure(contact, pressure, displacements)
    for halves in keeping_forces(linear).values():
        if halves[0].projection is None:
            sides, used = _of_few(halves, multipliers)
            yield from sides
            multipliers = multipliers[used:]
            continue
        for half in halves:
            size = half.gap.getLocalSize()[0]
            yield from _projected(half, multipliers[:size])
            multipliers = multipliers[size:]


def _of_pressure(
    contact: Contact, pressure: Floats, displacements: Mapping[str, Floats]
) -> Iterator[SideForces]:
    """Of a pressure at all points (N/m^2) on every rank, which gaps tell."""
    interface = contact.interface
    normal_force = (interface.points.weight * pressure)[interface.rows]
    sizes = _sizes(contact, displacements)
    return _on_sides(contact, -normal_force[:, None] * _against(contact), sizes)


def _sizes(contact: Contact, displacements: Mapping[str, Floats]) -> Floats:
    """Stiffness times displacements of both sides at the points of this rank (N), (n_local,)."""
    interface, half = contact.interface, contact.half
    moved = np.zeros(len(interface.local_points))
    for name, trace in ((half.a, interface.trace_a), (half.b, interface.trace_b)):
        u = displacements[name].reshape(trace.shape[1], -1)
        moved += abs(trace) @ np.linalg.norm(u, axis=1)
    return interface.local_points.weight * half.stiffness[interface.rows] * moved


def _projected(contact: Contact, multipliers: Floats) -> Iterator[SideForces]:
    """Of multipliers of mortar or bonded contact, the rows of this rank."""
    assert contact.projection is not None
    traces, points = contact.projection.traces, contact.interface.local_points
    axes = points.x.shape[1] if contact.half.coupling == "bonded" else 1
    tractions = []
    for own in multipliers.reshape(axes, -1):
        multiplier, traction = traces.createVecs()
        multiplier.array[:] = own
        traces.mult(multiplier, traction)
        tractions.append(np.array(traction.array_r))
        destroy(multiplier, traction)
    along_axes = np.column_stack(tractions)
    pushed = along_axes if axes > 1 else along_axes * _against(contact)
    forces = -points.weight[:, None] * pushed
    return _on_sides(contact, forces, np.zeros(len(points)))


def _against(contact: Contact) -> Floats:
    """Direction n - mu k that contact forces push against, at the points of this rank."""
    half, points = contact.half, contact.interface.local_points
    if half.friction is None or not half.friction.acts:
        return points.normal
    direction = half.friction.direction.at(points.x, points.normal)
    return points.normal - friction_at(half)[0][:, None] * direction


def _on_sides(contact: Contact, on_a: Floats, sizes: Floats) -> Iterator[SideForces]:
    """Forces (N) on side a, and sizes, at the points of this rank, spread over both bodies."""
    interface, half = contact.interface, contact.half
    for name, trace, sign in ((half.a, interface.trace_a, 1.0), (half.b, interface.trace_b, -1.0)):
        forces = interface.comm.allreduce(sign * (trace.T @ on_a), MPI.SUM)
        spread = interface.comm.allreduce(abs(trace).T @ sizes, MPI.SUM)
        yield SideForces(contact.pair, name, forces, spread)


def _lumped(contact: Contact, displacements: Mapping[str, Floats]) -> Iterator[SideForces]:
    """Of lumped contact: the displacement of a dof stands for that of its body at the points."""
    interface, half = contact.interface, contact.half
    points = interface.local_points
    pushed = (points.weight * half.stiffness[interface.rows])[:, None] * _against(contact)
    sizes = _sizes(contact, displacements)
    sides = ((half.a, interface.trace_a), (half.b, interface.trace_b))
    dim = points.x.shape[1]
    for (name, trace), (other, opposite) in (sides, sides[::-1]):
        u, v = (displacements[each].reshape(-1, dim) for each in (name, other))
        far = trace.T @ (np.einsum("qi,qi->q", points.normal, opposite @ v)[:, None] * pushed)
        blocks = trace.T @ np.einsum("qi,qj->qij", pushed, points.normal).reshape(-1, dim * dim)
        near = np.einsum("nij,nj->ni", blocks.reshape(-1, dim, dim), u)
        forces = interface.comm.allreduce(far - near, MPI.SUM)
        spread = interface.comm.allreduce(abs(trace).T @ sizes, MPI.SUM)
        yield SideForces(contact.pair, name, forces, spread)


def _of_few(halves: Sequence[Contact], multipliers: Floats) -> tuple[list[SideForces], int]:
    """Of compressed forces, the first of those given; and how many they are on this rank."""
    half, interface = halves[0].half, halves[0].interface
    names = (half.a, half.b)
    closure, spread = few_forces(halves, [_rows_on(contact, names) for contact in halves])
    used = closure.shape[0]
    against = interface.comm.allreduce(spread.T @ multipliers[:used], MPI.SUM)
    dim = interface.a.dim
    parts = np.split(against.reshape(-1, dim), [interface.trace_a.shape[1]])
    found = [
        SideForces(halves[0].pair, name, -part, np.zeros(len(part)))
        for name, part in zip(names, parts, strict=True)
    ]
    return found, used


def _rows_on(contact: Contact, names: tuple[str, str]) -> csr_array:
    """Jump along n - mu k at the points of this rank, from all dofs of two bodies in turn."""
    against, interface = _against(contact), contact.interface
    parts = {
        contact.half.a: along(interface.trace_a, against),
        contact.half.b: along(interface.trace_b, -against),
    }
    return csr_array(hstack([parts[name] for name in names]))
