"""Forces that supports bear, and the equilibrium of every body as a whole.

    r = K u - F - (forces of the contacts)

over all dofs of a body is what its supports put on it: it is divided among them along the
directions that each holds (:mod:`cea.supports.constraints`). The resultants of loads, springs,
contacts and supports on a body, and their moments, add up to zero, and so do the forces of a
contact on its two sides.

Contacts are assembled on all dofs of the bodies, as if nothing held them. Where their forces are
unknowns of what was solved they are taken from there, for gaps do not tell those of stiff and tied
contacts: L^T f, where of points L = Q^T sqrt(W p^) (G - mu T), G and T those of all dofs and Q that
of the solution (:mod:`cea.contact.saddle`).

Of a body that rotates (:mod:`cea.rotation`) forces on all dofs are, on the body and from outside,
Omega^2 Z u of the convective stiffness and - alpha Omega B u of the damping of the mass; elastic
forces are K (u + beta Omega M^-1 B u), K without springs. What modal damping does at held dofs its
modes do not tell: M phi and K phi / omega^2 are the same at free dofs alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array, vstack

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact, assembled
from cea.contact.saddle import few_forces, with_multipliers
from cea.errors import ConvergenceError
from cea.matrices import destroy, distributed, gather, local_part, scaled_total
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
    sides = list(forces_on_bodies(system, moved, multipliers))
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
    body, load, strain = pieces.body, pieces.body.full_load(), pieces.strain(x)
    parts = {"loads": gather(load).reshape(-1, body.dim)}
    destroy(load)
    strained = u if strain is None else u + gather(strain)
    elastic, size = _times(body.space.stiffness(body.material.elasticity), strained, body)
    for label, factor, matrix in _of_space(pieces):
        product, of_product = _times(matrix, u, body)
        parts[label] = factor * product
        size += abs(factor) * of_product
    for side in sides:
        label = f"contact {side.contact}"
        parts[label] = parts.get(label, 0.0) + side.forces
        size += side.size
    size += sum(float(np.abs(part).sum()) for part in parts.values())
    dofs, reactions = body.support_forces(elastic - sum(parts.values()))
    labels = (*parts, *(f"support {number}" for number in range(len(reactions))))
    forces = np.array([part.sum(axis=0) for part in (*parts.values(), *reactions)])
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


def _of_space(pieces: BodyTerms) -> Iterator[tuple[str, float, Any]]:
    """Forces of displacements at rest in space on a body: labels, and factors on matrices."""
    body, rotation, damping = pieces.body, pieces.motion.rotation, pieces.motion.damping
    if (springs := body.full_spring_stiffness()) is not None:
        yield "springs", -1.0, springs
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
    rows = local_part(matrix)
    destroy(matrix)
    image = np.concatenate(body.comm.allgather(rows @ u))
    size = body.comm.allreduce(float((abs(rows) @ np.abs(u)).sum()))
    return image.reshape(-1, body.dim), size


def forces_on_bodies(
    system: CoupledSystem, moved: Mapping[str, Floats], multipliers: Floats
) -> Iterator[SideForces]:
    """Forces of contacts on both their sides in equilibrium, on held dofs too; collective."""
    bodies = {name: replace(body, supports=()) for name, body in system.bodies.items()}
    whole = {
        each.name: assembled(bodies, each, frictional=each.has_friction, leave_out=True)
        for each in system.contacts
    }
    if not whole:
        return
    u = whole[system.contacts[0].name].gap.createVecRight()
    u.array[:] = np.concatenate([moved[name][_own(body)] for name, body in bodies.items()])
    for contact in system.contacts:
        of_all = whole[contact.name]
        if of_all.lumped is not None:
            force = _image(*of_all.lumped, u)
        elif not contact.law.linear:
            assert contact.closure is not None
            force = of_all.force(contact.law.pressure(contact.closure))
        elif not contact.has_multipliers:
            force = of_all.force(contact.slope * of_all.closing(u))
        elif contact.prescribed is not None:
            force = of_all.force(contact.slope * contact.prescribed)
        else:
            continue
        yield from _on_sides(bodies, contact, force, _size(contact, moved))
    linear = [contact for contact in system.contacts if contact.law.linear]
    for halves in with_multipliers(linear).values():
        reactions = [_reaction(whole[half.name]) for half in halves]
        if halves[0].projection is None:
            parts = [few_forces(halves, [local_part(each) for each in reactions])[1]]
        else:
            parts = [local_part(each) for each in reactions]
        rows = csr_array(vstack(parts))
        own, multipliers = np.split(multipliers, [rows.shape[0]])
        reaction = distributed(rows, reactions[0].getSizes()[1], reactions[0].comm)
        f, force = reaction.createVecLeft(), reaction.createVecRight()
        f.array[:] = own
        reaction.multTranspose(f, force)
        destroy(reaction, f, *reactions)
        yield from _on_sides(bodies, halves[0], force)
    destroy(u)
    for each in whole.values():
        destroy(each.gap, *(m for m in (each.slip, *(each.lumped or ())) if m is not None))


def _own(body: Body) -> slice:
    """Dofs of this rank of a body without supports."""
    return slice(*body.expansion.getOwnershipRange())


def _image(K_n: Any, K_f: Any | None, u: Any) -> Any:
    """(K_n - K_f) u."""
    force = K_n.createVecLeft()
    if K_f is not None:
        K_f.mult(u, force)
        force.scale(-1.0)
    K_n.multAdd(u, force, force)
    return force


def _reaction(contact: Contact) -> Any:
    """L = J - R, a new matrix, of gaps and slips of a contact."""
    parts = [(1.0, contact.gap)]
    if contact.has_friction:
        parts.append((-1.0, contact.slip))
    return scaled_total(parts)


def _size(contact: Contact, moved: Mapping[str, Floats]) -> float:
    """Stiffness times displacements of both sides, summed over all points (N)."""
    interface = contact.interface
    lengths = np.zeros(len(interface.local_points))
    sides = ((contact.a, interface.trace_a), (contact.b, interface.trace_b))
    for name, trace in sides:
        lengths += abs(trace) @ np.linalg.norm(moved[name].reshape(trace.shape[1], -1), axis=1)
    weighted = interface.local_points.weight * contact.slope[interface.rows]
    return interface.comm.allreduce(float(weighted @ lengths))


def _on_sides(
    bodies: Mapping[str, Body], contact: Contact, force: Any, size: float = 0.0
) -> Iterator[SideForces]:
    """A force against the motion (N), PETSc vector of all dofs, which is freed, on both bodies."""
    ends = np.cumsum([body.expansion.getLocalSize()[0] for body in bodies.values()])
    parts = dict(zip(bodies, np.split(-force.array_r, ends[:-1]), strict=True))
    destroy(force)
    for name in (contact.a, contact.b):
        body = bodies[name]
        whole = np.concatenate(body.comm.allgather(parts[name])).reshape(-1, body.dim)
        yield SideForces(contact.pair, name, whole, size)
