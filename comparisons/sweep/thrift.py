"""Whether a basis pays: what it still takes beside a full solve at each value."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

_DECADES = 3.0
"""Decades that a full solve takes the worst bound down by, as long as no two bounds tell."""
_LEAST_DECADES = 0.5
"""The least that is expected of one, however little the last have brought."""
_PLAIN = 0.4
"""Least share that a full solve for its values alone takes of one for a basis: it reaches less far
and makes no left vectors."""
_IN_A_ROW = 0.3
"""Part of the time of a value on the whole basis that one takes in a row of them."""
_WORTH = 20.0
"""Processor seconds to be saved, less than which what a map tells more is worth."""


class BasisTooDearError(Exception):
    """Full solves at all values are cheaper than a basis; the message says by how much."""


@dataclass
class Thrift:
    """Weighs a basis while it is made.

    Parameters
    ----------
    values
        Values of the sweep.
    goal
        Bound that the basis is to reach.
    checks
        Full solves that test it in the end.
    plain
        Solves in full for values alone; gives processor seconds, the same on every rank.
    """

    values: int
    goal: float
    checks: int
    plain: Callable[[], float]
    _bounds: list[float] = field(default_factory=list, init=False)
    _measured: float | None = field(default=None, init=False)

    def weigh(self, worst: float, solves: int, full: float, basis: float, value: float) -> None:
        """Give a basis up before its next full solve, or go on.

        Parameters
        ----------
        worst
            The bound where that solve is to be.
        solves
            Full solves that were timed.
        full, basis
            Processor seconds of these, and of what was made of them.
        value
            Of a value on the whole basis.

        Raises
        ------
        BasisTooDearError
            When full solves at all values are cheaper.
        """
        if not solves or not np.isfinite(worst):
            return
        self._bounds.append(worst)
        left = self._left(worst) + self.checks
        rest = left * (full + basis) / solves + _IN_A_ROW * self.values * value
        if rest < _PLAIN * self.values * full / solves + _WORTH:
            return
        if self._measured is None:
            self._measured = self.plain()
        each = self.values * self._measured
        if rest > each + _WORTH:
            raise BasisTooDearError(
                f"{self.values} full solves take about {each:.0f} s of processor time; a basis for "
                f"them would take about {rest:.0f} s, for {left} more full solves and what is made "
                "of them"
            )

    def _left(self, worst: float) -> int:
        """Full solves until the bound is reached, by how fast bounds fell."""
        meant = [bound for bound in self._bounds if bound < 1.0]
        fell = _DECADES
        if len(meant) > 1:
            fell = max(np.log10(meant[0] / meant[-1]) / (len(meant) - 1), _LEAST_DECADES)
        return max(int(np.ceil(np.log10(worst / self.goal) / fell)), 1)
