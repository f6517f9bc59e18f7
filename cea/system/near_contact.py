"""The part of a system near its contacts, on which friction acts.

Cells farther away bring K_r and M_r, which are positive semidefinite. With the displacements x_c of
the part, H = (K + K^T) / 2 and N = (K - K^T) / 2,

    x^T (H + X M) x >= x_c^T (H_c + X M_c) x_c,    x^T N x = x_c^T N_c x_c,    X >= 0:

bounds of the field of values of the part are bounds of that of the whole
(:mod:`cea.eigen.field_of_values`), at a fraction of the price.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.multipliers import ForcesOfContact
from cea.eigen.parameters import Parameter
from cea.eigen.pencil import Pencil, Term
from cea.matrices import absolute, destroy
from cea.petsc import MPI, Mat, PETSc
from cea.system.body_terms import STILL, body_terms, part_terms

_SMALL = 1 / 3
"""Part of all nodes up to which a body that a contact acts on is near it as a whole: a cut through
a thin one would let it bend."""
_SHARE = 0.17
"""Part of all nodes that others have near contacts."""
_MOST = 0.6
"""Part of all nodes from which on it is not worth its assembly."""
PARTED_FROM = 10_000
"""Unknowns from which on it is worth its assembly."""

type Embedding = Callable[[str, Mat], Mat]
"""Takes a matrix of a named body to one of all unknowns."""


@dataclass(frozen=True)
class ContactPieces:
    """What contacts bring to a pencil.

    Parameters
    ----------
    terms
        K_n and K_f of contacts whose forces are eliminated.
    forces
        Forces of the others.
    """

    terms: Sequence[Term]
    forces: Sequence[ForcesOfContact]

    def touched(self, template: Any) -> NDArray[np.bool_]:
        """Which unknowns of this rank contacts act on; collective.

        Parameters
        ----------
        template
            PETSc vector of the unknowns.
        """
        total, one = template.duplicate(), template.duplicate()
        total.set(0.0)
        one.set(1.0)
        for term in self.terms:
            sizes = absolute(term.matrix)
            sizes.multAdd(one, total, total)
            sizes.multTransposeAdd(one, total, total)
            destroy(sizes)
        for forces in self.forces:
            for operator in (forces.closure, forces.slip):
                if operator is not None:
                    sizes, every = absolute(operator), operator.createVecLeft()
                    every.set(1.0)
                    sizes.multTransposeAdd(every, total, total)
                    destroy(sizes, every)
        touched: NDArray[np.bool_] = total.array_r > 0
        destroy(total, one)
        return touched

    def restricted(self, kept: Any) -> "ContactPieces":
        """The same on some unknowns, a PETSc index set, outside of which it is zero."""
        terms = [replace(t, matrix=t.matrix.createSubMatrix(kept, kept)) for t in self.terms]
        forces = []
        for each in self.forces:
            first, last = each.closure.getOwnershipRange()
            rows = PETSc.IS().createStride(last - first, first, 1, comm=kept.comm)
            closure = each.closure.createSubMatrix(rows, kept)
            slip = None if each.slip is None else each.slip.createSubMatrix(rows, kept)
            forces.append(replace(each, closure=closure, slip=slip))
            destroy(rows)
        return ContactPieces(terms, forces)


def near_contact(
    bodies: Mapping[str, Body],
    contacts: ContactPieces,
    parameters: Iterable[Parameter],
    template: Any,
    embedded: Embedding,
    *,
    leave_out: bool = True,
    parted_from: int = PARTED_FROM,
) -> Pencil | None:
    """Pencil of what lies near the contacts; None where that is not much less than all. Collective.

    Parameters
    ----------
    bodies
        Bodies by name, in the order of the unknowns, with mass and without anything in their
        stiffness but elasticity and springs.
    contacts
        What contacts bring.
    parameters
        Parameters of the pencil of the whole.
    template
        PETSc vector of the unknowns.
    embedded
        Takes a matrix of a body to one of all unknowns.
    leave_out
        Whether friction that is zero is left out.
    parted_from
        Unknowns from which on the part is wanted.
    """
    if template.getSize() < parted_from:
        return None
    touched, comm = contacts.touched(template), template.comm.tompi4py()
    distances = dict(_distances(bodies, touched))
    near = _near(distances, comm)
    if sum(comm.allreduce(int(each.sum())) for each in near.values()) > _MOST * _nodes(bodies):
        return None
    terms = list(_terms(bodies, near, embedded))
    kept = _kept([term.matrix for term in terms if term.role == "mass"], touched, template)
    if kept is None:
        return None
    pieces = contacts.restricted(kept)
    own = [replace(term, matrix=term.matrix.createSubMatrix(kept, kept)) for term in terms]
    destroy(kept)
    return Pencil([*own, *pieces.terms], parameters, pieces.forces, leave_out=leave_out)


def _nodes(bodies: Mapping[str, Body]) -> int:
    """Nodes of all bodies."""
    return sum(body.num_scalar_dofs for body in bodies.values())


def _distances(
    bodies: Mapping[str, Body], touched: NDArray[np.bool_]
) -> Iterator[tuple[str, Floats]]:
    """Distance (m) of the nodes of this rank from those of their body that contacts act on.

    Zero at all nodes of a small body or of one that cannot be parted, infinite where no contact
    acts on a body.
    """
    first, most = 0, _SMALL * _nodes(bodies)
    for name, body in bodies.items():
        expansion = body.expansion
        rows, columns = expansion.getLocalSize()
        free, full = expansion.createVecs()
        free.array[:] = touched[first : first + columns]
        first += columns
        sizes = absolute(expansion)
        sizes.mult(free, full)
        nodes = full.array_r.reshape(-1, body.dim).any(axis=1)
        destroy(sizes, free, full)
        positions = body.node_positions
        if not body.comm.allreduce(bool(nodes.any()), MPI.LOR):
            yield name, np.full(rows // body.dim, np.inf)
        elif positions is None or body.num_scalar_dofs <= most:
            yield name, np.zeros(rows // body.dim)
        else:
            near = np.concatenate(body.comm.allgather(positions[nodes]))
            yield name, np.asarray(KDTree(near).query(positions)[0])


def _near(distances: Mapping[str, Floats], comm: Any) -> dict[str, NDArray[np.bool_]]:
    """Which nodes of each body are near: of those that are parted a share of all; collective."""
    every = np.sort(np.concatenate(comm.allgather(np.concatenate(list(distances.values())))))
    whole = int(np.searchsorted(every, 0.0, side="right"))
    place = min(whole + int(_SHARE * len(every)), len(every) - 1)
    reach = every[place] if np.isfinite(every[place]) else np.inf
    return {name: (each == 0) | (each < reach) for name, each in distances.items()}


def _terms(
    bodies: Mapping[str, Body], near: Mapping[str, NDArray[np.bool_]], embedded: Embedding
) -> Iterator[Term]:
    """K and M of all cells that are near."""
    for name, body in bodies.items():
        path, place = f"bodies.{name}", partial(embedded, name)
        if not body.comm.allreduce(bool(near[name].any()), MPI.LOR):
            continue
        if body.node_positions is None:
            yield from body_terms(path, body, STILL, place, with_mass=True)
        else:
            yield from part_terms(path, body, near[name], place)


def _kept(masses: Sequence[Mat], touched: NDArray[np.bool_], template: Any) -> Any | None:
    """Unknowns with mass, PETSc index set; None where they are not all that contacts act on."""
    total = template.duplicate()
    total.set(0.0)
    for mass in masses:
        diagonal = mass.getDiagonal()
        total.axpy(1.0, diagonal)
        destroy(diagonal)
    there = total.array_r > 0
    destroy(total)
    if template.comm.tompi4py().allreduce(bool((touched & ~there).any()), MPI.LOR):
        return None
    first = template.getOwnershipRange()[0]
    rows = (first + np.flatnonzero(there)).astype(PETSc.IntType)
    return PETSc.IS().createGeneral(rows, comm=template.comm)
