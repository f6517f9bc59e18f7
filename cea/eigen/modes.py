"""Modes of a complex eigenvalue analysis."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.body import Complexes, Floats
from cea.eigen.eigenpairs import Eigenpairs
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.sensitivity import LeftVectors, derivatives, dual_norms
from cea.eigen.spectrum import Spectrum, Window
from cea.errors import InputError
from cea.warned import ResultWarning

_LARGE_RESIDUAL = 1e-6
"""Relative residual above which a mode is warned of."""


@dataclass(frozen=True)
class Modes(Spectrum):
    """Eigenvalues with their eigenvectors, and what they are modes of.

    Parameters
    ----------
    vectors
        Eigenvectors x with x^H M x = 1, the rows of this rank, shape (n_local, n).
    forces
        Their contact forces where these are unknowns, shape (multipliers of this rank, n).
    left
        Left eigenvectors; None where they were not asked for.
    template
        PETSc vector of their layout.
    pencil, values
        What they are modes of, and the parameters it was solved at.
    """

    vectors: Complexes
    forces: Complexes
    left: LeftVectors | None
    template: Any
    pencil: Pencil
    values: Mapping[str, float]

    __repr__ = Spectrum.__str__

    def vector(self, mode: int) -> tuple[Any, Any]:
        """Real and imaginary part of an eigenvector as PETSc vectors."""
        real, imaginary = self.template.duplicate(), self.template.duplicate()
        real.array[:] = self.vectors[:, mode].real
        imaginary.array[:] = self.vectors[:, mode].imag
        return real, imaginary

    def sensitivity(self, parameter: str) -> Complexes:
        """Derivatives of the eigenvalues in a parameter of the pencil, shape (n,).

        d lambda / dt = - y^H (lambda^2 dM/dt + dK/dt) x / (2 lambda y^H M x) with left vectors y.
        Members of a multiple eigenvalue have those of its splitting, in any order. Infinite at a
        coalescence, and not a number at lambda = 0.

        Parameters
        ----------
        parameter
            Its name, e.g. ``contacts.pad_disc.mu``.

        Raises
        ------
        InputError
            When there is no such parameter, or no left vectors were asked for.
        """
        name = self.pencil.parameter(parameter).name
        if self.left is None:
            raise InputError("left", False, "True where modes are solved for, for sensitivities")
        return derivatives(
            self.pencil, self.values, name, self.eigenvalues, self.vectors, self.forces, self.left
        )


def modes_of(
    pencil: Pencil,
    values: Mapping[str, float],
    matrices: Matrices,
    pairs: Eigenpairs,
    left: LeftVectors | None,
    window: Window,
) -> Modes:
    """Modes lambda^2 = -kappa with Im lambda >= 0 up to the end of the window.

    Parameters
    ----------
    pencil, values, matrices
        What was solved, at which parameters.
    pairs
        Eigenpairs that were found.
    left
        Left vectors in their order; None where they were not asked for.
    window
        What was searched.
    """
    eigenvalues = np.sqrt(-pairs.kappa).astype(complex)
    eigenvalues = np.where(eigenvalues.imag < 0, -eigenvalues, eigenvalues) + 0j
    order = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[eigenvalues.imag[order] <= 2 * np.pi * window.max_frequency]
    conditions = pairs.conditions
    if left is not None and not matrices.symmetric:  # y^H M x = 1 and x^H M x = 1
        conditions = dual_norms(matrices.mass, left.vectors)
    return Modes(
        eigenvalues=eigenvalues[order],
        residuals=pairs.residuals[order],
        conditions=conditions[order],
        vectors=pairs.vectors[:, order],
        forces=pairs.forces[:, order],
        left=left[order] if left is not None else None,
        template=matrices.stiffness.createVecRight(),
        window=window,
        pencil=pencil,
        values=values,
        warnings=_warnings(window, pairs.residuals[order]),
    )


def _warnings(window: Window, residuals: Floats) -> tuple[ResultWarning, ...]:
    """What modes must be read with."""
    warnings = []
    if window.symmetric_count is not None and window.found_below != window.symmetric_count:
        warnings.append(
            ResultWarning(
                "count-differs",
                f"{window.found_below} eigenvalues found where the symmetric part counts "
                f"{window.symmetric_count}: friction moved the others, or they were missed",
                {"found": window.found_below, "counted": window.symmetric_count},
            )
        )
    worst = float(residuals.max(initial=0.0))
    if worst > _LARGE_RESIDUAL:
        warnings.append(
            ResultWarning(
                "residual",
                f"the largest residual of a mode is {worst:.1e}: it is not to be trusted",
                {"largest": worst, "modes": int((residuals > _LARGE_RESIDUAL).sum())},
            )
        )
    return tuple(warnings)
