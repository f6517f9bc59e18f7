"""A reduced model along one of its parameters, as thresholds look at it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cea.reduced.following import Sample, Window
from cea.reduced.pieces import Values
from cea.reduced.small import SmallPencil


@dataclass(frozen=True)
class ModelLine:
    """Spectra of a reduced model along a line.

    Parameters
    ----------
    small
        The reduced model.
    bases
        Smaller bases for parts of the line, each with the least and the greatest value it is for.
    parameters
        Values of all parameters at a value of the line.
    rates
        How fast each parameter changes along it.
    level
        Growth rate (1/s) from which on a mode counts as growing.
    tolerance
        Error of lambda, relative to its speed, that a smaller basis may make.
    logarithmic
        Whether places on the line are logarithms of values.
    """

    small: SmallPencil
    bases: Sequence[tuple[float, float, SmallPencil]]
    parameters: Callable[[float], Values]
    rates: Mapping[str, float]
    level: float
    tolerance: float
    logarithmic: bool = False

    @property
    def window(self) -> Window:
        """What is looked at."""
        settings = self.small.settings
        return Window(settings.end, self.small.damped, self.level, settings.decay)

    def place(self, value: float) -> float:
        """Where a value is on the line."""
        return float(np.log(value)) if self.logarithmic else value

    def value(self, place: float) -> float:
        """The value at a place."""
        return float(np.exp(place)) if self.logarithmic else place

    def speed(self, place: float) -> float:
        """Derivative of the value in the place."""
        return self.value(place) if self.logarithmic else 1.0

    def at(self, value: float) -> Sample:
        """The spectrum at a place, with damping also its mirror image below the real axis."""
        place, at = value, self.parameters(self.value(value))
        basis = self._basis(place)
        found = basis.at(at)
        if found.worst > self.tolerance and basis is not self.small:
            basis = self.small
            found = basis.at(at)
        slopes = basis.slopes(found, at, self.rates) * self.speed(place)
        vectors = found.right / np.linalg.norm(found.right, axis=0)
        numbers, means = found.certificate.clusters, found.certificate.means
        if not self.small.damped:
            errors = found.certificate.errors
            return Sample(place, found.kappa, slopes, errors, means, numbers, vectors)
        values, errors, speeds = (
            found.eigenvalues,
            found.uncertainties,
            2 * np.abs(found.kappa) ** 0.5,
        )
        means = np.where(speeds > 0, means / np.maximum(speeds, np.finfo(float).tiny), errors)
        mirrored = np.flatnonzero(values.imag > 0)
        return Sample(
            place,
            np.concatenate([values, values[mirrored].conj()]),
            np.concatenate([slopes, slopes[mirrored].conj()]),
            np.concatenate([errors, errors[mirrored]]),
            np.concatenate([means, means[mirrored]]),
            np.concatenate([numbers, numbers.max(initial=0) + 1 + numbers[mirrored]]),
            np.hstack([vectors, vectors[:, mirrored].conj()]),
        )

    def _basis(self, place: float) -> SmallPencil:
        for low, high, basis in self.bases:
            if low <= place <= high:
                return basis
        return self.small
