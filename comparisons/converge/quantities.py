"""What of a cluster of modes converges, and what that says of its members.

Without damping a pair of modes has the numbers lambda^2 = m + sqrt(s) and m - sqrt(s). Mean m and
squared splitting s depend smoothly on everything, through a coalescence too, where the members do
not: s > 0 are two modes that do not grow, s < 0 a growing and a decaying one. So m and s are what
is followed from mesh to mesh, and the members are made of them.
"""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from cea.eigen.spectrum import Verdict
from comparisons.converge.bars import Bar, bar
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
        Sign of its growth, as far as the bars decide it.
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
    verdict: Verdict
    rate: float | None
    levels: int
    rigid: bool = False


def members_of(
    cluster: Cluster, sequence: Sequence, window: Window, *, damped: bool, grows: bool
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
    """
    history = history_of(cluster, sequence)
    if history.rigid:
        return _rigid(history)
    if damped:
        return _each(history, window, of_squares=False)
    if not grows:
        return _each(history, window, of_squares=True)
    if len(cluster.newest) == 2:
        return _pair(history, window)
    return _undamped(history, window)


def _rigid(history: History) -> list[Member]:
    """Motions that nothing holds: every mesh has them, and lambda = 0 but for rounding."""
    bars = np.abs(history.values[-1]) + history.rounding
    return [
        Member(complex(value), bar, bar, "stable", None, len(history.values), rigid=True)
        for value, bar in zip(history.values[-1], bars.tolist(), strict=True)
    ]


def _each(history: History, window: Window, *, of_squares: bool) -> list[Member]:
    """Members one by one; undamped and without friction none of them grows."""
    found = []
    for column, rounding in zip(history.values.T, history.rounding, strict=True):
        value, count = complex(column[-1]), len(column)
        usual = history.usual(window) * abs(value)
        frequency = bar(column.imag.tolist(), history.positions, window.rate, rounding, usual)
        if of_squares:
            found.append(
                Member(1j * value.imag, frequency.size, 0.0, "stable", frequency.rate, count)
            )
            continue
        growth = bar(column.real.tolist(), history.positions, window.rate, rounding, usual)
        verdict = sign_of(value.real, growth.size)
        found.append(Member(value, frequency.size, growth.size, verdict, frequency.rate, count))
    return found


def _undamped(history: History, window: Window) -> list[Member]:
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
        if alone and still and np.isfinite(error):
            member = Member(value, error, 0.0, "stable", squares.rate, len(column))
        else:
            verdict = sign_of(value.real, error)
            member = Member(value, error, error, verdict, squares.rate, len(column))
        found.append(member)
    return found


def sign_of(growth: float, error: float) -> Verdict:
    """Whether a growth rate is above zero, below it, or either."""
    if growth > error:
        return "unstable"
    return "stable" if growth < -error else "undecided"


def _root_error(square: complex, error: float) -> float:
    """Error of lambda from that of lambda^2: half of it relative, or its root."""
    size = abs(square)
    if not np.isfinite(error):
        return inf
    return sqrt(size) - sqrt(size - error) if error < size else sqrt(size + error)


def _pair(history: History, window: Window) -> list[Member]:
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
    apart = sqrt(abs(last))
    error = _root_error(last, of_splitting.size)
    if abs(last) <= of_splitting.size:
        verdicts: tuple[Verdict, Verdict] = ("undecided", "undecided")
    elif last > 0:
        verdicts = ("stable", "stable")
    else:
        verdicts = ("unstable", "stable")
    members = []
    values = history.values[-1]
    for value in values:
        verdict = verdicts[0] if value.real >= 0 else verdicts[1]
        members.append(_of_pair(complex(value), of_mean, of_splitting, (apart, error), verdict))
    return [
        Member(m.value, m.frequency_bar, m.growth_bar, m.verdict, m.rate, len(history.positions))
        for m in members
    ]


def _of_pair(
    value: complex,
    of_mean: Bar,
    of_splitting: Bar,
    splitting: tuple[float, float],
    verdict: Verdict,
) -> Member:
    """A member of a pair: lambda^2 = m +- sqrt(s), so 2 lambda dlambda = dm +- d sqrt(s)."""
    _, error = splitting
    speed = max(abs(value), np.finfo(float).tiny)
    by_mean, by_splitting = of_mean.size / (2 * speed), error / (2 * speed)
    rates = [rate for rate in (of_mean.rate, of_splitting.rate) if rate is not None]
    rate = min(rates, default=None)
    undecided = verdict == "undecided"
    if undecided:
        return Member(value, by_mean + by_splitting, by_splitting, verdict, rate, 0)
    if value.real == 0:
        return Member(value, by_mean + by_splitting, 0.0, verdict, rate, 0)
    # Of a pair that flutters lambda = (g + i w): m = g^2 - w^2, sqrt(-s) = 2 g w.
    growth, frequency = abs(value.real), abs(value.imag)
    of_frequency = (frequency * of_mean.size + growth * error) / (2 * speed**2)
    of_growth = (frequency * error + growth * of_mean.size) / (2 * speed**2)
    return Member(value, of_frequency, of_growth, verdict, rate, 0)
