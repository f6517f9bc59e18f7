"""Lower bounds of stiffness and mass by the part of bodies near contacts, where friction acts.

K and M are integrals of positive semidefinite integrands. Without the integrals over points farther
than a distance from every contact point the rest bounds them from below, and has entries at few
dofs: a bound by the field of values costs a small factorisation (:mod:`cea.eigen.field_of_values`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.eigen.multipliers import Multipliers
from cea.eigen.pencil import Matrices, Term
from cea.matrices import applied, destroy, diagonal_of, of_entries, scaled_total
from cea.petsc import MPI, Mat, PETSc
from cea.system.body_terms import BodyTerms

_NEAR = 0.25
"""Fraction of all dofs that are near contacts."""
_ASIDE = 1e-6
"""Relative distance of the border from the dof that is farthest among the near ones."""
_INSIDE = 1e-12
"""Fraction of the stiffness or mass of a dof from which on it counts as near."""
_LUMPED, _REMOVED = 1e-5, 0.02
"""Fraction of the diagonal of the mass that is added near contacts, so that no motion of cells that
are near in part is without mass, and fraction of the mass removed for it."""


@dataclass(eq=False)
class FarPoints:
    """Indicator function of the points farther than a distance from contact points."""

    contact_points: KDTree
    distance: float  # (m)
    _last: tuple[Floats, Floats] = field(default=(np.zeros(0), np.zeros(0)), init=False)

    def __call__(self, x: Floats) -> Floats:
        """Return 1 or 0 at positions x (m), shape (dim, n)."""
        if x is not self._last[0]:
            nearest, _ = self.contact_points.query(x.T, distance_upper_bound=self.distance)
            self._last = (x, np.isinf(nearest).astype(float))
        return self._last[1]


def near_contacts(
    pieces: Mapping[str, BodyTerms],
    contacts: Sequence[Contact],
    values: Mapping[str, float],
    whole: Matrices,
) -> Matrices | None:
    """Return matrices of the dofs near contacts that bound K and M from below; collective.

    ``whole`` are the matrices at given parameters. None where the positions of dofs are not known,
    a body has springs or several constants, or contacts act on dofs that are not near.
    """
    bodies = [each.body for each in pieces.values()]
    positions = [body.space.dof_positions for body in bodies]
    if any(body.springs or body.material.entries for body in bodies):
        return None
    if any(x is None for x in positions):
        return None
    points = KDTree(np.concatenate([contact.interface.points.x for contact in contacts]))
    distances = np.concatenate([points.query(x)[0] for x in positions if x is not None])
    # Rounding must not decide about points as far away as the dof at the quantile.
    far = FarPoints(points, (1 + _ASIDE) * float(np.quantile(distances, _NEAR)))
    terms = [term for piece in pieces.values() for term in piece.weighted(far)]
    K, M = (
        scaled_total([(1.0, total), *(_part(each, values) for each in terms if each.role == role)])
        for role, total in (("stiffness", whole.stiffness), ("mass", whole.mass))
    )
    destroy(*(term.matrix for term in terms))
    near = _restricted(replace(whole, stiffness=K, mass=M), whole)
    destroy(K, M)
    return near


def _part(term: Term, values: Mapping[str, float]) -> tuple[float, Mat]:
    return -term.coefficient.at(values), term.matrix


def _restricted(matrices: Matrices, whole: Matrices) -> Matrices | None:
    """Return matrices of the dofs with stiffness or mass near contacts, contact stiffness included.

    None where friction or contact forces act on other dofs.
    """
    M, forces, friction = matrices.mass, matrices.multipliers, matrices.unsymmetric
    inside = np.zeros(M.getLocalSize()[0], dtype=bool)
    for part, total in ((matrices.stiffness, whole.stiffness), (M, whole.mass)):
        inside |= diagonal_of(part) > _INSIDE * diagonal_of(total)
    if _acts_on(matrices, np.where(inside, 0.0, 1.0)):
        return None
    M.scale(1 - _REMOVED)
    diagonal = M.getDiagonal()
    diagonal.array[:] += _LUMPED * diagonal_of(whole.mass)
    M.setDiagonal(diagonal)
    M.assemble()
    dofs = _index_set(inside, M)
    stiffness, mass = (each.createSubMatrix(dofs, dofs) for each in (matrices.stiffness, M))
    unsymmetric = friction and friction.createSubMatrix(dofs, dofs)
    multipliers = None if forces is None else _of_columns(forces, dofs)
    destroy(diagonal, dofs)
    return Matrices(stiffness, unsymmetric, mass, None, multipliers)


def _acts_on(matrices: Matrices, dofs: Floats) -> bool:
    """Whether friction or contact forces act on marked dofs (1 or 0)."""
    forces, friction = matrices.multipliers, matrices.unsymmetric
    acts = False
    for each in (friction, *((forces.closure, forces.reaction) if forces else ())):
        if each is not None:
            sizes = of_entries(np.abs, each)
            acts |= bool(applied(sizes, dofs).any())
            if each is friction:
                acts |= bool(applied(sizes, dofs, transposed=True).any())
            destroy(sizes)
    return bool(matrices.mass.comm.tompi4py().allreduce(acts, MPI.LOR))


def _of_columns(forces: Multipliers, dofs: Any) -> Multipliers:
    """Return contact forces by their closures and reactions at some dofs, PETSc index set."""
    rows = _index_set(np.ones(forces.closure.getLocalSize()[0], bool), forces.closure)
    closure = forces.closure.createSubMatrix(rows, dofs)
    reaction = forces.reaction.createSubMatrix(rows, dofs)
    destroy(rows)
    border = forces.border and forces.border.copy()
    return Multipliers(closure, reaction, forces.compliance.copy(), border, forces.tied)


def _index_set(chosen: Any, matrix: Mat) -> Any:
    """Return the chosen rows of this rank as a PETSc index set."""
    rows: Any = matrix.getOwnershipRange()[0] + np.flatnonzero(chosen)
    return PETSc.IS().createGeneral(rows.astype(PETSc.IntType), comm=matrix.comm)
