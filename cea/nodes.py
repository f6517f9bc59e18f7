"""Which unknowns belong together: those of the displacement at one basis function."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints


@dataclass(frozen=True)
class Nodes:
    """Basis functions of this rank, and the unknowns at them, one function after another."""

    dim: int  # components of a displacement
    counts: Ints  # unknowns that supports leave free at each, up to dim, shape (functions,)

    @property
    def unknowns(self) -> Ints:
        """Unknowns of this rank by basis function, -1 in the place of those held, (n, dim)."""
        ends = np.cumsum(self.counts)
        table = (ends - self.counts)[:, None] + np.arange(self.dim)
        return np.where(table < ends[:, None], table, -1)

    def blocks(self, rows: csr_array, first: int) -> Floats:
        """Diagonal blocks of a matrix, zero where held, shape (functions, dim, dim)."""
        node = np.repeat(np.arange(len(self.counts)), self.counts)
        place = np.arange(len(node)) - np.repeat(np.cumsum(self.counts) - self.counts, self.counts)
        row = np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr))
        column = rows.indices.astype(np.int64) - first
        own = np.flatnonzero((column >= 0) & (column < len(node)))
        own = own[node[row[own]] == node[column[own]]]
        row, column = row[own], column[own]
        result = np.zeros((len(self.counts), self.dim, self.dim))
        np.add.at(result, (node[row], place[row], place[column]), rows.data[own])
        return result
