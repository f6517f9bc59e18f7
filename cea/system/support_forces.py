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

Of a body that rotates (:mod:`cea.motion`) forces on all dofs are, on the body and from outside,
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
from cea.matrices import applied, destroy, distributed, local_part, scaled_total
from cea.system.body_terms import BodyTerms
from cea.system.coupled import CoupledSystem

_BALANCED = 1e-8  # sum of forces, relative to the largest of them, that counts as none
_ROUNDING = 10.0 * float(np.finfo(float).eps)
"""The same relative to the sum of products of stiffnesses and displacements."""


@dataclass(frozen=True)
class SideForces:
    """Forces of a contact on one of its bodies."""

    contact: str  # name of the contact
    body: str  # name of the body
    forces: Floats  # on all its dofs (N), the same on every rank, shape (num_scalar_dofs, dim)
    # sum of stiffness times displacements of the sides (N), of which forces are small differences
    # where gaps tell them
    size: float


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
    reactions, unbalanced = {}, []
    for name, pieces in system.pieces.items():
        if pieces.motion.modal is not None and pieces.motion.rotation is not None:
            continue
        body, on_body = pieces.body, [side for side in sides if side.body == name]
        supports, parts, size = _on_body(pieces, x, moved[name], on_body)
        if len(supports):
            reactions[name] = supports.sum(axis=1)
        parts |= {f"support {number}": part for number, part in enumerate(supports)}
        unbalanced += _unbalanced(name, parts, size, body.space.dof_positions)
    for name in dict.fromkeys(side.contact for side in sides):
        both = [side for side in sides if side.contact == name]
        size = sum(float(np.abs(side.forces).sum()) + side.size for side in both)
        on_sides: dict[str, Floats] = {}
        for side in both:
            label = f"on {side.body}"
            on_sides[label] = on_sides.get(label, 0.0) + side.forces.sum(axis=0, keepdims=True)
        unbalanced += _unbalanced(f"contact {name}", on_sides, size)
    # Sums of all ranks may differ by rounding from rank to rank.
    unbalanced = system.template.comm.tompi4py().bcast(unbalanced)
    if unbalanced:
        message = "forces, or their moments, do not add up to zero"
        raise ConvergenceError(f"{message}: {'; '.join(unbalanced)}", best=reactions)
    return reactions


def _unbalanced(
    of: str, parts: Mapping[str, Floats], size: float, x: Floats | None = None
) -> list[str]:
    """What forces act on, with their resultants, if they do not add up to zero, or their moments.

    Forces at dofs (N), shape (n, dim), by what puts them on, their positions (m) about whose middle
    moments are taken, and what rounding is relative to. Without positions, as where the trial space
    has no rotation, there are no moments.
    """
    forces = np.array([part.sum(axis=0) for part in parts.values()])
    left = _left(forces, 0.0, size)
    if x is not None:
        arms = x - x.mean(axis=0)
        radius = float(np.linalg.norm(arms, axis=1).max())
        moments = np.array([_moment(arms, part) for part in parts.values()])
        largest = float(np.linalg.norm(forces, axis=1).max(initial=0.0))
        left = max(left, _left(moments, largest * radius, size * radius))
    if left <= 1:
        return []
    shown = (", ".join(f"{component:.6g}" for component in force) for force in forces)
    return [f"{of}: {', '.join(f'{p} ({f})' for p, f in zip(parts, shown, strict=True))} N"]


def _left(vectors: Floats, largest: float, size: float) -> float:
    """Length of a sum of vectors in parts of what counts as none: 1 or less."""
    largest = max(largest, float(np.linalg.norm(vectors, axis=1).max(initial=0.0)))
    allowed = _BALANCED * largest + _ROUNDING * size + np.finfo(float).tiny
    return float(np.linalg.norm(vectors.sum(axis=0)) / allowed)


def _moment(arms: Floats, force: Floats) -> Floats:
    """Moment (N m) of forces at dofs (N), shape (n, dim), with their arms (m)."""
    if force.shape[1] == 2:
        return np.array([(arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]).sum()])
    return np.asarray(np.cross(arms, force).sum(axis=0))


def _on_body(
    pieces: BodyTerms, x: Any, u: Floats, sides: Sequence[SideForces]
) -> tuple[Floats, dict[str, Floats], float]:
    """Forces on a body at displacements x of all free dofs and u of its own, at all its dofs (N).

    Those of each support, shape (supports, num_scalar_dofs, dim), the others by what puts them on,
    and the sum of what all of them are small differences of.
    """
    body, load, strain = pieces.body, pieces.body.full_load(), pieces.strain(x)
    parts = {"loads": np.concatenate(body.comm.allgather(load)).reshape(-1, body.dim)}
    strained = u if strain is None else u + np.concatenate(body.comm.allgather(strain))
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
    dofs, held = body.support_forces(elastic - sum(parts.values()))
    supports = np.zeros((len(held), *elastic.shape))
    supports[:, dofs] = held
    return supports, parts, size


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
    own = {name: slice(*body.expansion.getOwnershipRange()) for name, body in bodies.items()}
    u = np.concatenate([moved[name][dofs] for name, dofs in own.items()])
    for contact in system.contacts:
        of_all = whole[contact.name]
        if of_all.lumped is not None:
            stiffness = _difference(*of_all.lumped)
            force = applied(stiffness, u)
            destroy(stiffness)
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
        every = [whole[half.name] for half in halves]
        reactions = [_difference(m.gap, m.slip if m.has_friction else None) for m in every]
        parts = [local_part(each) for each in reactions]
        if halves[0].projection is None:
            parts = [few_forces(halves, parts)[1]]
        rows = csr_array(vstack(parts))
        f, multipliers = np.split(multipliers, [rows.shape[0]])
        reaction = distributed(rows, reactions[0].getSizes()[1], reactions[0].comm)
        force = applied(reaction, f, transposed=True)
        destroy(reaction, *reactions)
        yield from _on_sides(bodies, halves[0], force)
    for each in whole.values():
        destroy(each.gap, *(m for m in (each.slip, *(each.lumped or ())) if m is not None))


def _difference(one: Any, other: Any | None) -> Any:
    """A matrix less another, if there is one: a new matrix."""
    return scaled_total([(1.0, one)] if other is None else [(1.0, one), (-1.0, other)])


def _size(contact: Contact, moved: Mapping[str, Floats]) -> float:
    """Stiffness times displacements of both sides, summed over all points (N)."""
    interface = contact.interface
    lengths = np.zeros(len(interface.local_points))
    sides = ((contact.a, interface.trace_a), (contact.b, interface.trace_b))
    for name, trace in sides:
        lengths += abs(trace) @ np.linalg.norm(moved[name].reshape(trace.shape[1], -1), axis=1)
    return interface.comm.allreduce(float(contact.weight(contact.slope) @ lengths))


def _on_sides(
    bodies: Mapping[str, Body], contact: Contact, force: Floats, size: float = 0.0
) -> Iterator[SideForces]:
    """A force against the motion (N), the dofs of this rank of all bodies, on both bodies."""
    ends = np.cumsum([body.expansion.getLocalSize()[0] for body in bodies.values()])
    parts = dict(zip(bodies, np.split(-force, ends[:-1]), strict=True))
    for name in (contact.a, contact.b):
        body = bodies[name]
        whole = np.concatenate(body.comm.allgather(parts[name])).reshape(-1, body.dim)
        yield SideForces(contact.pair, name, whole, size)
