"""Forces of contacts on all dofs of the bodies they join, those that supports hold too.

A normal force s at a point pushes side a by - s (n - mu k) and side b by as much the other way; on
a body it is spread by the trace of its side. Where forces are unknowns of what was solved they are
taken from there, for gaps do not tell those of stiff and tied contacts:

    points:   s = sqrt(W p^) Q f,    so that    (n - mu k).N^T s = (Q^T sqrt(W p^) (n - mu k).N)^T f
    mortar:   s = w psi f.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, hstack

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.contact.interface import along
from cea.contact.saddle import few_forces, with_multipliers
from cea.matrices import destroy
from cea.petsc import MPI


@dataclass(frozen=True)
class SideForces:
    """Forces of a contact on one of its bodies."""

    contact: str  # name of the contact
    body: str  # name of the body
    forces: Floats  # on all its dofs (N), the same on every rank, shape (num_scalar_dofs, dim)
    # stiffness times displacements of the sides (N), of which they are small differences where
    # gaps tell them, shape (num_scalar_dofs,)
    sizes: Floats


def forces_on_bodies(
    contacts: Sequence[Contact], displacements: Mapping[str, Floats], x: object, multipliers: Floats
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
    linear = [contact for contact in contacts if contact.law.linear]
    for contact in contacts:
        if contact.lumped is not None:
            yield from _lumped(contact, displacements)
            continue
        if not contact.law.linear:
            assert contact.closure is not None
            pressure = contact.met(contact.law.pressure(contact.closure))
            yield from _of_pressure(contact, pressure, displacements)
        elif not contact.has_multipliers:
            yield from _of_pressure(contact, contact.pressure(x), displacements)
        if contact.prescribed is not None and contact.law.linear:
            pressure = contact.slope * contact.prescribed
            yield from _of_pressure(contact, pressure, displacements)
    for halves in with_multipliers(linear).values():
        if halves[0].projection is None:
            closure, spread = few_forces(halves, [_rows_on(half, halves[0]) for half in halves])
            own, multipliers = np.split(multipliers, [closure.shape[0]])
            yield from _on_sides(halves[0], -(spread.T @ own))
            continue
        for half in halves:
            size = half.gap.getLocalSize()[0]
            yield from _of_projected(half, multipliers[:size])
            multipliers = multipliers[size:]


def _of_pressure(
    contact: Contact, pressure: Floats, displacements: Mapping[str, Floats]
) -> Iterator[SideForces]:
    """Of a pressure at all points (N/m^2) on every rank, which gaps tell."""
    interface = contact.interface
    s = (interface.points.weight * pressure)[interface.rows]
    sizes = np.concatenate([abs(t).T @ _sizes(contact, displacements) for t in _traces(contact)])
    return _on_sides(contact, -(_rows_on(contact, contact).T @ s), sizes)


def _of_projected(contact: Contact, multipliers: Floats) -> Iterator[SideForces]:
    """Of multipliers of mortar or bonded contact, the rows of this rank."""
    assert contact.projection is not None
    traces, points = contact.projection.traces, contact.interface.local_points
    axes = points.x.shape[1] if contact.coupling == "bonded" else 1
    tractions = []
    for own in multipliers.reshape(axes, -1):
        multiplier, traction = traces.createVecs()
        multiplier.array[:] = own
        traces.mult(multiplier, traction)
        tractions.append(np.array(traction.array_r))
        destroy(multiplier, traction)
    pushed = np.column_stack(tractions)
    if axes == 1:
        pushed = pushed * _against(contact)
    on_a = points.weight[:, None] * pushed
    a, b = _traces(contact)
    return _on_sides(contact, -np.concatenate([(a.T @ on_a).ravel(), -(b.T @ on_a).ravel()]))


def _lumped(contact: Contact, displacements: Mapping[str, Floats]) -> Iterator[SideForces]:
    """Of lumped contact: the displacement of a dof stands for that of its body at the points."""
    points, sizes = contact.interface.local_points, _sizes(contact, displacements)
    pushed = points.weight * contact.slope[contact.interface.rows]
    pushed = pushed[:, None] * _against(contact)
    dim, traces = points.x.shape[1], _traces(contact)
    moved = [displacements[name].reshape(-1, dim) for name in (contact.a, contact.b)]
    forces = []
    for trace, u, opposite, v in zip(traces, moved, traces[::-1], moved[::-1], strict=True):
        far = trace.T @ (np.einsum("qi,qi->q", points.normal, opposite @ v)[:, None] * pushed)
        blocks = trace.T @ np.einsum("qi,qj->qij", pushed, points.normal).reshape(-1, dim * dim)
        near = np.einsum("nij,nj->ni", blocks.reshape(-1, dim, dim), u)
        forces.append((far - near).ravel())
    spread = np.concatenate([abs(trace).T @ sizes for trace in traces])
    return _on_sides(contact, np.concatenate(forces), spread)


def _traces(contact: Contact) -> tuple[csr_array, csr_array]:
    return contact.interface.trace_a, contact.interface.trace_b


def _sizes(contact: Contact, displacements: Mapping[str, Floats]) -> Floats:
    """Stiffness times displacements of both sides at the points of this rank (N), (n_local,)."""
    interface = contact.interface
    moved = np.zeros(len(interface.local_points))
    for name, trace in zip((contact.a, contact.b), _traces(contact), strict=True):
        u = displacements[name].reshape(trace.shape[1], -1)
        moved += abs(trace) @ np.linalg.norm(u, axis=1)
    return interface.local_points.weight * contact.slope[interface.rows] * moved


def _against(contact: Contact) -> Floats:
    """Direction n - mu k that contact forces push against, at the points of this rank."""
    points = contact.interface.local_points
    if contact.friction is None or not contact.has_friction:
        return points.normal
    direction = contact.friction.direction.at(points.x, points.normal)
    return points.normal - contact.mu_at_points[:, None] * direction


def _rows_on(contact: Contact, first: Contact) -> csr_array:
    """Jump along n - mu k at the points of this rank, from all dofs of sides a and b of the first.

    Its other half has these sides in turn.
    """
    against, (a, b) = _against(contact), _traces(contact)
    rows = {contact.a: along(a, against), contact.b: along(b, -against)}
    return csr_array(hstack([rows[first.a], rows[first.b]]))


def _on_sides(
    contact: Contact, forces: Floats, sizes: Floats | None = None
) -> Iterator[SideForces]:
    """Forces (N), and sizes, that the points of each rank put on all dofs of sides a and b."""
    interface, dim = contact.interface, contact.interface.a.dim
    ends = [interface.trace_a.shape[1]]
    every = interface.comm.allreduce(forces, MPI.SUM).reshape(-1, dim)
    of_all = np.zeros(len(every)) if sizes is None else interface.comm.allreduce(sizes, MPI.SUM)
    parts = zip((contact.a, contact.b), np.split(every, ends), np.split(of_all, ends), strict=True)
    for body, own, size in parts:
        yield SideForces(contact.pair, body, own, size)
