"""Forces that supports bear, and the equilibrium of every body as a whole.

    r = K u - F - (forces of the contacts)

over all dofs of a body is what its supports put on it: it is divided among them along the
directions that each holds (:mod:`cea.supports.constraints`). The resultants of loads, springs,
contacts and supports on a body, and their moments, add up to zero, and so do the forces of a
contact on its two sides.

A normal force s at a contact point pushes side a by - s (n - mu k) and side b by as much the other
way; on a body it is spread by the trace of its side. Where forces are unknowns of what was solved
they are taken from there, for gaps do not tell those of stiff and tied contacts:

    points:   s = sqrt(W p^) Q f,    so that    (n - mu k).N^T s = (Q^T sqrt(W p^) (n - mu k).N)^T f
    mortar:   s = w psi f.

Of a body that rotates (:mod:`cea.rotation`) forces on all dofs are, on the body and from outside,
Omega^2 Z u of the convective stiffness and - alpha Omega B u of the damping of the mass; elastic
forces are K (u + beta Omega M^-1 B u), K without springs. What modal damping does at held dofs its
modes do not tell: M phi and K phi / omega^2 are the same at free dofs alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, hstack

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact
from cea.contact.interface import along
from cea.contact.saddle import few_forces, with_multipliers
from cea.errors import ConvergenceError
from cea.matrices import absolute, destroy, gather
from cea.petsc import MPI
from cea.system.body_terms import BodyTerms
from cea.system.coupled import CoupledSystem

_BALANCED = 1e-8  # sum of forces, relative to the largest of them, that counts as none
_ROUNDING = 10.0  # the same in parts of what rounding makes of it


@dataclass(frozen=True)
class SideForces:
    """Forces of a contact on one of its bodies."""

    contact: str  # name of the contact
    body: str  # name of the body
    forces: Floats  # on all its dofs (N), the same on every rank, shape (num_scalar_dofs, dim)
    # sum of stiffness times displacements of the sides (N), of which forces are small differences
    # where gaps tell them
    size: float


@dataclass(frozen=True)
class Balance:
    """Forces that add up to zero, and so do their moments."""

    of: str  # what they act on, as messages name it
    labels: tuple[str, ...]  # what puts them on; the supports last, in their order
    forces: Floats  # their resultants (N), shape (n, dim)
    # their moments about the middle of the body (N m), shape (n, 1) in the plane, (n, 3) in
    # space; None where the trial space has no rotation
    moments: Floats | None
    supports: int  # number of supports
    rounding: float  # what rounding makes of the sum of the forces (N)
    radius: float  # distance from the middle of the body to its farthest dof (m)

    @property
    def reactions(self) -> Floats:
        """Resultants of the supports (N), shape (supports, dim)."""
        return self.forces[len(self.forces) - self.supports :]

    @property
    def left(self) -> float:
        """Sum of the forces, or of their moments, in parts of what counts as none: 1 or less."""
        largest = _longest(self.forces)
        left = _left(self.forces, largest, self.rounding)
        if self.moments is not None:
            largest = max(_longest(self.moments), largest * self.radius)
            left = max(left, _left(self.moments, largest, self.rounding * self.radius))
        return left

    def __str__(self) -> str:
        parts = ", ".join(
            f"{label} ({', '.join(f'{part:.6g}' for part in force)})"
            for label, force in zip(self.labels, self.forces, strict=True)
        )
        return f"{self.of}: {parts} N"


def _longest(vectors: Floats) -> float:
    return float(np.linalg.norm(vectors, axis=1).max(initial=0.0))


def _left(parts: Floats, largest: float, rounding: float) -> float:
    """Length of a sum in parts of what counts as none."""
    allowed = _BALANCED * largest + _ROUNDING * rounding + np.finfo(float).tiny
    return float(np.linalg.norm(parts.sum(axis=0)) / allowed)


def support_reactions(system: CoupledSystem, x: Any, multipliers: Floats) -> dict[str, Floats]:
    """Resultant (N) of the forces of each support on its body; collective.

    Of a system with its loads, linearised about its state of steady sliding where it has one, at
    free displacements x (m), PETSc vector, and contact forces that are unknowns (N), the rows of
    this rank. By body, shape (supports, dim); bodies without supports are left out, and those that
    rotate with modal damping. A direction that several supports hold at a dof is shared evenly.

    Raises
    ------
    ConvergenceError
        When the forces on a body, or of a contact on its two sides, do not add up to zero; the
        reactions are attached.
    """
    moved = {name: system.displacement(x, name) for name in system.bodies}
    sides = list(forces_on_bodies(system.contacts, moved, x, multipliers))
    found = [
        _on_body(pieces, x, moved[name], [side for side in sides if side.body == name])
        for name, pieces in system.pieces.items()
        if pieces.motion.modal is None or pieces.motion.rotation is None
    ]
    found += [_of_contact(name, sides) for name in dict.fromkeys(side.contact for side in sides)]
    reactions = {each.of: each.reactions for each in found if each.supports}
    unbalanced = [str(each) for each in found if not each.left <= 1]
    # Sums of all ranks may differ by rounding from rank to rank.
    unbalanced = system.template.comm.tompi4py().bcast(unbalanced)
    if unbalanced:
        message = "forces, or their moments, do not add up to zero"
        raise ConvergenceError(f"{message}: {'; '.join(unbalanced)}", best=reactions)
    return reactions


def _of_contact(name: str, sides: Sequence[SideForces]) -> Balance:
    """Forces of a contact on its sides."""
    both = [side for side in sides if side.contact == name]
    size = sum(float(np.abs(side.forces).sum()) + side.size for side in both)
    labels = tuple(f"on {side.body}" for side in both)
    forces = np.array([side.forces.sum(axis=0) for side in both])
    return Balance(f"contact {name}", labels, forces, None, 0, np.finfo(float).eps * size, 0.0)


def _on_body(pieces: BodyTerms, x: Any, u: Floats, sides: Sequence[SideForces]) -> Balance:
    """Forces on a body at displacements x of all free dofs and u of its own."""
    body, load = pieces.body, pieces.body.full_load()
    parts = {"loads": gather(load).reshape(-1, body.dim)}
    destroy(load)
    strain = pieces.strain(x)
    strained = u if strain is None else u + gather(strain)
    elastic, size = _times(body.full_stiffness(), strained, body)
    if (springs := body.full_spring_stiffness()) is not None:
        elastic -= _product(springs, strained, body)
        parts["springs"] = -_times(springs, u, body)[0]
    for label, factor, matrix in _of_rotation(pieces):
        product, of_product = _times(matrix, u, body)
        parts[label] = factor * product
        size += abs(factor) * of_product
    for side in sides:
        label = f"contact {side.contact}"
        parts[label] = parts.get(label, 0.0) + side.forces
        size += side.size
    size += sum(float(np.abs(part).sum()) for part in parts.values())
    dofs, reactions = body.support_forces(elastic - sum(parts.values()))
    supports = {f"support {number}": part for number, part in enumerate(reactions)}
    labels = (*parts, *supports)
    forces = np.array([part.sum(axis=0) for part in (*parts.values(), *supports.values())])
    moments, radius, positions = None, 0.0, body.space.dof_positions
    if positions is not None:
        arms = positions - positions.mean(axis=0)
        own = [_moment(arms, part) for part in parts.values()]
        moments = np.array(own + [_moment(arms[dofs], part) for part in reactions])
        radius = _longest(arms)
    rounding = float(np.finfo(float).eps * size)
    return Balance(pieces.name, labels, forces, moments, len(reactions), rounding, radius)


def _moment(arms: Floats, force: Floats) -> Floats:
    """Moment (N m) of forces at dofs (N), shape (n, dim), with their arms (m)."""
    if force.shape[1] == 2:
        return np.array([(arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]).sum()])
    return np.asarray(np.cross(arms, force).sum(axis=0))


def _of_rotation(pieces: BodyTerms) -> Iterator[tuple[str, float, Any]]:
    """Forces of a rotation on a body at rest in space: labels, and factors on matrices (kg)."""
    body, rotation, damping = pieces.body, pieces.motion.rotation, pieces.motion.damping
    if rotation is None:
        return
    if rotation.convective_stiffness:
        matrix = body.space.convective(body.density, rotation)
        yield "convective stiffness", rotation.rate**2, matrix
    if damping is not None and damping.alpha:
        matrix = body.space.gyroscopic(body.density, rotation.of_material)
        yield "damping", -0.5 * damping.alpha * rotation.rate, matrix


def _times(matrix: Any, u: Floats, body: Body) -> tuple[Floats, float]:
    """A matrix of all dofs, which is freed, times a displacement u, and the sum of |A| |u|."""
    sizes = absolute(matrix)
    image, size = (_product(each, v, body) for each, v in ((matrix, u), (sizes, np.abs(u))))
    destroy(matrix, sizes)
    return image, float(size.sum())


def _product(matrix: Any, u: Floats, body: Body) -> Floats:
    """A matrix of all dofs times a displacement of them, shape (num_scalar_dofs, dim)."""
    vector, image = matrix.createVecs()
    first, last = vector.getOwnershipRange()
    vector.array[:] = u[first:last]
    matrix.mult(vector, image)
    values = gather(image).reshape(-1, body.dim)
    destroy(vector, image)
    return values


def forces_on_bodies(
    contacts: Sequence[Contact], displacements: Mapping[str, Floats], x: Any, multipliers: Floats
) -> Iterator[SideForces]:
    """Forces of contacts on both their sides in equilibrium, on held dofs too; collective."""
    linear = [contact for contact in contacts if contact.law.linear]
    for contact in contacts:
        pressure = None
        if contact.lumped is not None:
            yield from _lumped(contact, displacements)
        elif not contact.law.linear:
            assert contact.closure is not None
            pressure = contact.projected_gap(contact.law.pressure(contact.closure))
        elif not contact.has_multipliers:
            pressure = contact.pressure(x)
        if contact.prescribed is not None and contact.law.linear:
            given = contact.slope * contact.prescribed
            pressure = given if pressure is None else pressure + given
        if pressure is not None:
            interface, against = contact.interface, _against(contact)
            s = (interface.points.weight * pressure)[interface.rows]
            yield from _pushed(contact, s[:, None] * against, _size(contact, displacements))
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


def _of_projected(contact: Contact, multipliers: Floats) -> Iterator[SideForces]:
    """Of multipliers of mortar or bonded contact, the rows of this rank."""
    assert contact.projection is not None
    traces, points = contact.projection.traces, contact.interface.local_points
    bonded = contact.coupling == "bonded"
    tractions = []
    for own in multipliers.reshape(points.x.shape[1] if bonded else 1, -1):
        multiplier, traction = traces.createVecs()
        multiplier.array[:] = own
        traces.mult(multiplier, traction)
        tractions.append(np.array(traction.array_r))
        destroy(multiplier, traction)
    traction = np.column_stack(tractions) * (1.0 if bonded else _against(contact))
    yield from _pushed(contact, points.weight[:, None] * traction)


def _lumped(contact: Contact, displacements: Mapping[str, Floats]) -> Iterator[SideForces]:
    """Of lumped contact: the displacement of a dof stands for that of its body at the points."""
    points = contact.interface.local_points
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
    yield from _on_sides(contact, np.concatenate(forces), _size(contact, displacements))


def _traces(contact: Contact) -> tuple[csr_array, csr_array]:
    return contact.interface.trace_a, contact.interface.trace_b


def _size(contact: Contact, displacements: Mapping[str, Floats]) -> float:
    """Stiffness times displacements of both sides, summed over the points of this rank (N)."""
    interface = contact.interface
    moved = np.zeros(len(interface.local_points))
    for name, trace in zip((contact.a, contact.b), _traces(contact), strict=True):
        u = displacements[name].reshape(trace.shape[1], -1)
        moved += abs(trace) @ np.linalg.norm(u, axis=1)
    return float((interface.local_points.weight * contact.slope[interface.rows]) @ moved)


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


def _pushed(contact: Contact, pushed: Floats, size: float = 0.0) -> Iterator[SideForces]:
    """Of forces (N) at the points of each rank that push against side a."""
    a, b = _traces(contact)
    return _on_sides(contact, np.concatenate([-(a.T @ pushed), b.T @ pushed]), size)


def _on_sides(contact: Contact, forces: Floats, size: float = 0.0) -> Iterator[SideForces]:
    """Forces (N), and their size, that the points of each rank put on dofs of sides a and b."""
    comm, dim = contact.interface.comm, contact.interface.a.dim
    every = comm.allreduce(forces, MPI.SUM).reshape(-1, dim)
    of_all = comm.allreduce(size)
    own = np.split(every, [contact.interface.trace_a.shape[1]])
    for body, part in zip((contact.a, contact.b), own, strict=True):
        yield SideForces(contact.pair, body, part, of_all)
