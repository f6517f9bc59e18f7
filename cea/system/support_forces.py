"""Forces that supports bear, and the equilibrium of every body.

    r = K u - F - (forces of the contacts)

over all dofs of a body is what its supports put on it: it is divided among them along the
directions that each holds (:mod:`cea.supports.constraints`), and nothing may be left over.

Contacts are assembled on all dofs of the bodies, as if nothing held them. Where their forces are
unknowns of what was solved they are taken from there, for gaps do not tell those of stiff and tied
contacts: L^T f, where of points L = Q^T sqrt(W p^) (G - mu T), G and T those of all dofs and Q that
of the solution (:mod:`cea.contact.saddle`).

Of a body that rotates (:mod:`cea.motion`) forces on all dofs are, on the body and from outside,
Omega^2 Z u of the convective stiffness and - alpha Omega B u of the damping of the mass; elastic
forces are K (u + beta Omega M^-1 B u), K without springs. What modal damping does at held dofs its
modes do not tell: M phi and K phi / omega^2 are the same at free dofs alone.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
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

_BALANCED = (
    1e-8  # forces left over, relative to the largest that acts on a body, that count as none
)
_ROUNDING = 10.0 * float(np.finfo(float).eps)
"""The same relative to the sum of products of stiffnesses and displacements."""


def support_reactions(system: CoupledSystem, x: Any, multipliers: Floats) -> dict[str, Floats]:
    """Resultant (N) of the forces of each support on its body; collective.

    Of a system with its loads, linearised about its state of steady sliding where it has one, at
    free displacements x (m), PETSc vector, and contact forces that are unknowns (N), the rows of
    this rank. By body, shape (supports, dim); bodies without supports are left out, and those that
    rotate with modal damping. A direction that several supports hold at a dof is shared evenly.

    Raises
    ------
    ConvergenceError
        When the forces on a body are not in equilibrium; the reactions are attached.
    """
    moved = {name: system.displacement(x, name) for name in system.bodies}
    of_contacts, size = contact_forces(system, moved, multipliers)
    reactions, unbalanced = {}, []
    for name, pieces in system.pieces.items():
        if pieces.motion.modal is not None and pieces.motion.rotation is not None:
            continue
        supports, left, allowed = _on_body(pieces, x, moved[name], of_contacts[name], size)
        if len(supports):
            reactions[name] = supports.sum(axis=1)
        if left > allowed:
            unbalanced.append(f"{left:.3g} N are left over on {name}, where {allowed:.1g} N may")
    # Sums of all ranks may differ by rounding from rank to rank.
    unbalanced = system.template.comm.tompi4py().bcast(unbalanced)
    if unbalanced:
        raise ConvergenceError(f"forces do not balance: {'; '.join(unbalanced)}", best=reactions)
    return reactions


def _on_body(
    pieces: BodyTerms, x: Any, u: Floats, of_contacts: Floats, size: float
) -> tuple[Floats, float, float]:
    """Forces on a body at displacements x of all free dofs and u of its own, at all its dofs (N).

    Those of each support, shape (supports, num_scalar_dofs, dim), the norm of what is left over,
    and what may be: forces of contacts are small differences of numbers of a size (N), others of
    what is added to it.
    """
    body, load, strain = pieces.body, pieces.body.full_load(), pieces.strain(x)
    loads = np.concatenate(body.comm.allgather(load)).reshape(-1, body.dim)
    strained = u if strain is None else u + np.concatenate(body.comm.allgather(strain))
    elastic, of_product = _times(body.space.stiffness(body.material.elasticity), strained, body)
    parts, size = [elastic, -loads, -of_contacts], size + of_product
    for factor, matrix in _of_space(pieces):
        image, of_product = _times(matrix, u, body)
        parts.append(-factor * image)
        size += abs(factor) * of_product
    rest = sum(parts, np.zeros_like(elastic))
    dofs, held = body.support_forces(rest)
    supports = np.zeros((len(held), *rest.shape))
    supports[:, dofs] = held
    largest = max(np.linalg.norm(part.sum(axis=0)) for part in (*parts[1:], *supports))
    size += sum(float(np.abs(part).sum()) for part in parts)
    allowed = _BALANCED * float(largest) + _ROUNDING * size
    return supports, float(np.linalg.norm(rest - supports.sum(axis=0))), allowed


def _of_space(pieces: BodyTerms) -> Iterator[tuple[float, Any]]:
    """Forces of displacements at rest in space on a body: factors on matrices."""
    body, rotation, damping = pieces.body, pieces.motion.rotation, pieces.motion.damping
    if (springs := body.full_spring_stiffness()) is not None:
        yield -1.0, springs
    if rotation is None:
        return
    if rotation.convective_stiffness:
        matrix = body.space.convective(body.density, rotation)
        yield rotation.rate**2, matrix
    if damping is not None and damping.alpha:
        matrix = body.space.gyroscopic(body.density, rotation.of_material)
        yield -0.5 * damping.alpha * rotation.rate, matrix


def _times(matrix: Any, u: Floats, body: Body) -> tuple[Floats, float]:
    """A matrix of all dofs, which is freed, times a displacement u, and the sum of |A| |u|."""
    rows = local_part(matrix)
    destroy(matrix)
    image = np.concatenate(body.comm.allgather(rows @ u))
    size = body.comm.allreduce(float((abs(rows) @ np.abs(u)).sum()))
    return image.reshape(-1, body.dim), size


def contact_forces(
    system: CoupledSystem, moved: Mapping[str, Floats], multipliers: Floats
) -> tuple[dict[str, Floats], float]:
    """Forces (N) of all contacts on each body in equilibrium, on held dofs too; collective.

    By body, on all its dofs, the same on every rank, shape (num_scalar_dofs, dim); and the sum of
    the stiffnesses times displacements (N) of which they are small differences.
    """
    bodies = {name: replace(body, supports=()) for name, body in system.bodies.items()}
    whole = {
        each.name: assembled(bodies, each, frictional=each.has_friction, leave_out=True)
        for each in system.contacts
    }
    own = {name: slice(*body.expansion.getOwnershipRange()) for name, body in bodies.items()}
    u = np.concatenate([moved[name][dofs] for name, dofs in own.items()])
    against, size = np.zeros(len(u)), 0.0
    for contact in system.contacts:
        of_all = whole[contact.name]
        if of_all.lumped is not None:
            stiffness = _difference(*of_all.lumped)
            against += applied(stiffness, u)
            destroy(stiffness)
        elif not contact.law.linear:
            assert contact.closure is not None
            against += of_all.force(contact.law.pressure(contact.closure))
        elif not contact.has_multipliers:
            against += of_all.force(contact.slope * of_all.closing(u))
        elif contact.prescribed is not None:
            against += of_all.force(contact.slope * contact.prescribed)
        else:
            continue
        size += _size(contact, moved)
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
        against += applied(reaction, f, transposed=True)
        destroy(reaction, *reactions)
    for each in whole.values():
        destroy(each.gap, *(m for m in (each.slip, *(each.lumped or ())) if m is not None))
    ends = np.cumsum([dofs.stop - dofs.start for dofs in own.values()])
    forces = {
        name: np.concatenate(bodies[name].comm.allgather(-part)).reshape(-1, bodies[name].dim)
        for name, part in zip(own, np.split(against, ends[:-1]), strict=True)
    }
    return forces, size


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
