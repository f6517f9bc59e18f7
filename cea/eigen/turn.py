"""Test functions turned so that friction works on them as contact alone does.

A contact with friction puts forces along v = n - m on a node, n its normal and m = mu times the
direction of friction, for a gap along n: its stiffness is v n^T there. A symmetric matrix with
S v = n makes that symmetric. Of those the one that turns least, by the angle of friction, is

    S = 1 + (F + F^T + F^T F - F F^T) / (1 + tr F^T F),     F = m n^T,

with eigenvalues 1 and 1 -+ mu / sqrt(1 + mu^2): positive whatever mu. It is taken at each node of
a contact, and from there it is extended into the bodies: at each node S - 1 is a mean of that at
its neighbours, by the traces of the blocks of K. What holds a body does not hold it; it varies
slowly, fades, stays positive definite, and is block diagonal.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from cea.arrays import Floats
from cea.eigen.blocks import image_of
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Matrices
from cea.matrices import destroy, distributed, local_part, scaled_total, transposed_product
from cea.nodes import Nodes
from cea.petsc import MPI

_TOUCHED = 1e-10
"""Trace of a node's block of a contact, relative to the largest, from which it is touched."""
_FADING = 1e-3
"""What is added to the diagonal where S is extended, relative to it: far away S is 1, and bodies
without friction may float."""


@dataclass(frozen=True)
class Turn:
    """Turned test functions, node by node.

    Parameters
    ----------
    matrix
        S, PETSc AIJ (n x n), symmetric and block diagonal.
    normals
        N, PETSc AIJ (n x m): unit displacements along the normal of each node of the contacts.
    """

    matrix: Any
    normals: Any

    def free(self) -> None:
        """Free both."""
        destroy(self.matrix, self.normals)


def turn_of(matrices: Matrices) -> Turn | None:
    """S and N of a pencil; collective.

    Parameters
    ----------
    matrices
        The pencil at given parameters.

    Returns
    -------
    Turn or None
        None without friction, or where it is not known which unknowns belong together.

    Raises
    ------
    ConvergenceError
        When a factorisation fails.
    """
    nodes = matrices.nodes
    if nodes is None or matrices.symmetric:
        return None
    friction, normals, touched = _directions(matrices, nodes)
    squares = np.einsum("nij,nij->n", friction, friction)
    transposed = np.swapaxes(friction, 1, 2)
    turned = friction + transposed + transposed @ friction - friction @ transposed
    turned /= (1 + squares)[:, None, None]
    rows, columns = np.triu_indices(nodes.dim)
    held = touched | (nodes.unknowns < 0).all(axis=1)
    values = _extended(matrices.stiffness, nodes, turned[:, rows, columns], held)
    turned[:, rows, columns] = turned[:, columns, rows] = values
    like = matrices.stiffness
    return Turn(_block_diagonal(turned, nodes, like), _normals(normals, touched, nodes, like))


def _directions(matrices: Matrices, nodes: Nodes) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """F and normal of each node of this rank, and whether a contact touches it."""
    friction = np.zeros((nodes.count, nodes.dim, nodes.dim))
    along = friction.copy()
    touched = np.zeros(nodes.count, dtype=bool)
    for normal, skew in _contact_stiffnesses(matrices):
        first, comm = normal.getOwnershipRangeColumn()[0], normal.comm.tompi4py()
        blocks = nodes.blocks(local_part(normal), first)
        sizes = np.trace(blocks, axis1=1, axis2=2)
        on = sizes > _TOUCHED * comm.allreduce(sizes.max(initial=0.0), MPI.MAX)
        along[on] += blocks[on] / sizes[on, None, None]
        friction[on] += nodes.blocks(local_part(skew), first)[on] / sizes[on, None, None]
        touched |= on
        destroy(normal, skew)
    return friction, np.linalg.eigh(along)[1][:, :, -1], touched


def _contact_stiffnesses(matrices: Matrices) -> list[tuple[Any, Any]]:
    """What normal gaps make of forces along normals, and along friction, each n^T: new matrices."""
    found = []
    if matrices.unsymmetric is not None and matrices.contacts:
        found.append((scaled_total(matrices.contacts), scaled_total([(-1, matrices.unsymmetric)])))
    if (forces := matrices.multipliers) is not None and not forces.symmetric:
        slip = scaled_total([(1.0, forces.closure), (-1.0, forces.reaction)])
        normal = transposed_product(forces.closure, forces.closure)
        found.append((normal, transposed_product(slip, forces.closure)))
        destroy(slip)
    return found


