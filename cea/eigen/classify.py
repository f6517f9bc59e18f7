"""The words of modes and runs: unstable, grows slowly, stable, undecided, rigid.

This is the only place that decides them. Whoever has growth rates brings the error that is its
own: a run its algebraic error, a refined scene its error bar, a reduced model its bound.
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
"""Words of a mode; files of numbers hold their places in this list."""
BY_URGENCY: tuple[Word, ...] = ("unstable", "grows slowly", "undecided", "stable", "rigid")
"""The same, what matters most first."""
GROWING: tuple[Word, ...] = ("unstable", "grows slowly")
"""Words of modes that grow beyond their errors."""
RELATIVE_GROWTH = 1e-4
"""Growth rate relative to abs(lambda) above which a mode is called unstable by default."""


NO_GROWTH = 1e-9
"""Relative error of kappa up to which copies count as copies and not as a coalescence, whose errors
are about the root of rounding. Growth is then at most half of it relative to abs(lambda), far below
the threshold of a mode."""


def thresholds(eigenvalues: Complexes, threshold: float | None = None) -> Floats:
    """Growth rates (1/s) above which modes are called unstable; None takes 1e-4 abs(lambda)."""
    if threshold is None:
        return RELATIVE_GROWTH * np.abs(eigenvalues)
    return np.full(len(eigenvalues), float(threshold))


def threshold_text(threshold: float | None) -> str:
    """The threshold in words."""
    return "threshold 1e-4 |lambda|" if threshold is None else f"threshold {threshold:g} 1/s"


def classify(
    growth: ArrayLike,
    error: ArrayLike,
    threshold: ArrayLike,
    bounded: ArrayLike,
    rigid: ArrayLike = False,
) -> list[Word]:
    """A word for each mode.

    Unstable is a mode whose growth is above its error and above the threshold; it grows slowly
    where it is above its error alone. Stable is one whose growth is zero or less whatever its
    error. What the error leaves open is undecided.

    Parameters
    ----------
    growth
        Growth rates Re lambda (1/s), shape (n,).
    error
        Their errors (1/s): infinite where nothing is known.
    threshold
        Growth rates (1/s) above which modes are called unstable; see :func:`thresholds`.
    bounded
        Modes that cannot grow for the structure of the problem (:func:`cannot_grow`).
    rigid
        Modes whose lambda is zero but for rounding: nothing holds their motion.
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
    """Modes of a problem without damping whose growth is zero by structure, shape (n,).

    kappa = -lambda^2 are eigenvalues of real matrices: one leaves the real axis only where it
    meets another. So a real positive kappa that is apart from all others by more than their errors
    belongs to a mode that does not grow; and so do copies whose conditions are fine, which no
    coalescence has. Without friction all kappa are real: the problem is symmetric. With rotation
    alone, neither friction nor damping, the same holds of -i lambda.
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
    """The word of a whole window, by those of its modes.

    It is complete where all modes were found, however fast they grow; some may be known to be
    missing.
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
    """How many modes have each word, the fastest that grows, and the threshold that decided."""
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
