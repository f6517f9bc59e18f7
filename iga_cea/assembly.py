"""Stiffness and mass of joined patches by Gauss quadrature, a chunk of elements at a time.

With the physical gradients of an element scaled by the square root of weight and Jacobian, one
product H = G^T G holds every integral

    H[a, i, b, j] = int dN_a/dx_i dN_b/dx_j,

and isotropic elasticity is K[a, i, b, j] = lambda H[a, i, b, j] + mu H[a, j, b, i]
+ mu delta_ij sum_k H[a, k, b, k] (Hughes, The Finite Element Method, sec. 2.7). The product of a
matrix with its own transpose is exactly symmetric, and so is all that follows.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc

from cea.body import Floats, Ints
from cea.errors import InputError
from iga_cea.chunks import chunks
from iga_cea.multipatch import Multipatch
from iga_cea.patch import Patch
from iga_cea.pattern import Pattern, pair_offsets, patch_connectivity
from iga_cea.splines import basis_functions, gauss_rule


def stiffness(
    multipatch: Multipatch, pattern: Pattern, lame: tuple[float, float], comm: Any
) -> Any:
    """Elastic stiffness, all dofs.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    lame
        Lame parameters (N/m^2).
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix of block size dim (N/m), exactly symmetric in serial.
    """
    dim = multipatch.dim
    indptr, indices = pattern.block_rows(dim)
    data = np.zeros(len(indices))
    triples = data.reshape(-1, dim)

    def add(batch: "_Batch") -> None:
        scaled = batch.gradients * np.sqrt(batch.measure)[..., None, None]
        H = _gram(scaled.reshape(*scaled.shape[:2], -1))
        shape = (len(H), *scaled.shape[2:], *scaled.shape[2:])
        K = _elasticity(H.reshape(shape), *lame)
        for a, row, place in batch.places:
            start, count = dim * pattern.starts[row], pattern.counts[row]
            for i in range(dim):
                triples[(start + i * count)[:, None] + place] += K[:, a, i]

    _each_batch(multipatch, pattern, comm.rank, add, True)
    return _matrix(multipatch, pattern, (indptr, indices, data), comm)


def mass(multipatch: Multipatch, pattern: Pattern, rho: float, comm: Any) -> Any:
    """Consistent mass, all dofs.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    rho
        Density (kg/m^3).
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix of block size dim (kg), exactly symmetric in serial.
    """
    data = np.zeros(len(pattern.columns))

    def add(batch: "_Batch") -> None:
        M = _gram(batch.values * np.sqrt(rho * batch.measure)[..., None])
        for a, row, place in batch.places:
            data[pattern.starts[row][:, None] + place] += M[:, a]

    _each_batch(multipatch, pattern, comm.rank, add, False)
    return _matrix(multipatch, pattern, pattern.expanded(data, multipatch.dim), comm)


def _gram(a: Floats) -> Floats:
    """Products A^T A of stacked matrices, exactly symmetric (BLAS syrk)."""
    return a.swapaxes(1, 2) @ a


def _elasticity(H: Floats, lam: float, mu: float) -> Floats:
    K = lam * H
    K += mu * H.transpose(0, 1, 4, 3, 2)
    trace = mu * np.einsum("eakbk->eab", H)
    for i in range(H.shape[2]):
        K[:, :, i, :, i] += trace
    return K


@dataclass(frozen=True)
class _Batch:
    """Some elements of a patch at their Gauss points.

    Parameters
    ----------
    values
        Values of the functions, (elements, points, functions).
    gradients
        Physical gradients, (elements, points, functions, dim).
    measure
        Weight times Jacobian (m^dim), (elements, points).
    rows
        Local scalar dofs, (elements, functions).
    connectivity
        Functions of the patch, (elements, functions).
    table, offsets
        Where pairs of functions lie in their sparse rows.
    """

    values: Floats
    gradients: Floats
    measure: Floats
    rows: Ints
    connectivity: Ints
    table: Any
    offsets: Ints

    @property
    def places(self) -> Iterator[tuple[int, Ints, Ints]]:
        """For each function a: a, its rows, and the places of its pairs in these rows.

        The rows of one a are all different, so that ``+=`` on these places loses nothing. An
        entry (r, c) and its mirror image meet the same elements in the same order.
        """
        for a in range(self.rows.shape[1]):
            place = self.table[self.connectivity[:, a, None], self.offsets[a]]
            yield a, self.rows[:, a], place


def _each_batch(
    multipatch: Multipatch,
    pattern: Pattern,
    rank: int,
    add: Callable[[_Batch], None],
    gradients: bool,
) -> None:
    """Run through the elements of a rank in chunks of bounded memory."""
    for k, (patch, elements) in enumerate(
        zip(multipatch.patches, multipatch.elements_of(rank), strict=True)
    ):
        if not len(elements):
            continue
        axes = [_AxisTable.of(patch, axis) for axis in range(patch.dim)]
        offsets = pair_offsets(patch)
        functions, points = offsets.shape[0], np.prod([len(a.weights[0]) for a in axes])
        components = patch.dim if gradients else 1
        entries = 3 * (functions * components) ** 2 + 4 * (components + 1) * functions * points
        for part in chunks(len(elements), 8 * float(entries)):
            connectivity = patch_connectivity(patch, elements[part])
            values, slopes, measure = _tabulate(patch, axes, elements[part], connectivity, k)
            add(
                _Batch(
                    values,
                    slopes,
                    measure,
                    pattern.rows[k][connectivity],
                    connectivity,
                    pattern.tables[k],
                    offsets,
                )
            )


@dataclass(frozen=True)
class _AxisTable:
    """Splines of one parameter at the Gauss points of each span.

    Parameters
    ----------
    tables
        Values and first derivatives, two arrays of shape (spans, points, degree + 1).
    weights
        Gauss weights, (spans, points).
    """

    tables: Floats
    weights: Floats

    @classmethod
    def of(cls, patch: Patch, axis: int) -> "_AxisTable":
        degree = patch.degrees[axis]
        x, weights = gauss_rule(patch.breaks[axis], degree + 1)
        _, tables = basis_functions(patch.knots[axis], degree, x.ravel(), 1)
        return cls(tables.reshape(2, *x.shape, degree + 1), weights)


def _tabulate(
    patch: Patch, axes: list[_AxisTable], elements: Ints, connectivity: Ints, number: int
) -> tuple[Floats, Floats, Floats]:
    """Values, physical gradients and measure of elements, as in :class:`_Batch`."""
    spans = np.unravel_index(elements, patch.spans)
    weights = patch.weights.ravel()[connectivity][:, None]
    measure = np.ones((len(elements), 1))
    for axis, span in zip(axes, spans, strict=True):
        measure = (measure[:, :, None] * axis.weights[span][:, None]).reshape(len(elements), -1)

    def weighted(derivative: int | None) -> Floats:
        """Splines times weights, one of their parameters differentiated or none."""
        out = np.ones((len(elements), 1, 1))
        for k, (axis, span) in enumerate(zip(axes, spans, strict=True)):
            table = axis.tables[int(k == derivative)][span]
            out = out[:, :, None, :, None] * table[:, None, :, None, :]
            out = out.reshape(len(elements), out.shape[1] * out.shape[2], -1)
        return out * weights

    values = weighted(None)
    total = values.sum(axis=2, keepdims=True)
    values /= total
    slopes = np.empty((*values.shape, patch.dim))
    for k in range(patch.dim):
        slope = weighted(k) / total
        slopes[..., k] = slope - values * slope.sum(axis=2, keepdims=True)

    points = patch.control_points.reshape(-1, patch.dim)[connectivity]
    jacobian = points.swapaxes(1, 2)[:, None] @ slopes
    determinant = np.linalg.det(jacobian)
    if determinant.min() <= 0 <= determinant.max():
        raise InputError(f"patches[{number}]", "a folded map", "a Jacobian of one sign")
    return values, slopes @ np.linalg.inv(jacobian), measure * np.abs(determinant)


def _matrix(
    multipatch: Multipatch, pattern: Pattern, csr: tuple[Any, Any, Floats], comm: Any
) -> Any:
    """AIJ matrix from the local contributions of each rank."""
    dim = multipatch.dim
    local = dim * len(pattern.dofs)
    part = PETSc.Mat().createAIJWithArrays(
        size=(local, local), bsize=dim, csr=csr, comm=PETSc.COMM_SELF
    )
    if comm.size == 1:
        return part
    owned = dim * int(np.diff(multipatch.dof_ranges)[comm.rank])
    sizes = ((owned, dim * multipatch.num_scalar_dofs),) * 2
    numbering = PETSc.LGMap().create(pattern.dofs.astype(PETSc.IntType), bsize=dim, comm=comm)
    whole = PETSc.Mat().createIS(sizes, bsize=dim, lgmapr=numbering, lgmapc=numbering, comm=comm)
    whole.setISLocalMat(part)
    whole.assemble()
    return whole.convert(PETSc.Mat.Type.AIJ)
