"""How probable growth is by samples, with what the samples leave open.

Of n samples k surely grow and u more are undecided. The interval of 95 per cent reaches from the
lower end of that of k to the upper end of that of k + u (E. B. Wilson, Probable inference, the law
of succession, and statistical inference, J. Amer. Statist. Assoc. 22 (1927)).
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
_NEAR = 0.05
"""Distance, relative to a speed, that counts as much as another vector."""
_LIKE = 0.5
"""Least squared cosine, less the distance, of modes that are one."""
_FOLLOWED = 0.1
"""Part of the samples whose growing modes may be unknown for single modes to have rows."""


def continued(middle: ReducedSpectrum, found: ReducedSpectrum) -> Ints:
    """Numbers of the modes of another spectrum that modes are by shape and eigenvalue, -1 of none.

    Vectors of two that coalesce become one: the space of both is compared.
    """
    numbers = np.full(len(found), -1, dtype=np.int64)
    if not (len(middle) and len(found)):
        return numbers
    one, other = (each.right / np.linalg.norm(each.right, axis=0) for each in (middle, found))
    likeness = np.abs(one.conj().T @ other) ** 2
    away = np.abs(middle.eigenvalues[:, None] - found.eigenvalues) / found.speeds
    cost = 1 - likeness + np.minimum(away / _NEAR, 10.0)
    for i, j in zip(*(each.tolist() for each in assign(cost, 1.0 + _LIKE)), strict=True):
        numbers[j] = i
    return numbers


def growing(spectra: Spectra, threshold: float | None, *, damped: bool) -> tuple[Flags, Flags]:
    """Which modes grow, surely and perhaps, shape (points, modes).

    Of two that coalesced without damping, one growing as the other decays, both do.
    """
    values = np.where(spectra.there, spectra.growth + 2j * np.pi * spectra.frequency, 0.0)
    limits = thresholds(values.ravel(), threshold).reshape(values.shape)
    rates = spectra.growth if damped else np.abs(spectra.growth)
    errors = spectra.uncertainty
    return rates > np.maximum(errors, limits), rates + errors > limits


def probability(grows: Flags, may_grow: Flags, growth: Floats) -> dict[str, Any]:
    """What samples say of growth, sure or perhaps, with rates (1/s), each of shape (n,)."""
    from scipy.stats import binomtest

    n, sure = len(grows), int(grows.sum())
    undecided = int((may_grow & ~grows).sum())
    share, rates = sure / n, growth[grows]
    spread = np.quantile(rates, _QUANTILES).tolist() if len(rates) else [None] * 3
    return {
        "grows": sure,
        "undecided": undecided,
        "probability": share,
        "standard_error": float(np.sqrt(share * (1 - share) / n)),
        "low": float(binomtest(sure, n).proportion_ci(method="wilson").low),
        "high": float(binomtest(sure + undecided, n).proportion_ci(method="wilson").high),
        "growth": dict(zip(("low", "median", "high"), spread, strict=True)),
        "fastest": float(rates.max()) if len(rates) else None,
    }


def probabilities(spectra: Spectra, threshold: float | None, *, damped: bool) -> dict[str, Any]:
    """What all samples say of growth, and of that of each mode where nearly all are followed."""
    grows, may_grow = growing(spectra, threshold, damped=damped)
    rates = np.abs(np.where(grows, spectra.growth, 0.0))
    unknown = int((may_grow & (spectra.number < 0)).any(axis=1).sum())
    told: dict[str, Any] = {
        "any": probability(grows.any(axis=1), may_grow.any(axis=1), rates.max(axis=1, initial=0)),
        "not_followed": unknown,
        "modes": [],
    }
    if unknown >= _FOLLOWED * len(grows):
        return told
    for number in np.unique(spectra.number[may_grow & (spectra.number >= 0)]).tolist():
        own = (spectra.number == number) & spectra.there
        frequencies = spectra.frequency[own]
        told["modes"].append(
            {
                "mode": number,
                "frequency": float(np.median(frequencies)),
                "seen": int(own.any(axis=1).sum()),
                **probability(
                    (own & grows).any(axis=1),
                    (own & may_grow).any(axis=1),
                    np.where(own, rates, 0.0).max(axis=1),
                ),
            }
        )
    told["modes"].sort(key=lambda each: each["frequency"])
    return told
