"""The words of modes of a reduced model, whose errors are its bounds."""

import numpy as np

from cea.eigen.classify import Word, cannot_grow, classify, thresholds
from cea.reduced.spectrum import ReducedSpectrum


def words_of(found: ReducedSpectrum, threshold: float | None) -> list[Word]:
    """A word for each mode.

    Parameters
    ----------
    found
        Modes with their bounds.
    threshold
        Growth rate (1/s) above which a mode is called unstable; None where it is relative.
    """
    eigenvalues, bounds = found.eigenvalues, found.uncertainties
    bounded = np.zeros(len(eigenvalues), dtype=bool)
    if found.settings.decay == np.inf:
        bounded = cannot_grow(found.kappa, found.certificate.errors, symmetric=False)
    limits, rigid = thresholds(eigenvalues, threshold), np.abs(eigenvalues) <= bounds
    return classify(eigenvalues.real, bounds, limits, bounded, rigid)
