"""Forces that supports bear, and the equilibrium of every body as a whole.

    r = K u - F - (forces of the contacts)

over all dofs of a body is what its supports put on it: it is divided among them along the
directions that each holds (:mod:`cea.supports.constraint_forces`). Elastic forces do no work on a
rigid motion: the resultants of loads, springs, contacts and supports, and their moments, add up to
zero, and so do the forces of a contact on its two sides.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.body_forces import SideForces, forces_on_bodies
from cea.errors import ConvergenceError
from cea.matrices import absolute, destroy, gather
from cea.system.coupled import CoupledSystem

_BALANCED = 1e-8
"""Sum of forces, relative to the largest of them, that counts as none."""
_ROUNDING = 10.0
"""The same in parts of what rounding makes of it."""
_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Applied:
    """Forces of one kind on a body.

    Parameters
    ----------
    label
        What puts them on, as messages name it.
    force
        Their resultant (N), shape (dim,).
    moment
        Their moment about the middle of the body (N m), shape (1,) in the plane, (3,) in space;
        None where the trial space has no rotation.
    """

    label: str
    force: Floats
    moment: Floats | None


@dataclass(frozen=True)
class Balance:
    """Forces that add up to zero.

    Parameters
    ----------
    of
        What they act on, as messages name it.
    forces
        The forces; those of supports last, in their order.
    supports
        Number of supports.
    rounding
        What rounding makes of the sum of the forces (N), and of that of their moments (N m).
    radius
        Distance from the middle of the body to its farthest dof (m).
    """

    of: str
    forces: tuple[Applied, ...]
    supports: int
    rounding: tuple[float, float]
    radius: float

    @property
    def reactions(self) -> Floats:
        """Resultants of the supports (N), shape (supports, dim)."""
        return np.array([each.force for each in self.forces[len(self.forces) - self.supports :]])

    @property
    def left(self) -> float:
        """Sum of the forces, or of their moments, in parts of what counts as none: 1 or less."""
        largest = _largest([each.force for each in self.forces])
        left = _length_of_sum([each.force for each in self.forces])
        parts = [left / (_BALANCED * largest + _ROUNDING * self.rounding[0] + _TINY)]
        moments = [each.moment for each in self.forces if each.moment is not None]
        if moments:
            largest = max(_largest(moments), largest * self.radius)
            left = _length_of_sum(moments)
            parts.append(left / (_BALANCED * largest + _ROUNDING * self.rounding[1] + _TINY))
        return max(parts)

    def __str__(self) -> str:
        parts = ", ".join(
            f"{each.label} ({', '.join(f'{part:.6g}' for part in each.force)})"
            for each in self.forces
        )
        return f"{self.of}: {parts} N"


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
        those whose rotation puts forces on displacements at rest in space, which are not known at
        held dofs. A direction that several supports hold at a dof is shared evenly among them.

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
    displacements = {name: system.displacement(x, name) for name in system.bodies}
    sides = list(forces_on_bodies(system.contacts, displacements, x, multipliers))
    found = [
        _on_body(name, body, displacements[name], [side for side in sides if side.body == name])
        for name, body in system.bodies.items()
        if not system.pieces.motion(name).in_equilibrium
    ]
    for contact in dict.fromkeys(side.contact for side in sides):
        both = [side for side in sides if side.contact == contact]
        found.append(_of_contact(contact, both))
    return found


def _on_body(name: str, body: Body, u: Floats, sides: Sequence[SideForces]) -> Balance:
    stiffness, springs, load = body.full_stiffness(), body.full_spring_stiffness(), body.full_load()
    sizes = absolute(stiffness)
    elastic, loads = _times(stiffness, u, body), gather(load).reshape(-1, body.dim)
    size = np.linalg.norm(_times(sizes, np.abs(u), body) + np.abs(loads), axis=1)
    parts = [("loads", loads)]
    if springs is not None:
        parts.append(("springs", -_times(springs, u, body)))
        destroy(springs)
    destroy(stiffness, sizes, load)
    rest = elastic - loads
    for side in sides:
        parts.append((f"contact {side.contact}", side.forces))
        rest -= side.forces
        size += np.linalg.norm(side.forces, axis=1) + side.sizes
    dofs, reactions = body.support_forces(rest)
    x = body.dof_positions
    arms = None if x is None else x - x.mean(axis=0)
    forces = [_applied(label, part, arms) for label, part in parts]
    at_dofs = None if arms is None else arms[dofs]
    forces += [
        _applied(f"support {number}", part, at_dofs) for number, part in enumerate(reactions)
    ]
    rounding = np.finfo(float).eps * size
    distance = np.zeros(len(rest)) if arms is None else np.linalg.norm(arms, axis=1)
    roundings = float(rounding.sum()), float(rounding @ distance)
    return Balance(name, tuple(forces), len(reactions), roundings, float(distance.max()))


def _of_contact(name: str, sides: Sequence[SideForces]) -> Balance:
    forces = tuple(_applied(f"on {side.body}", side.forces, None) for side in sides)
    size = sum(float(np.abs(side.forces).sum() + side.sizes.sum()) for side in sides)
    rounding = np.finfo(float).eps * size
    return Balance(f"contact {name}", forces, 0, (rounding, 0.0), 0.0)


def _largest(parts: Sequence[Floats]) -> float:
    return max((float(np.linalg.norm(part)) for part in parts), default=0.0)


def _length_of_sum(parts: Sequence[Floats]) -> float:
    return float(np.linalg.norm(np.sum(parts, axis=0))) if parts else 0.0


def _applied(label: str, force: Floats, arms: Floats | None) -> Applied:
    """Forces at dofs (N), shape (n, dim), with their arms (m)."""
    resultant = force.sum(axis=0)
    if arms is None:
        return Applied(label, resultant, None)
    if force.shape[1] == 2:
        moment = np.array([(arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]).sum()])
    else:
        moment = np.cross(arms, force).sum(axis=0)
    return Applied(label, resultant, moment)


def _times(matrix: Any, u: Floats, body: Body) -> Floats:
    """A matrix of all dofs times a displacement of them, shape (num_scalar_dofs, dim)."""
    vector, image = matrix.createVecs()
    first, last = vector.getOwnershipRange()
    vector.array[:] = u[first:last]
    matrix.mult(vector, image)
    values = gather(image).reshape(-1, body.dim)
    destroy(vector, image)
    return values
