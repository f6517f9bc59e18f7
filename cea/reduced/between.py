"""Spectra between neighbours on a line, for roots: on the span of the eigenvectors at both.

A root takes some twenty spectra between two values of a line. The eigenvectors at the two are a
basis for them that is a good deal smaller than that of the line; residuals are those of the whole
pencil still. Where its bounds are too large in the middle, the vectors of the middle are added.
"""

from collections.abc import Callable, Sequence

import numpy as np

from cea.arrays import Floats
from cea.reduced.pieces import Values
from cea.reduced.small import SmallPencil, columns_of
from cea.reduced.spectrum import ReducedSpectrum

_MIDDLES = (0.5, 0.25, 0.75)
"""Parts of an interval where its basis is tested, and whose vectors it takes in."""
_LESS = 0.7
"""Size of a basis relative to that of the line from which on it is not worth its making."""


class Between:
    """Spectra at values between neighbours on a line; those that were asked for are kept.

    Parameters
    ----------
    basis
        The basis of the line.
    values
        The neighbours, rising.
    spectra
        What is known there.
    parameters
        Values of all parameters at a value of the line.
    tolerance
        Error of lambda, relative to its speed, that a basis of an interval may make.
    """

    def __init__(
        self,
        basis: SmallPencil,
        values: Sequence[float],
        spectra: Sequence[ReducedSpectrum],
        parameters: Callable[[float], Values],
        tolerance: float,
    ) -> None:
        self._line, self._values, self._spectra = basis, np.asarray(values, dtype=float), spectra
        self._parameters, self._tolerance = parameters, tolerance
        self._known = dict(zip(values, spectra, strict=True))
        self._bases: dict[int, SmallPencil] = {}

    def __call__(self, value: float) -> ReducedSpectrum:
        """The spectrum at a value."""
        if value not in self._known:
            last = max(len(self._values) - 2, 0)
            interval = int(np.clip(np.searchsorted(self._values, value) - 1, 0, last))
            if interval not in self._bases:
                self._bases[interval] = self._basis_of(interval)
            self._known[value] = self._bases[interval].at(self._parameters(value))
        return self._known[value]

    def _basis_of(self, interval: int) -> SmallPencil:
        """A basis good enough for an interval; that of the line where no smaller one is."""
        ends = self._values[interval : interval + 2]
        if len(ends) < 2:
            return self._line
        parts = [self._coordinates(self._spectra[interval + i]) for i in range(2)]
        for part in _MIDDLES:
            vectors = np.hstack(parts)
            basis = self._line.local(vectors)
            if basis.size > _LESS * self._line.size:
                break
            middle = self._parameters(float(ends[0] + part * (ends[1] - ends[0])))
            if basis.at(middle).worst <= self._tolerance:
                return basis
            parts.append(self._coordinates(self._line.at(middle)))
        return self._line

    def _coordinates(self, found: ReducedSpectrum) -> Floats:
        """Real and imaginary parts of right and left vectors in the basis of the line."""
        right, left = found.right, found.left
        if self._line.axes is not None:
            right, left = self._line.axes.T @ right, self._line.axes.T @ left
        return columns_of(right, left)
