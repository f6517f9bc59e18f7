"""Modes of a complex eigenvalue analysis, with the errors and the search that vouch for them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Complexes as Complexes
from cea.body import Floats
from cea.eigen.pencil import Pencil
from cea.eigen.sensitivity import LeftVectors, derivatives
from cea.errors import InputError
from cea.warned import ResultWarning


@dataclass(frozen=True)
class Window:
    """What was searched, and why it is believed complete.

    Parameters
    ----------
    max_frequency
        Upper end (Hz) of the modes asked for.
    shift
        Centre sigma of the searched disc of kappa = -lambda^2 (1/s^2).
    radius
        Every kappa with abs(kappa - shift) < radius was found (1/s^2).
    found
        Number of eigenvalues in the disc.
    upper
        Upper end of kappa for the count (1/s^2), a little above the window's.
    found_below
        Eigenvalues found with Re kappa below ``upper``.
    symmetric_count
        Eigenvalues of S x = kappa M x, without friction, below ``upper``, by inertia; None where
        they were not counted.
    max_growth
        Largest growth rate (1/s) a mode at the upper end can have and still lie in the disc.
    """

    max_frequency: float
    shift: float
    radius: float
    found: int
    upper: float
    found_below: int
    symmetric_count: int | None
    max_growth: float

    @property
    def evidence(self) -> str:
        """Why the window is believed complete, in words."""
        disc = (
            f"shift-and-invert converged outwards to all {self.found} eigenvalues in the disc "
            f"|kappa - {self.shift:.5g}| <= {self.radius:.5g}"
        )
        if self.symmetric_count is None:
            return disc
        return (
            f"{disc}; below kappa = {self.upper:.5g} it found {self.found_below}, and the inertia "
            f"of the symmetric part counts {self.symmetric_count}"
        )


@dataclass(frozen=True)
class Modes:
    """Modes by rising frequency, Im lambda >= 0.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,): growth rate + i * angular frequency.
    residuals
        Norm of (lambda^2 M + K) x relative to abs(lambda)^2 times that of M x, shape (n,).
    conditions
        Condition numbers of lambda^2 in the M-norm, shape (n,): 1 for a symmetric problem, large
        near a coalescence. Without left vectors, those within the computed invariant subspace.
    vectors
        Eigenvectors x with x^H M x = 1, the rows of this rank, shape (n_local, n).
    forces
        Their contact forces where these are unknowns, shape (multipliers of this rank, n).
    left
        Left eigenvectors; None where they were not asked for.
    template
        PETSc vector of their layout.
    window
        What was searched.
    pencil, values
        What they are modes of, and the parameters it was solved at.
    warnings
        What they must be read with.
    """

    eigenvalues: Complexes
    residuals: Floats
    conditions: Floats
    vectors: Complexes
    forces: Complexes
    left: LeftVectors | None
    template: Any
    window: Window
    pencil: Pencil
    values: Mapping[str, float]
    warnings: tuple[ResultWarning, ...] = ()

    def __len__(self) -> int:
        return len(self.eigenvalues)

    @property
    def frequencies(self) -> Floats:
        """Frequencies (Hz)."""
        return self.eigenvalues.imag / (2 * np.pi)

    @property
    def growth_rates(self) -> Floats:
        """Growth rates Re lambda (1/s)."""
        return self.eigenvalues.real

    @property
    def growth_uncertainties(self) -> Floats:
        """Growth rates (1/s) that backward error times condition can explain.

        An error e of lambda^2 moves lambda by e / (2 abs(lambda)), or by sqrt(e) near 0. Near a
        coalescence the condition number carries the square root of the rounding.
        """
        square = np.abs(self.eigenvalues) ** 2
        floor = np.maximum(np.abs(self.eigenvalues), np.finfo(float).tiny)
        error = np.maximum(self.residuals, np.finfo(float).eps) * self.conditions * square
        return np.minimum(error / (2 * floor), np.sqrt(error))

    def unstable(self, threshold: float = 0.0) -> NDArray[np.bool_]:
        """Modes that grow faster than a threshold (1/s) and than their errors explain, (n,)."""
        return self.growth_rates > np.maximum(threshold, self.growth_uncertainties)

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
