"""Modes of a complex eigenvalue analysis."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cea.body import Complexes
from cea.eigen.pencil import Pencil
from cea.eigen.sensitivity import LeftVectors, derivatives
from cea.eigen.spectrum import Spectrum
from cea.errors import InputError


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
