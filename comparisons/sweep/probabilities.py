"""Probability of growth from samples, some of which may be undecided.

Of n samples k are certain to grow and u more are undecided. The 95 per cent confidence interval
extends from the lower end of that of k to the upper end of that of k + u (E. B. Wilson, Probable
inference, the law of succession, and statistical inference, J. Amer. Statist. Assoc. 22 (1927)).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.eigen.classify import thresholds
from cea.eigen.matching import assign
from cea.reduced.spectrum import ReducedSpectrum
from comparisons.sweep.spectra import Spectra

Flags = NDArray[np.bool_]
_QUANTILES = (0.05, 0.5, 0.95)
_ALIKE = 0.25
"""Least squared cosine of the vectors of matched modes (MAC); it is 0.5 between each of two modes
that coalesce and both modes that arise."""
_FOLLOWED = 0.1
"""Fraction of samples with unmatched growing modes from which on single modes have no rows."""


def continued(middle: ReducedSpectrum, found: ReducedSpectrum) -> Ints:
    """Return, for each mode of ``found``, the index of its match in ``middle``; -1 without one.

    Modes are matched by shape alone, since a softer body changes all frequencies at once.
    """
    one, other = (each.right / np.linalg.norm(each.right, axis=0) for each in (middle, found))
    rows, columns = assign(1 - np.abs(one.conj().T @ other) ** 2, 1 - _ALIKE)
    numbers = np.full(len(found), -1, dtype=np.int64)
    numbers[columns] = rows
    return numbers


def growing(spectra: Spectra, threshold: float | None, *, damped: bool) -> tuple[Flags, Flags]:
    """Return which modes are certain to grow, and which may grow, shape (points, modes).

    After an undamped coalescence both modes of the pair count as growing.
    """
    values = np.where(spectra.there, spectra.growth + 2j * np.pi * spectra.frequency, 0.0)
    limits = thresholds(values.ravel(), threshold).reshape(values.shape)
    rates = spectra.growth if damped else np.abs(spectra.growth)
    errors = spectra.uncertainty
    return rates > np.maximum(errors, limits), rates + errors > limits


def probability(grows: Flags, may_grow: Flags, rates: Floats) -> dict[str, Any]:
    """Return the statistics of growth over samples; all arrays have the shape (samples, modes).

    ``grows`` and ``may_grow`` mark the growing modes, ``rates`` are growth rates (1/s).
    """
    from scipy.stats import binomtest

    certain = grows.any(axis=1)
    n, sure = len(certain), int(certain.sum())
    undecided = int((may_grow.any(axis=1) & ~certain).sum())
    share, fastest = sure / n, np.where(grows, rates, 0.0).max(axis=1, initial=0.0)[certain]
    spread = np.quantile(fastest, _QUANTILES).tolist() if sure else [None] * 3
    return {
        "grows": sure,
        "undecided": undecided,
        "probability": share,
        "standard_error": float(np.sqrt(share * (1 - share) / n)),
        "low": float(binomtest(sure, n).proportion_ci(method="wilson").low),
        "high": float(binomtest(sure + undecided, n).proportion_ci(method="wilson").high),
        "growth": dict(zip(("low", "median", "high"), spread, strict=True)),
        "fastest": float(fastest.max()) if sure else None,
    }


def probabilities(spectra: Spectra, threshold: float | None, *, damped: bool) -> dict[str, Any]:
    """Return the statistics of growth over all samples, and of each mode where most are matched."""
    grows, may_grow = growing(spectra, threshold, damped=damped)
    rates, modes = np.abs(spectra.growth), []
    unknown = int((may_grow & (spectra.number < 0)).any(axis=1).sum())
    numbers = np.unique(spectra.number[may_grow & (spectra.number >= 0)])
    for number in numbers.tolist() if unknown < _FOLLOWED * len(grows) else []:
        own = (spectra.number == number) & spectra.there
        about = {
            "mode": number,
            "frequency": float(np.median(spectra.frequency[own])),
            "seen": int(own.any(axis=1).sum()),
        }
        modes.append(about | probability(own & grows, own & may_grow, rates))
    return {
        "any": probability(grows, may_grow, rates),
        "not_followed": unknown,
        "modes": sorted(modes, key=lambda each: each["frequency"]),
    }
