"""Bands of neighbouring rows that share a local basis: few of their values are solved on the whole.

A row asks its basis for some ten values, however many it has; on the basis of its band these cost a
tenth of what they cost on the whole one.
"""

from collections.abc import Sequence

import numpy as np

from cea.reduced.rows import along
from cea.reduced.small import SmallPencil
from comparisons.sweep.mapped import Mapped

_MOST = 6
"""Rows of a band."""
_WIDE = 10.0
"""Ratio of a stiffness that a band spans at most: its vectors are of one energy norm."""
_SEEN = 5
"""Values of a row at which a basis is tested."""


class Bands:
    """The basis of the band that a row is in; that of the last row is kept.

    Parameters
    ----------
    scene
        What is mapped.
    tolerance
        Error of lambda, relative to its speed, that local bases may make.
    """

    def __init__(self, scene: Mapped, tolerance: float) -> None:
        self._scene, self._tolerance = scene, tolerance
        self._rows = scene.rows()
        self._last: tuple[range, SmallPencil, SmallPencil] | None = None

    def of(self, number: int, small: SmallPencil) -> SmallPencil:
        """The basis for a row, given the whole one, which it is where no other holds."""
        if self._last is None or number not in self._last[0] or self._last[1] is not small:
            band = self._band(number, small)
            self._last = band, small, self._basis(band, small)
        return self._last[2]

    def give_up(self) -> None:
        """Solve the other rows of the last band on the whole basis: its own does not hold."""
        if self._last is not None:
            band, small, _ = self._last
            self._last = band, small, small

    def _band(self, number: int, small: SmallPencil) -> range:
        """Numbers of the rows from one on that are together."""
        stiff: list[list[float]] = []
        for row in self._rows[number : number + _MOST]:
            stiff.append(small.stiffness(self._at(0.0, row)))
            sizes = np.array(stiff)
            if (sizes.max(axis=0) > _WIDE * sizes.min(axis=0)).any():
                return range(number, number + len(stiff) - 1)
        return range(number, number + len(stiff))

    def _basis(self, band: range, small: SmallPencil) -> SmallPencil:
        if len(band) == 1:
            return small
        rows = [self._rows[i] for i in sorted({band[0], band[len(band) // 2], band[-1]})]
        parts = np.linspace(0.0, 1.0, _SEEN)
        line = [self._at(part, row) for row in rows for part in parts]
        return along(small, line, self._tolerance).basis

    def _at(self, part: float, others: Sequence[float]) -> dict[str, float]:
        """Values of all parameters at a part of the first axis, on a row."""
        values = self._scene.axes[0].values
        value = values[round(part * (len(values) - 1))]
        return self._scene.pencil.values(self._scene.point((value, *others)))
