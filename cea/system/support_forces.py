"""Support reactions, and a check of the equilibrium of every body.

    r = K u - F - (forces of the contacts)

on all dofs of a body is the force of its supports: it is divided among them along the directions
that each constrains (:mod:`cea.supports.constraints`), and must leave no remainder.

Contacts are assembled on all dofs of the bodies, without supports. Multipliers f are those of the
solution, since gaps do not determine forces of stiff and tied contacts; their forces are L^T f with
L = Q^T sqrt(W p^) (G - mu T) for pointwise contact, G and T on all dofs and Q that of the solution
(:mod:`cea.contact.saddle`).

For a rotating body (:mod:`cea.motion`) the external forces on all dofs include Omega^2 Z u of the
convective stiffness and - alpha Omega B u of mass damping; elastic forces are
K (u + beta Omega M^-1 B u), K without springs. Forces of modal damping at constrained dofs are
unknown: its modes satisfy M phi = K phi / omega^2 at free dofs only.
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

_BALANCED = 1e-8
"""Tolerance of the remainder, relative to the largest force on a body."""
_ROUNDING = 10.0 * float(np.finfo(float).eps)
"""The same relative to the sum of stiffnesses times displacements."""


def support_reactions(system: CoupledSystem, x: Any, multipliers: Floats) -> dict[str, Floats]:
    """Return the resultant (N) of each support on its body; collective.

    The system has loads, and is linearised about its steady sliding state if it has one; ``x`` are
    free displacements (m), PETSc vector, and ``multipliers`` (N) the rows of this rank. Results are
    by body, shape (supports, dim), without bodies that have no supports or that rotate with modal
    damping. Supports that constrain the same direction at a dof share its force equally.

    Raises
    ------
    ConvergenceError
        If the forces on a body are not in equilibrium; ``best`` has the reactions.
    """
    moved = {name: system.displacement(x, name) for name in system.bodies}
    of_contacts, size = contact_forces(system, moved, multipliers)
    reactions, unbalanced = {}, []
    resultants = np.array([forces.sum(axis=0) for forces in of_contacts.values()])
    left = float(np.linalg.norm(resultants.sum(axis=0)))
    allowed = _BALANCED * float(np.linalg.norm(resultants, axis=1).max()) + _ROUNDING * size
    if left > allowed:
        unbalanced.append(f"contact forces add up to {left:.3g} N, above {allowed:.1g} N")
    for name, pieces in system.pieces.items():
        if pieces.motion.modal is not None and pieces.motion.rotation is not None:
            continue
        supports, left, allowed = _on_body(pieces, x, moved[name], of_contacts[name], size)
        if len(supports):
            reactions[name] = supports.sum(axis=1)
        if left > allowed:
            unbalanced.append(f"a residual of {left:.3g} N on {name}, above {allowed:.1g} N")
    # Sums may differ between ranks by rounding.
    unbalanced = system.template.comm.tompi4py().bcast(unbalanced)
    if unbalanced:
        raise ConvergenceError(f"forces do not balance: {'; '.join(unbalanced)}", best=reactions)
    return reactions


def _on_body(
    pieces: BodyTerms, x: Any, u: Floats, of_contacts: Floats, size: float
) -> tuple[Floats, float, float]:
    """Return the support forces on a body, the norm of the remainder, and its tolerance (N).

    ``x`` are the free displacements of all bodies, ``u`` those of all dofs of the body. Support
    forces have shape (supports, num_scalar_dofs, dim). ``size`` (N) is the sum of stiffnesses times
    displacements of the contacts, whose rounding limits the remainder.
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
    dofs, supports = body.constraints.dofs, np.zeros((len(body.supports), *rest.shape))
    supports[:, dofs] = body.constraints.split(rest[dofs], len(body.supports))
    largest = max(np.linalg.norm(part.sum(axis=0)) for part in (*parts[1:], *supports))
    size += sum(float(np.abs(part).sum()) for part in parts)
    allowed = _BALANCED * float(largest) + _ROUNDING * size
    return supports, float(np.linalg.norm(rest - supports.sum(axis=0))), allowed


def _of_space(pieces: BodyTerms) -> Iterator[tuple[float, Any]]:
    """Yield factors and matrices of forces of displacements at rest in space on a body."""
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
    """Return A u and the sum of |A| |u| for a matrix A of all dofs, which is destroyed."""
    rows = local_part(matrix)
    destroy(matrix)
    image = np.concatenate(body.comm.allgather(rows @ u))
    size = body.comm.allreduce(float((abs(rows) @ np.abs(u)).sum()))
    return image.reshape(-1, body.dim), size


def contact_forces(
    system: CoupledSystem, moved: Mapping[str, Floats], multipliers: Floats
) -> tuple[dict[str, Floats], float]:
    """Return the forces (N) of all contacts on each body, at constrained dofs too; collective.

    Forces are by body, on all its dofs, the same on every rank, shape (num_scalar_dofs, dim). The
    second result is the sum of stiffnesses times displacements (N), which limits their accuracy.
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
        if halves[0].traces is None:
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
    """Return a new matrix, the first minus the second if there is one."""
    return scaled_total([(1.0, one)] if other is None else [(1.0, one), (-1.0, other)])


def _size(contact: Contact, moved: Mapping[str, Floats]) -> float:
    """Return stiffness times displacements of both sides, summed over all points (N)."""
    interface = contact.interface
    lengths = np.zeros(len(interface.local_points))
    sides = ((contact.a, interface.trace_a), (contact.b, interface.trace_b))
    for name, trace in sides:
        lengths += abs(trace) @ np.linalg.norm(moved[name].reshape(trace.shape[1], -1), axis=1)
    return interface.comm.allreduce(float(contact.weight(contact.slope) @ lengths))
