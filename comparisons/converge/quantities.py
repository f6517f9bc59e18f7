"""What of a cluster of modes converges, and what that says of its members.

Without damping a pair of modes has the numbers lambda^2 = m + sqrt(s) and m - sqrt(s). Mean m and
squared splitting s depend smoothly on everything, through a coalescence too, where the members do
not: s > 0 are two modes that do not grow, s < 0 a growing and a decaying one. So m and s are what
is followed from mesh to mesh, and the members are made of them.
"""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from cea.eigen.classify import Word, classify, thresholds
from comparisons.converge.bars import bar
from comparisons.converge.following import Cluster, Sequence
from comparisons.converge.histories import History, Window, history_of

_ROUNDING = 10.0
"""Rounding of the mean of a pair relative to its residual."""


@dataclass(frozen=True)
class Member:
    """One mode with its error bar.

    Parameters
    ----------
    value
        lambda (1/s).
    frequency_bar, growth_bar
        Errors of Im lambda and of Re lambda (1/s).
    verdict
        Its word, with the bar of its growth as error (:func:`cea.eigen.classify.classify`).
    rate
        Observed order over that of theory; None where none is seen.
    levels
        Meshes that it was followed over.
    rigid
        Whether it is a motion that nothing holds: lambda is zero to its rounding on every mesh.
    """

    value: complex
    frequency_bar: float
    growth_bar: float
    verdict: Word
    rate: float | None
    levels: int
    rigid: bool = False


def members_of(
    cluster: Cluster,
    sequence: Sequence,
    window: Window,
    *,
    damped: bool,
    grows: bool,
    threshold: float | None = None,
) -> list[Member]:
    """The modes of a cluster with their bars, in the order of :attr:`Cluster.newest`.

    Parameters
    ----------
    cluster
        The cluster.
    sequence
        The levels.
    window
        What all modes show together.
    damped
        Whether lambda itself is followed, not its square.
    grows
        Whether anything can grow: something damps, rotates or rubs.
    threshold
        Growth rate (1/s) above which a mode is called unstable; None takes 1e-4 of abs(lambda).
    """
    history = history_of(cluster, sequence)
    if history.rigid:
        return _rigid(history)
    if damped:
        return _each(history, window, threshold, of_squares=False)
    if not grows:
        return _each(history, window, threshold, of_squares=True)
    if len(cluster.newest) == 2:
        return _pair(history, window, threshold)
    return _undamped(history, window, threshold)


def _rigid(history: History) -> list[Member]:
    """Motions that nothing holds: every mesh has them, and lambda = 0 but for rounding."""
    bars = np.abs(history.values[-1]) + history.rounding
    return [
        Member(complex(value), bar, bar, "rigid", None, len(history.values), rigid=True)
        for value, bar in zip(history.values[-1], bars.tolist(), strict=True)
    ]


def _each(
    history: History, window: Window, threshold: float | None, *, of_squares: bool
) -> list[Member]:
    """Members one by one; undamped and without friction none of them grows."""
    found = []
    for column, rounding in zip(history.values.T, history.rounding, strict=True):
        value, count = complex(column[-1]), len(column)
        usual = history.usual(window) * abs(value)
        frequency = bar(column.imag.tolist(), history.positions, window.rate, rounding, usual)
        if of_squares:
            value = 1j * value.imag
            word = _word(value, 0.0, threshold, bounded=True)
            found.append(Member(value, frequency.size, 0.0, word, frequency.rate, count))
            continue
        growth = bar(column.real.tolist(), history.positions, window.rate, rounding, usual)
        word = _word(value, growth.size, threshold)
        found.append(Member(value, frequency.size, growth.size, word, frequency.rate, count))
    return found


