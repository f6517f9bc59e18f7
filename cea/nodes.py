"""Which unknowns belong together: the components of the displacement at one basis function."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array

from cea.arrays import Floats, Ints


@dataclass(frozen=True)
class Nodes:
    """Basis functions of this rank and the unknowns at them."""

    dim: int  # components of a displacement
    count: int  # basis functions of this rank
    # of each unknown of this rank, shape (n_local,): its basis function among those of this rank,
    # and its component. Where supports hold a displacement the component has no unknown
    node: Ints
    component: Ints

    @cached_property
    def unknowns(self) -> Ints:
        """Unknowns of this rank by basis function and component, -1 where held, (count, dim)."""
        table = np.full((self.count, self.dim), -1, dtype=np.int64)
        table[self.node, self.component] = np.arange(len(self.node))
        return table

    def blocks(self, rows: csr_array, first: int) -> Floats:
        """Diagonal blocks of a matrix, zero where held, shape (count, dim, dim)."""
        row = np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr))
        column = rows.indices.astype(np.int64) - first
        own = (column >= 0) & (column < len(self.node))
        row, column, values = row[own], column[own], rows.data[own]
        same = self.node[row] == self.node[column]
        row, column, values = row[same], column[same], values[same]
        result = np.zeros((self.count, self.dim, self.dim))
        np.add.at(result, (self.node[row], self.component[row], self.component[column]), values)
        return result


def places(expansion: csr_array, own: range) -> Ints | None:
    """The dof that each unknown moves most; None where two move the same, or one moves none."""
    entries = coo_array(expansion)
    column = entries.col - own.start
    mine = (column >= 0) & (column < len(own))
    row, column, size = entries.row[mine], column[mine], np.abs(entries.data[mine])
    order = np.lexsort((size, column))
    last = np.flatnonzero(np.diff(column[order], append=len(own)))
    dofs = row[order][last].astype(np.int64)
    return dofs if len(np.unique(dofs)) == len(own) else None


def joined(dofs: Sequence[Ints], functions: Sequence[int], dim: int) -> Nodes:
    """Basis functions of bodies, one body after another."""
    starts = np.cumsum([0, *functions])
    node = np.concatenate([each // dim + at for each, at in zip(dofs, starts, strict=False)])
    component = np.concatenate([each % dim for each in dofs])
    return Nodes(dim, int(starts[-1]), node, component)
