"""Spectra between neighbours on a line, for roots: few on the basis of the line, many on a pair."""

from collections.abc import Callable, Sequence

from cea.arrays import Floats
from cea.reduced.pieces import Values
from cea.reduced.roots import Spectra
from cea.reduced.rows import Line
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum

_LEFT_OUT = 1e-10
"""Part of the vectors of a pair that their basis leaves out."""


class Between:
    """Spectra at values between neighbours on a line; those that were asked for are kept.

    Parameters
    ----------
    small
        The reduced model.
    line
        What is known of the line.
    values
        Values of the parameter along it.
    parameters
        Values of all parameters at a value of the line.
    tolerance
        Error of lambda, relative to its speed, that the basis of the line may make.
    """

    def __init__(
        self,
        small: SmallPencil,
        line: Line,
        values: Sequence[float],
        parameters: Callable[[float], Values],
        tolerance: float,
    ) -> None:
        self._small, self._basis = small, line.basis
        self._parameters, self._tolerance = parameters, tolerance
        self._known = dict(zip(values, line.spectra, strict=True))

    def __call__(self, value: float) -> ReducedSpectrum:
        """The spectrum at a value."""
        if value not in self._known:
            at = self._parameters(value)
            found = self._basis.at(at)
            if found.worst > self._tolerance and self._basis is not self._small:
                found = self._small.at(at)
            self._known[value] = found
        return self._known[value]

    def on(self, vectors: Floats) -> Spectra:
        """Spectra on the span of some vectors of the whole basis."""
        basis = self._basis.local(self._basis.coordinates(vectors), tolerance=_LEFT_OUT)
        return lambda value: basis.at(self._parameters(value))