def _undamped(history: History, window: Window, threshold: float | None) -> list[Member]:
    """Members of clusters other than pairs, by their lambda^2.

    One alone is stable: without damping a mode grows only beside a partner that decays. Where more
    than two meet, only bars of growth that do not hold zero decide. Without a bar none is alone.
    """
    alone, found = history.values.shape[1] == 1, []
    for column, rounding in zip(history.values.T, history.rounding, strict=True):
        value = complex(column[-1])
        size = max(abs(value), abs(rounding))
        squares = bar(
            (column**2).tolist(),
            history.positions,
            window.rate,
            2 * size * rounding + rounding**2,
            history.usual(window) * 2 * abs(value) ** 2,
        )
        error = _root_error(value**2, squares.size)
        still = bool(np.all(column.real == 0))
        bounded = bool(alone and still and np.isfinite(error))
        word = _word(value, error, threshold, bounded=bounded)
        of_growth = 0.0 if bounded else error
        found.append(Member(value, error, of_growth, word, squares.rate, len(column)))
    return found


def _word(value: complex, bar: float, threshold: float | None, *, bounded: bool = False) -> Word:
    """The word of one mode whose growth has an error bar."""
    limits = thresholds(np.array([value]), threshold)
    return classify(value.real, bar, limits, bounded)[0]


def _root_error(square: complex, error: float) -> float:
    """Error of lambda from that of lambda^2: half of it relative, or its root."""
    size = abs(square)
    if not np.isfinite(error):
        return inf
    return sqrt(size) - sqrt(size - error) if error < size else sqrt(size + error)


def _pair(history: History, window: Window, threshold: float | None) -> list[Member]:
    """A pair by its mean and its squared splitting."""
    squares = history.values**2
    mean = squares.mean(axis=1)
    splitting = (0.25 * (squares[:, 0] - squares[:, 1]) ** 2).real
    last_mean, last = float(mean[-1].real), float(splitting[-1])
    size, rounding = abs(last_mean), float(history.rounding.max())
    of_member = 2 * sqrt(size) * rounding + rounding**2
    of_mean = bar(
        mean.real.tolist(),
        history.positions,
        window.rate,
        min(of_member, _ROUNDING * history.residual * size + np.finfo(float).eps * size),
        history.usual(window) * 2 * size,
    )
    of_splitting = bar(
        splitting.tolist(),
        history.splitting_positions,
        window.rate,
        2 * sqrt(abs(last)) * of_member + of_member**2,
        history.usual_splitting(window) * 4 * size * sqrt(abs(last)),
    )
    error = _root_error(last, of_splitting.size)
    rate = min((r for r in (of_mean.rate, of_splitting.rate) if r is not None), default=None)
    members = []
    for value in history.values[-1].tolist():
        of_frequency, of_growth = _bars_of_member(value, of_mean.size, error)
        is_open = abs(last) <= of_splitting.size
        if is_open:  # the sign of the splitting is not known: nothing is known of growth
            speed = max(abs(value), np.finfo(float).tiny)
            of_frequency, of_growth = (of_mean.size + error) / (2 * speed), error / (2 * speed)
        still = not is_open and value.real == 0
        word = _word(value, inf if is_open else of_growth, threshold, bounded=still)
        members.append(Member(value, of_frequency, of_growth, word, rate, len(history.positions)))
    return members


def _bars_of_member(value: complex, of_mean: float, of_root: float) -> tuple[float, float]:
    """Bars of Im and Re lambda, lambda^2 = m +- sqrt(s), from those of m and of sqrt(s)."""
    growth, frequency = abs(value.real), abs(value.imag)
    speed = max(abs(value), np.finfo(float).tiny)
    if growth == 0:
        return (of_mean + of_root) / (2 * speed), 0.0
    if frequency == 0:
        return 0.0, (of_mean + of_root) / (2 * speed)
    # Of a pair that flutters lambda = (g + i w): m = g^2 - w^2, sqrt(-s) = 2 g w.
    return (
        (frequency * of_mean + growth * of_root) / (2 * speed**2),
        (frequency * of_root + growth * of_mean) / (2 * speed**2),
    )
