"""Matrices of a Lagrange space on what supports leave free, symmetric to the last bit."""

from collections.abc import Callable
from typing import Any

from dolfinx.fem.petsc import assemble_matrix
from scipy.sparse import csr_array

from cea.matrices import antisymmetrised, destroy, symmetrised
from cea.petsc import PETSc
from cea.supports.constraints import Constraints


class Restriction:
    """Matrices (free x free) from integrals over all dofs.

    Parameters
    ----------
    held
        What supports hold.
    expansion
        PETSc AIJ matrix (full x free) of it.
    """

    def __init__(self, held: Constraints, expansion: Any) -> None:
        self._held = held
        self._expansion = expansion

    def of_free(self, assembled: Callable[[Constraints | None], Any]) -> Any:
        """Matrix of a symmetric integral that can be assembled without plain components.

        Parameters
        ----------
        assembled
            Gives the matrix without what supports hold, or that of all dofs for None, symmetric to
            the last bit.
        """
        if self._held.selects:
            return assembled(self._held)
        full = assembled(None)
        free = self._held.restrict(full, self._expansion)
        destroy(full)
        return symmetrised(free)

    def symmetric(self, form: Any, *, with_zeros: bool = True) -> Any:
        """Matrix of a symmetric form (dolfinx)."""
        # Element matrices, and products with a turned frame, are symmetric up to rounding only.
        return symmetrised(self._restricted(form, with_zeros=with_zeros))

    def skew(self, form: Any) -> Any:
        """Skew part of the matrix of a form (dolfinx)."""
        return antisymmetrised(self._restricted(form, with_zeros=False))

    def _restricted(self, form: Any, *, with_zeros: bool) -> Any:
        full = assemble_matrix(form)
        full.assemble()
        if not with_zeros:  # ahead of all that copies it
            full = _without_zeros(full)
        free = self._held.restrict(full, self._expansion)
        if free is not full:
            full.destroy()
        return free


def _without_zeros(matrix: Any) -> Any:
    """AIJ matrix without stored zeros; the given one goes."""
    sizes, comm = matrix.getSizes(), matrix.comm
    indptr, indices, values = matrix.getValuesCSR()
    rows = csr_array((values, indices, indptr), shape=(len(indptr) - 1, sizes[1][1]))
    rows.eliminate_zeros()
    entries = (rows.indptr, rows.indices, rows.data)
    without = PETSc.Mat().createAIJ(sizes, csr=entries, comm=comm)
    matrix.destroy()
    return without
