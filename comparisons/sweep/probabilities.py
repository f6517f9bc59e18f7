"""How probable growth is by samples, with what the samples leave open: the record of a study.

Of n samples k surely grow and u more are undecided. The interval of 95 per cent reaches from the
lower end of that of k to the upper end of that of k + u (E. B. Wilson, Probable inference, the law
of succession, and statistical inference, J. Amer. Statist. Assoc. 22 (1927)).
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from cea.arrays import Floats
from comparisons.sweep.filling import Filling
from comparisons.sweep.map_record import lost_to_rounding, of_full_solves, of_rounding
from comparisons.sweep.mapped import Mapped
from comparisons.sweep.sampled import Flags, Sampled

_STANDARD = 1.959963984540054
"""Standard deviations of an interval of 95 per cent."""
_QUANTILES = (0.05, 0.5, 0.95)
_NAMED = 100
"""Samples without a certificate that are named."""


def wilson(count: int, total: int) -> tuple[float, float]:
    """Interval of 95 per cent of a probability, of so many cases in all."""
    share, square = count / total, _STANDARD**2
    middle = (share + square / (2 * total)) / (1 + square / total)
    half = _STANDARD / (1 + square / total)
    half *= np.sqrt(share * (1 - share) / total + square / (4 * total**2))
    low = 0.0 if count == 0 else middle - half
    return float(low), 1.0 if count == total else float(middle + half)


def probability(grows: Flags, may_grow: Flags, growth: Floats) -> dict[str, Any]:
    """What samples say of growth.

    Parameters
    ----------
    grows, may_grow
        Whether there is growth in each sample, surely or perhaps, shape (n,).
    growth
        Its rate (1/s), shape (n,); not a number counts as none.
    """
    n, sure = len(grows), int(grows.sum())
    undecided = int((may_grow & ~grows).sum())
    share = sure / n
    rates = growth[grows & np.isfinite(growth)]
    spread = np.quantile(rates, _QUANTILES).tolist() if len(rates) else [None] * 3
    return {
        "grows": sure,
        "undecided": undecided,
        "probability": share,
        "standard_error": float(np.sqrt(share * (1 - share) / n)),
        "low": wilson(sure, n)[0],
        "high": wilson(sure + undecided, n)[1],
        "growth": dict(zip(("low", "median", "high"), spread, strict=True)),
        "fastest": float(rates.max()) if len(rates) else None,
    }


def record_of(
    scene: Mapped, filling: Filling, found: Sampled, tolerance: float, seconds: Mapping[str, float]
) -> dict[str, Any]:
    """Record of a study.

    Parameters
    ----------
    scene
        What was sampled.
    filling
        The basis it rests on.
    found
        Modes of the samples.
    tolerance
        Error of lambda, relative to its speed, up to which a sample is certified.
    seconds
        Processor seconds of this rank.
    """
    open_ = np.flatnonzero(found.bound > tolerance)
    largest = np.where(found.grows, found.growth, -np.inf).max(axis=1, initial=-np.inf)
    basis = filling.basis
    return {
        "fields": [
            {"name": each.name, "parameters": list(names), "ends": list(each.ends)}
            for each, names in zip(scene.axes, scene.names, strict=True)
        ],
        "unknowns": scene.pencil.terms[0].matrix.getSize()[0],
        "max_frequency": scene.max_frequency,
        "basis": basis.model.size,
        "snapshots": [each.plain() for each in basis.snapshots],
        "stored_before": filling.kept,
        "failed": [{"point": dict(point), "reason": why} for point, why in basis.failed],
        "samples": len(found.bound),
        "certified": len(found.bound) - len(open_),
        "lost_to_rounding": lost_to_rounding(found.bound, found.worst, tolerance),
        "not_certified": open_[:_NAMED].tolist(),
        "worst": float(found.bound.max()),
        "any": probability(found.grows.any(axis=1), found.may_grow.any(axis=1), largest),
        "modes": of_modes(found),
        "processor_seconds": dict(seconds),
    }


def of_modes(found: Sampled) -> list[dict[str, Any]]:
    """A record of each mode that may grow in any sample, by rising frequency.

    Modes that continue none are together, as one without a number.
    """
    made = []
    for number in np.unique(found.number[found.may_grow]).tolist():
        own = (found.number == number) & np.isfinite(found.frequency)
        grows, may_grow = (own & flags for flags in (found.grows, found.may_grow))
        rate = np.abs(np.where(grows, found.growth, 0.0)).max(axis=1)
        frequencies = found.frequency[own]
        made.append(
            {
                "mode": number if number >= 0 else None,
                "frequency": float(np.median(frequencies)),
                "frequency_low": float(frequencies.min()),
                "frequency_high": float(frequencies.max()),
                "seen": int(own.any(axis=1).sum()),
                **probability(grows.any(axis=1), may_grow.any(axis=1), rate),
            }
        )
    return sorted(made, key=lambda each: each["frequency"])


def warnings_of(data: Mapping[str, Any], tolerance: float) -> list[dict[str, Any]]:
    """What the samples must be read with."""
    found: list[tuple[str, str]] = []
    left = data["samples"] - data["certified"]
    if left:
        first = ", ".join(str(number) for number in data["not_certified"][:10])
        found.append(
            (
                "not-certified",
                f"{left} of {data['samples']} samples are not certified to {tolerance:g}, the "
                f"first of them {first}: their bounds say how far they may be off"
                f"{of_rounding(data['lost_to_rounding'])}",
            )
        )
    if data["any"]["undecided"]:
        found.append(
            (
                "undecided",
                f"of {data['any']['undecided']} samples it is not decided whether they grow: "
                "intervals reach as far as they would with and without these",
            )
        )
    for mode in data["modes"]:
        if mode["mode"] is None:
            grow = mode["grows"] + mode["undecided"]
            found.append(
                (
                    "not-followed",
                    f"in {grow} of {data['samples']} samples a mode grows, or may, that could not "
                    "be told to be one of the others: so much more probable may one of them be",
                )
            )
    if data["failed"]:
        found.append(("no-answer", f"{len(data['failed'])} full solves gave no answer"))
    told = [{"kind": kind, "message": message, "data": {}} for kind, message in found]
    return told + of_full_solves(data["snapshots"])
