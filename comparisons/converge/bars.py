"""The error of the last number of a sequence, from the sequence itself.

Numbers q_k stand at positions t_k, logarithms of the error that theory takes off. An error
C exp(-eta t) has differences of neighbours that say eta: 1 where theory holds, less where the
solution is less smooth than theory supposes. The error of the last number is then

    |q_L - q_(L-1)| / (exp(eta (t_L - t_(L-1))) - 1)

which is Richardson's extrapolation. Where differences do not fall as any credible eta says, the
error is taken to be the largest of the last differences, or what theory makes of it where a step
takes off less than half.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, log

import numpy as np
from scipy.optimize import brentq

LEAST = 0.3
"""Least credible eta: below it nothing says that the sequence converges."""
MOST = 0.9
"""Largest eta that is made use of: what falls faster leaves another part behind, and on meshes that
are still coarse theory takes off more than finer elements do."""
SAFETY = 4.0
"""Factor on Richardson's error."""
_UNMEASURED, _SHOWN = 3.0, 4
"""Factor on errors of which no parts were measured, until so many meshes show how they fall: a
coarse step may take off another part than the one before, and leave more than either says."""
_BY_OTHERS = 2.0
"""Factor on Richardson's error where the window shows how errors fall and a number itself cannot,
having two: of modes that meet others on a coarse mesh, which have no such numbers there."""
_TRUSTED = log(40.0)
"""Most that a last step is trusted to have taken off, as a logarithm: what fell by more may have
left another part behind."""
_LUCK = 0.3
"""Part of the difference that the whole window makes likely, below which one is taken for luck."""


@dataclass(frozen=True)
class Bar:
    """Error of the last number of a sequence.

    Parameters
    ----------
    size
        The error; infinite where the sequence has one number.
    rate
        eta, the observed order over that of theory; None where the sequence says none.
    """

    size: float
    rate: float | None


@dataclass(frozen=True)
class Usual:
    """Last difference of a number that is no luck.

    Parameters
    ----------
    size
        The difference.
    own
        Whether it is that expected of the number itself, as its error is known in its parts, and
        not of what numbers of this size have in the window.
    unmeasured
        Whether errors could not be measured in their parts: bars of few meshes are tripled then.
    left
        Error that is expected to be left, where it is known in its parts: those that the last step
        refined nothing of do not show in its difference.
    """

    size: float = 0.0
    own: bool = False
    unmeasured: bool = False
    left: float = 0.0

    def __mul__(self, factor: float) -> "Usual":
        return replace(self, size=self.size * factor, left=self.left * factor)


NO_USUAL = Usual()
"""Where nothing is known of it."""


def observed_rate(positions: Sequence[float], differences: Sequence[float]) -> float | None:
    """Rate eta of three numbers at three positions from their two differences.

    Parameters
    ----------
    positions
        t of the last three numbers, rising.
    differences
        Absolute differences of neighbours.

    Returns
    -------
    float or None
        None where the differences do not fall.
    """
    before, last = np.diff(positions[-3:])
    former, latter = differences[-2:]
    if latter == 0 or former == 0:
        return None

    def excess(eta: float) -> float:
        return float(np.expm1(eta * before) / -np.expm1(-eta * last) - former / latter)

    low, high = 1e-3, 10.0
    if excess(low) >= 0:
        return None
    return high if excess(high) <= 0 else float(brentq(excess, low, high))


def rate_of(values: Sequence[complex], positions: Sequence[float]) -> float | None:
    """Rate eta of a sequence's last three numbers; None where there are fewer or it shows none."""
    if len(values) < 3:
        return None
    return observed_rate(positions, np.abs(np.diff(values[-3:])).tolist())


def bar(
    values: Sequence[complex],
    positions: Sequence[float],
    typical: float | None,
    rounding: float = 0.0,
    usual: Usual = NO_USUAL,
) -> Bar:
    """Error of the last number of a sequence.

    Parameters
    ----------
    values
        Its numbers, coarsest mesh first.
    positions
        Their positions t, rising.
    typical
        eta of the window as a whole, beside which that of one mode may be luck; None where it is
        not known.
    rounding
        Error of each number by rounding, beside that of its mesh.
    usual
        Last difference that is no luck: of two numbers alone a smaller one is taken for luck, and
        of more one below a part of it. What a mode owes to something else than the others, as to
        the shape of curved cells, need not fall as theirs.
    """
    if len(values) < 2:
        return Bar(inf, None)
    differences = np.abs(np.diff(values))
    last = float(differences[-1])
    doubt = _UNMEASURED if usual.unmeasured and len(values) < _SHOWN else 1.0
    least = SAFETY * _LUCK * usual.left
    if len(values) < 3:
        size = doubt * _unseen([max(last, usual.size)], positions)
        if usual.own and typical is not None and typical >= LEAST:
            seen = max(last, _LUCK * usual.size)
            size = min(size, max(_BY_OTHERS * _richardson(seen, typical, positions), least))
        return Bar(float(size) + rounding, None)
    rate, former = rate_of(values, positions), float(differences[-2])
    if max(last, former) <= 2 * rounding:  # nothing but rounding is left to differ
        return Bar(max(last, former) + rounding, rate)
    if rate is None or rate < LEAST:
        return Bar(max(doubt * _unseen([former, last], positions), least) + rounding, rate)
    before, step = np.diff(positions[-3:])
    used = min(rate, MOST, MOST if typical is None else max(typical, LEAST))
    likely = usual.size
    if not usual.own:
        likely = max(likely, -former * float(np.expm1(-used * step) / np.expm1(used * before)))
    size = doubt * _richardson(max(last, _LUCK * likely), used, positions)
    return Bar(max(float(size), least) + rounding, rate)


def _richardson(last: float, rate: float, positions: Sequence[float]) -> float:
    """Richardson's error of a last difference at a rate, times what makes it safe."""
    step = min(rate, MOST) * (positions[-1] - positions[-2])
    return SAFETY * last / float(np.expm1(min(step, _TRUSTED)))


def _unseen(differences: list[float], positions: Sequence[float]) -> float:
    """Error where no order is seen: the largest difference, or what theory makes of it if more.

    A step that takes little off by theory changes little, however large the error is.
    """
    steps = np.diff(positions[-len(differences) - 1 :])
    return float(np.max(np.array(differences) * np.maximum(1.0, 1 / np.expm1(steps))))


def typical_rate(rates: Sequence[float | None]) -> float | None:
    """Median of the rates that are credible; None where there is none."""
    known = [min(rate, MOST) for rate in rates if rate is not None and isfinite(rate)]
    return float(np.median(known)) if known else None
