"""Forces that supports bear, and the equilibrium of every body as a whole.

    r = K u - F - (forces of the contacts)

over all dofs of a body is what its supports put on it: it is divided among them along the
directions that each holds (:mod:`cea.supports.constraint_forces`). Elastic forces do no work on a
rigid motion: the resultants of loads, springs, contacts and supports, and their moments, add up to
zero, and so do the forces of a contact on its two sides.

Of a body that rotates (:mod:`cea.rotation`) the displacement u at rest in space is seen by its
material to change with Omega R u. Forces on all dofs are then, on the body and from outside,

    convective stiffness    Omega^2 Z u
    damping of the mass     - alpha Omega B u

and elastic forces are K (u + beta Omega M^-1 B u), K without springs. What modal damping does at
held dofs its modes do not tell: M phi and K phi / omega^2 are the same at free dofs alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.body_forces import SideForces, forces_on_bodies
from cea.errors import ConvergenceError
from cea.matrices import absolute, destroy, gather
from cea.system.body_terms import BodyTerms
from cea.system.coupled import CoupledSystem

_BALANCED = 1e-8
"""Sum of forces, relative to the largest of them, that counts as none."""
_ROUNDING = 10.0
"""The same in parts of what rounding makes of it."""
_TINY = float(np.finfo(float).tiny)


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
    # what rounding makes of the sum of the forces (N), and of that of their moments (N m)
    rounding: tuple[float, float]
    radius: float  # distance from the middle of the body to its farthest dof (m)

    @property
    def reactions(self) -> Floats:
        """Resultants of the supports (N), shape (supports, dim)."""
        return self.forces[len(self.forces) - self.supports :]

    @property
    def left(self) -> float:
        """Sum of the forces, or of their moments, in parts of what counts as none: 1 or less."""
        largest = float(np.linalg.norm(self.forces, axis=1).max(initial=0.0))
        left = [_left(self.forces, largest, self.rounding[0])]
        if self.moments is not None:
            moment = float(np.linalg.norm(self.moments, axis=1).max(initial=0.0))
            left.append(_left(self.moments, max(moment, largest * self.radius), self.rounding[1]))
        return max(left)

    def __str__(self) -> str:
        parts = ", ".join(
            f"{label} ({', '.join(f'{part:.6g}' for part in force)})"
            for label, force in zip(self.labels, self.forces, strict=True)
        )
        return f"{self.of}: {parts} N"


def _left(parts: Floats, largest: float, rounding: float) -> float:
    """Length of a sum in parts of what counts as none."""
    allowed = _BALANCED * largest + _ROUNDING * rounding + _TINY
    return float(np.linalg.norm(parts.sum(axis=0))) / allowed


def support_reactions(system: CoupledSystem, x: Any, multipliers: Floats) -> dict[str, Floats]:
    """Resultant (N) of the forces of each support on its body; collective.

    Parameters
    ----------
    system
        The coupled system with its loads, linearised about its state of steady sliding where it
        has one.
    x
        Free displacements under the loads (m), PETSc vector.
    multipliers
        Contact forces that are unknowns beside them (N), the rows of this rank.

    Returns
    -------
    dict
        By body, shape (supports, dim), in their order; bodies without supports are left out, and
        those that rotate with modal damping. A direction that several supports hold at a dof is
        shared evenly among them.

    Raises
    ------
    ConvergenceError
        When the forces on a body, or of a contact on its two sides, do not add up to zero; the
        reactions are attached.
    """
    found = balances(system, x, multipliers)
    reactions = {each.of: each.reactions for each in found if each.supports}
    unbalanced = [str(each) for each in found if not each.left <= 1]
    # Sums of all ranks may differ by rounding from rank to rank.
    unbalanced = system.template.comm.tompi4py().bcast(unbalanced)
    if unbalanced:
        message = "forces, or their moments, do not add up to zero"
        raise ConvergenceError(f"{message}: {'; '.join(unbalanced)}", best=reactions)
    return reactions


def balances(system: CoupledSystem, x: Any, multipliers: Floats) -> list[Balance]:
    """Forces on each body, and of each contact on its sides, whether they add up to zero or not.

    Collective; parameters are those of :func:`support_reactions`.
    """
    moved = {name: system.displacement(x, name) for name in system.bodies}
    sides = list(forces_on_bodies(system.contacts, moved, x, multipliers))
    found = [
        _on_body(pieces, x, moved[name], [side for side in sides if side.body == name])
        for name, pieces in system.pieces.items()
        if pieces.motion.modal is None or pieces.motion.rotation is None
    ]
    for contact in dict.fromkeys(side.contact for side in sides):
        both = [side for side in sides if side.contact == contact]
        size = sum(float(np.abs(side.forces).sum() + side.sizes.sum()) for side in both)
        labels = tuple(f"on {side.body}" for side in both)
        forces = np.array([side.forces.sum(axis=0) for side in both])
        rounding = (np.finfo(float).eps * size, 0.0)
        found.append(Balance(f"contact {contact}", labels, forces, None, 0, rounding, 0.0))
    return found


def _on_body(pieces: BodyTerms, x: Any, u: Floats, sides: Sequence[SideForces]) -> Balance:
    """Forces on a body at displacements x of all free dofs and u of its own."""
    body, load = pieces.body, pieces.body.full_load()
    loads = gather(load).reshape(-1, body.dim)
    destroy(load)
    strain = pieces.strain(x)
    strained = u if strain is None else u + gather(strain)
    elastic, size = _times(body.full_stiffness(), strained, body)
    parts = {"loads": loads}
    if (springs := body.full_spring_stiffness()) is not None:
        elastic -= _product(springs, strained, body)
        parts["springs"] = -_times(springs, u, body)[0]
    size += np.linalg.norm(loads, axis=1)
    for label, factor, matrix in _of_rotation(pieces):
        product, of_product = _times(matrix, u, body)
        parts[label] = factor * product
        size += abs(factor) * of_product
    for side in sides:
        label = f"contact {side.contact}"
        parts[label] = parts.get(label, 0.0) + side.forces
        size += np.linalg.norm(side.forces, axis=1) + side.sizes
    dofs, reactions = body.support_forces(elastic - sum(parts.values()))
    positions = body.dof_positions
    arms = None if positions is None else positions - positions.mean(axis=0)
    supports = {f"support {number}": part for number, part in enumerate(reactions)}
    forces = np.array([part.sum(axis=0) for part in (*parts.values(), *supports.values())])
    moments, distance = None, np.zeros(len(elastic))
    if arms is not None:
        own = [_moment(arms, part) for part in parts.values()]
        moments = np.array(own + [_moment(arms[dofs], part) for part in reactions])
        distance = np.linalg.norm(arms, axis=1)
    eps = np.finfo(float).eps
    rounding = float(eps * size.sum()), float(eps * (size @ distance))
    labels = (*parts, *supports)
    radius = float(distance.max())
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


def _times(matrix: Any, u: Floats, body: Body) -> tuple[Floats, Floats]:
    """A matrix of all dofs, which is freed, times a displacement u of them, and abs(A) abs(u)."""
    sizes = absolute(matrix)
    image, size = (_product(each, v, body) for each, v in ((matrix, u), (sizes, np.abs(u))))
    destroy(matrix, sizes)
    return image, np.linalg.norm(size, axis=1)


def _product(matrix: Any, u: Floats, body: Body) -> Floats:
    """A matrix of all dofs times a displacement of them, shape (num_scalar_dofs, dim)."""
    vector, image = matrix.createVecs()
    first, last = vector.getOwnershipRange()
    vector.array[:] = u[first:last]
    matrix.mult(vector, image)
    values = gather(image).reshape(-1, body.dim)
    destroy(vector, image)
    return values