def _extended(operator: Any, nodes: Nodes, given: Floats, held: NDArray[np.bool_]) -> Floats:
    """Values at all nodes of this rank, harmonic where they are not given.

    Parameters
    ----------
    operator
        K, PETSc AIJ.
    nodes
        Its unknowns by node.
    given
        Values where they are given, and zeros, shape (count, columns).
    held
        Where they are given, shape (count,).
    """
    comm = operator.comm.tompi4py()
    scalar = _laplacian(operator, nodes)
    layout = (nodes.count, scalar.shape[1])
    whole = distributed(scalar, layout, operator.comm)
    load = -image_of(whole, np.asfortranarray(given))
    destroy(whole)
    load[held] = given[held]
    every = np.concatenate(comm.allgather(held))
    first = nodes.starts(comm)[comm.rank]
    entries = coo_array(scalar)
    free = ~(held[entries.row] | every[entries.col])
    at = np.flatnonzero(held)
    values = np.concatenate([entries.data[free], np.ones(len(at))])
    row = np.concatenate([entries.row[free], at])
    column = np.concatenate([entries.col[free], at + first])
    inner = csr_array(coo_array((values, (row, column)), shape=scalar.shape))
    factors = Mumps(distributed(inner, layout, operator.comm), symmetric=True)
    result = factors.solve_block(load)
    factors.free()
    return result


def _laplacian(operator: Any, nodes: Nodes) -> csr_array:
    """Weighted graph of the blocks of K, nodes of this rank by all nodes: rows add to little.

    Weights are traces of blocks where they are negative: values between are means.
    """
    comm, rows = operator.comm.tompi4py(), local_part(operator)
    node, component = nodes.everywhere(comm)
    row = np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr))
    same = nodes.component[row] == component[rows.indices]
    row, column = nodes.node[row[same]], node[rows.indices[same]]
    shape = (nodes.count, int(nodes.starts(comm)[-1]))
    traces = csr_array(coo_array((rows.data[same], (row, column)), shape=shape)).tocoo()
    first = nodes.starts(comm)[comm.rank]
    joined = (traces.data < 0) & (traces.row + first != traces.col)
    row, column, weight = traces.row[joined], traces.col[joined], traces.data[joined]
    own = np.arange(nodes.count)
    sums = (1 + _FADING) * np.bincount(row, -weight, nodes.count)
    values = np.concatenate([weight, np.where(sums > 0, sums, 1.0)])
    places = (np.concatenate([row, own]), np.concatenate([column, own + first]))
    return csr_array(coo_array((values, places), shape=shape))


def _normals(normals: Floats, touched: NDArray[np.bool_], nodes: Nodes, like: Any) -> Any:
    """Unit displacements along normals of the nodes that are touched, PETSc AIJ."""
    comm, at = like.comm.tompi4py(), np.flatnonzero(touched)
    counts = comm.allgather(len(at))
    unknowns = nodes.unknowns[at]
    column = np.broadcast_to(np.arange(len(at))[:, None], unknowns.shape)
    kept = unknowns >= 0
    entries = (normals[at][kept], (unknowns[kept], column[kept] + sum(counts[: comm.rank])))
    shape = (like.getLocalSize()[0], sum(counts))
    rows = csr_array(coo_array(entries, shape=shape))
    return distributed(rows, (len(at), sum(counts)), like.comm)


def _block_diagonal(turned: Floats, nodes: Nodes, like: Any) -> Any:
    """1 and blocks at nodes, on the unknowns, PETSc AIJ of the layout of another."""
    unknowns, first = nodes.unknowns, like.getOwnershipRange()[0]
    row = np.broadcast_to(unknowns[:, :, None], turned.shape)
    column = np.broadcast_to(unknowns[:, None, :], turned.shape)
    kept = (row >= 0) & (column >= 0)
    local, columns = like.getSizes()[0][0], like.getSizes()[1]
    blocks = (turned + np.eye(nodes.dim))[kept]
    entries = (blocks, (row[kept], column[kept] + first))
    return distributed(csr_array(coo_array(entries, shape=(local, columns[1]))), columns, like.comm)
