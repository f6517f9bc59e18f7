"""Elements of patches at their Gauss points, a chunk at a time."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError
from iga_cea.chunks import chunks
from iga_cea.collapse import merging, separated
from iga_cea.multipatch import Multipatch
from iga_cea.patch import Patch
from iga_cea.pattern import Pattern, pair_offsets, patch_connectivity
from iga_cea.splines import basis_functions, gauss_rule


@dataclass(frozen=True)
class Batch:
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

    def merged(self) -> Iterator["Batch"]:
        """The same elements with the functions of one dof summed, sorted by which these are."""
        for alike, kept, sums in merging(self.rows):
            connectivity = self.connectivity[np.ix_(alike, kept)]
            yield Batch(
                self.values[alike] @ sums,
                sums.T @ self.gradients[alike],
                self.measure[alike],
                self.rows[np.ix_(alike, kept)],
                connectivity,
                self.table,
                self.offsets[np.ix_(kept, kept)],
            )


def batches(
    multipatch: Multipatch, pattern: Pattern, rank: int, *, components: int
) -> Iterator[Batch]:
    """Run through the elements of a rank in chunks of bounded memory.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of the rank.
    rank
        The rank.
    components
        Rows of its element matrices for each function, for the size of the chunks.

    Raises
    ------
    InputError
        When a patch is folded.
    """
    for k, (patch, mine) in enumerate(
        zip(multipatch.patches, multipatch.elements_of(rank), strict=True)
    ):
        axes = [_AxisTable.of(patch, axis) for axis in range(patch.dim)]
        offsets = pair_offsets(patch)
        functions, points = offsets.shape[0], np.prod([len(a.weights[0]) for a in axes])
        entries = 3 * (functions * components) ** 2 + 4 * (patch.dim + 1) * functions * points
        groups = separated(patch.collapsed, patch.first_functions, patch.degrees, mine)
        for elements, beside_collapsed in groups:
            for part in chunks(len(elements), 8 * float(entries)):
                connectivity = patch_connectivity(patch, elements[part])
                values, gradients, measure = _tabulate(patch, axes, elements[part], connectivity, k)
                batch = Batch(
                    values,
                    gradients,
                    measure,
                    pattern.rows[k][connectivity],
                    connectivity,
                    pattern.tables[k],
                    offsets,
                )
                yield from batch.merged() if beside_collapsed else (batch,)


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
