"""What is kept between solves of one pencil: sums of matrices, inertia counts, factors."""

from collections.abc import Mapping

import numpy as np

from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.shifted import Shifted, count_below
from cea.errors import ConvergenceError

_NEARBY_STEPS = 3
"""Steps of refinement up to which factors of nearby parameters are worth keeping."""
_BESIDE = 0.997
"""Part of a shift that is an eigenvalue at which another is tried."""


class Kept:
    """Sums at the last parameters, factors at the last shift, and all that was ever counted.

    Parameters
    ----------
    pencil
        What is solved.

    Attributes
    ----------
    factorisations
        Factorisations made so far, inertia counts included.
    """

    def __init__(self, pencil: Pencil) -> None:
        self._pencil = pencil
        self.factorisations = 0
        self._counts: dict[tuple[float, ...], int] = {}
        self._summed: tuple[dict[str, float], Matrices] | None = None
        self._factors: Shifted | None = None
        self._at: tuple[Mapping[str, float], float] = ({}, np.nan)

    def free(self) -> None:
        """Free factors and sums; what was counted is kept."""
        self._free_factors()
        if self._summed is not None:
            release(self._summed[1])
            self._summed = None

    def matrices(self, values: dict[str, float]) -> Matrices:
        """The pencil at given values of all parameters."""
        if self._summed is None:
            self._summed = (values, self._pencil.at(values))
        elif self._summed[0] != values:
            before, matrices = self._summed
            self._summed = None  # an interruption leaves nothing that was freed
            self._summed = (values, self._pencil.moved(matrices, before, values))
        return self._summed[1]

    def count(self, matrices: Matrices, values: dict[str, float], upper: float) -> int:
        """Eigenvalues of the symmetric part below a kappa."""
        key = (*self._pencil.symmetric_values(values), upper)
        if key not in self._counts:
            self._counts[key] = count_below(matrices, upper)
            self.factorisations += 1
        return self._counts[key]

    def factorised(self, matrices: Matrices, values: dict[str, float], kappa: float) -> Shifted:
        """Factors at a shift, those of the last solve where they are the same."""
        known = self._factors is not None and self._factors.matrices is matrices
        if self._factors is None or not known or self._at != (values, kappa):
            self._free_factors()
            self._factors = Shifted(matrices, kappa)
            self._at = (values, kappa)
            self.factorisations += 1
        return self._factors

    def in_the_middle(self, matrices: Matrices, values: dict[str, float], kappa: float) -> Shifted:
        """Factors at a shift, or beside it where it is an eigenvalue."""
        try:
            return self.factorised(matrices, values, kappa)
        except ConvergenceError:
            return self.factorised(matrices, values, _BESIDE * kappa)

    def nearby(self, matrices: Matrices, values: dict[str, float], kappa: float) -> Shifted:
        """Factors at a shift, or those made there at parameters near enough, refined."""
        if self._factors is not None and self._at[1] == kappa and self._at[0] != values:
            refined = Shifted(matrices, kappa, near=self._factors)
            if refined.steps() <= _NEARBY_STEPS:
                return refined
            refined.free()
        return self.factorised(matrices, values, kappa)

    def moved(self, values: Mapping[str, float], kappa: float) -> None:
        """Take note that the factors are now those at another shift."""
        self._at = (values, kappa)

    def lost(self) -> None:
        """Take note that the factors may be those of nothing."""
        self._at = ({}, np.nan)

    def is_own(self, factors: Shifted) -> bool:
        """Whether factors are those that are kept."""
        return factors is self._factors

    def _free_factors(self) -> None:
        if self._factors is not None:
            self._factors.free()
            self._factors = None
