"""Classification of modes and runs: unstable, grows slowly, stable, undecided, rigid.

Callers supply growth rates with their error: a run the algebraic error, a refinement sequence the
error bar, a reduced model the error bound.
"""

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cea.arrays import Complexes, Floats

Word = Literal["stable", "unstable", "undecided", "grows slowly", "rigid"]
RunWord = Literal[
    "unstable", "grows slowly", "undecided", "stable", "no unstable mode found", "no modes"
]

WORDS: tuple[Word, ...] = get_args(Word)
"""Classes of a mode; files of numbers store their indices in this list."""
BY_URGENCY: tuple[Word, ...] = ("unstable", "grows slowly", "undecided", "stable", "rigid")
"""The classes by urgency, the most urgent first."""
GROWING: tuple[Word, ...] = ("unstable", "grows slowly")
"""Classes of modes whose growth rate exceeds its error."""
RELATIVE_GROWTH = 1e-4
"""Default growth rate relative to abs(lambda) above which a mode counts as unstable."""


NO_GROWTH = 1e-9
"""Relative error of kappa up to which close eigenvalues count as one of higher multiplicity, and
not as a coalescence, whose errors are about the root of rounding. The growth rate is then at most
half of it relative to abs(lambda), far below the threshold."""


def thresholds(eigenvalues: Complexes, threshold: float | None = None) -> Floats:
    """Return growth rates (1/s) above which modes are unstable; None takes 1e-4 abs(lambda)."""
    if threshold is None:
        return RELATIVE_GROWTH * np.abs(eigenvalues)
    return np.full(len(eigenvalues), float(threshold))


def threshold_text(threshold: float | None) -> str:
    """Return the threshold as text."""
    return "threshold 1e-4 |lambda|" if threshold is None else f"threshold {threshold:g} 1/s"


def classify(
    growth: ArrayLike,
    error: ArrayLike,
    threshold: ArrayLike,
    bounded: ArrayLike,
    rigid: ArrayLike = False,
) -> list[Word]:
    """Classify each mode.

    A mode is unstable if its growth rate is above its error and above the threshold, and grows
    slowly if it is above its error alone. It is stable if its growth rate plus the error is zero or
    negative, or if it cannot grow. It is undecided otherwise.

    Parameters
    ----------
    growth
        Growth rates Re lambda (1/s), shape (n,).
    error
        Errors of the growth rates (1/s): infinite where nothing is known.
    threshold
        Growth rates (1/s) above which modes count as unstable; see :func:`thresholds`.
    bounded
        Modes that cannot grow owing to the structure of the problem (:func:`cannot_grow`).
    rigid
        Rigid body modes, whose lambda is zero within its error.
    """
    growth, error, threshold, bounded, rigid = np.broadcast_arrays(
        *map(np.atleast_1d, (growth, error, threshold, bounded, rigid))
    )
    conditions = [
        rigid.astype(bool),
        growth > np.maximum(error, threshold),
        growth > error,
        bounded.astype(bool) | (growth + error <= 0),
    ]
    found: list[Word] = np.select(
        conditions, ["rigid", "unstable", "grows slowly", "stable"], "undecided"
    ).tolist()
    return found


def cannot_grow(kappa: Complexes, errors: Floats, *, symmetric: bool) -> NDArray[np.bool_]:
    """Return which undamped modes have zero growth by the structure of the problem, shape (n,).

    kappa = -lambda^2 are eigenvalues of real matrices: one leaves the real axis only where it
    meets another. A real positive kappa therefore belongs to a mode that does not grow if it
    differs from all others by more than their errors, or if its error is too small for a
    coalescence (a multiple eigenvalue). Without friction the problem is symmetric, and all kappa
    are real. With rotation, but neither friction nor damping, the same holds for -i lambda.
    """
    real = (np.abs(kappa.imag) <= errors) & (kappa.real > errors)
    if symmetric:
        return real
    distance = np.abs(kappa[:, None] - kappa)
    np.fill_diagonal(distance, np.inf)
    apart = (distance > errors[:, None] + errors).all(axis=1)
    fine = errors <= NO_GROWTH * np.abs(kappa)
    return np.asarray(real & (apart | fine))


def classify_run(words: Sequence[Word], *, complete: bool, missing: bool = False) -> RunWord:
    """Classify a whole window by the classes of its modes.

    The window is ``complete`` if all modes were found, whatever their growth rates; ``missing``
    means that a mode is known to be missing.
    """
    for word in ("unstable", "grows slowly", "undecided"):
        if word in words:
            return word
    if missing:
        return "undecided"
    if not words:
        return "no modes"
    return "stable" if complete else "no unstable mode found"


def counted_words(words: Sequence[Word], growth: Sequence[float], threshold: float | None) -> str:
    """Return the number of modes of each class, the largest growth rates, and the threshold."""
    parts = []
    for word in BY_URGENCY:
        rates = [rate for rate, own in zip(growth, words, strict=True) if own == word]
        if not rates:
            continue
        part = f"{len(rates)} {word}"
        if word == "grows slowly":
            part = f"{len(rates)} modes grow slowly" if len(rates) > 1 else "1 mode grows slowly"
        if word in GROWING:
            part += f" (fastest {max(rates):+.3g} 1/s)"
        parts.append(part)
    return f"{', '.join(parts)}; {threshold_text(threshold)}"
