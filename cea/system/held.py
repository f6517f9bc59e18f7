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
from cea.system.body_terms import Motion
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
    displacements = {name: system.displacement(x, name) for name in system.bodies}
    sides = list(forces_on_bodies(system.contacts, displacements, x, multipliers))
    found = [
        _on_body(
            system, name, x, displacements[name], [side for side in sides if side.body == name]
        )
        for name in system.bodies
        if not system.pieces.motion(name).turns_modes
    ]
    for contact in dict.fromkeys(side.contact for side in sides):
        both = [side for side in sides if side.contact == contact]
        found.append(_of_contact(contact, both))
    return found


def _on_body(
    system: CoupledSystem, name: str, x: Any, u: Floats, sides: Sequence[SideForces]
) -> Balance:
    body, load = system.bodies[name], system.bodies[name].full_load()
    loads = gather(load).reshape(-1, body.dim)
    destroy(load)
    strained = u + _strain(system, name, x)
    elastic, size = _times(body.full_stiffness(), strained, body)
    parts = [("loads", loads)]
    if (springs := body.full_spring_stiffness()) is not None:
        elastic -= _product(springs, strained, body)
        parts.append(("springs", -_times(springs, u, body)[0]))
    size += np.linalg.norm(loads, axis=1)
    for label, factor, matrix in _of_rotation(body, system.pieces.motion(name)):
        product, size_of_product = _times(matrix, u, body)
        parts.append((label, factor * product))
        size += abs(factor) * size_of_product
    for side in sides:
        parts.append((f"contact {side.contact}", side.forces))
        size += np.linalg.norm(side.forces, axis=1) + side.sizes
    rest = elastic - sum(part for _, part in parts)
    dofs, reactions = body.support_forces(rest)
    positions = body.dof_positions
    arms = None if positions is None else positions - positions.mean(axis=0)
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


def _strain(system: CoupledSystem, name: str, x: Any) -> Floats:
    """What damping that rotates with a body adds to the displacement that strains it (m)."""
    rotating = system.pieces.rotating.get(name)
    strain = None if rotating is None else rotating.strain(x)
    if strain is None:
        return np.zeros(1)
    everywhere = gather(strain)
    destroy(strain)
    return everywhere


def _of_rotation(body: Body, motion: Motion) -> Iterator[tuple[str, float, Any]]:
    """Forces of a rotation on a body at rest in space: labels, and factors on matrices (kg)."""
    rotation, damping = motion.rotation, motion.damping
    if rotation is None:
        return
    if rotation.convective_stiffness:
        matrix = body.space.convective(body.density, rotation)
        yield "convective stiffness", rotation.rate**2, matrix
    if damping is not None and damping.alpha:
        matrix = body.space.gyroscopic(body.density, rotation.of_material)
        yield "damping", -0.5 * damping.alpha * rotation.rate, matrix


def _times(matrix: Any, u: Floats, body: Body) -> tuple[Floats, Floats]:
    """A matrix of all dofs, which is freed, times a displacement of them, and its size.

    Shapes (num_scalar_dofs, dim) and (num_scalar_dofs,); the size is abs(matrix) abs(u).
    """
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
