"""Modes of a complex eigenvalue analysis, with the errors and the search that vouch for them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Floats

Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class Window:
    """What was searched, and why it is believed complete.

    Parameters
    ----------
    max_frequency
        Upper end (Hz) of the modes asked for.
    shift
        Centre sigma of the searched disc of kappa (1/s^2).
    radius
        Every kappa with abs(kappa - shift) < radius was found (1/s^2).
    found
        Number of eigenvalues in the disc.
    upper
        Upper end of kappa for the count (1/s^2), a little above the window's.
    found_below
        Eigenvalues found with Re kappa below ``upper``.
    symmetric_count
        Eigenvalues of S x = kappa M x, without friction, below ``upper``, by inertia.
    max_growth
        Largest growth rate (1/s) a mode at the upper end can have and still lie in the disc.
    """

    max_frequency: float
    shift: float
    radius: float
    found: int
    upper: float
    found_below: int
    symmetric_count: int
    max_growth: float

    @property
    def evidence(self) -> str:
        """Why the window is believed complete, in words."""
        return (
            f"shift-and-invert converged outwards to all {self.found} eigenvalues in the disc "
            f"|kappa - {self.shift:.5g}| <= {self.radius:.5g}; below kappa = {self.upper:.5g} "
            f"it found {self.found_below}, and the inertia of the symmetric part counts "
            f"{self.symmetric_count}"
        )


@dataclass(frozen=True)
class Modes:
    """Modes by rising frequency, Im lambda >= 0.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,): growth rate + i * angular frequency.
    residuals
        Norm of (S - F - kappa M) x relative to abs(kappa) times that of M x, shape (n,).
    conditions
        Condition numbers of kappa in the M-norm within the computed invariant subspace, shape
        (n,): 1 for a symmetric problem, large near a coalescence.
    vectors
        Eigenvectors x with x^H M x = 1, the rows of this rank, shape (n_local, n).
    template
        PETSc vector of their layout.
    window
        What was searched.
    """

    eigenvalues: Complexes
    residuals: Floats
    conditions: Floats
    vectors: Complexes
    template: Any
    window: Window

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

        An error e of kappa moves lambda by e / (2 abs(lambda)), or by sqrt(e) near kappa = 0.
        Near a coalescence the condition number carries the square root of the rounding.
        """
        kappa = np.abs(self.eigenvalues) ** 2
        floor = np.maximum(np.abs(self.eigenvalues), np.finfo(float).tiny)
        error = np.maximum(self.residuals, np.finfo(float).eps) * self.conditions * kappa
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
