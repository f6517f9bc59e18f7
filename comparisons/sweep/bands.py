"""Bands of neighbouring rows that share a local basis: few of their values are solved on the whole.

A row asks its basis for some ten values, however many it has; on the basis of its band these cost a
tenth of what they cost on the whole one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cea.reduced.pieces import Values
from cea.reduced.rows import SMALL, shared
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum
from comparisons.sweep.mapped import Mapped

_MOST = 6
"""Rows of a band."""
_WIDE = 10.0
"""Ratio of a stiffness that a band spans at most: its vectors are of one energy norm."""
_SEEN = 5
"""Values of a row that a basis is made of."""
_LESS = 0.8
"""Size of a basis relative to the whole one from which on it is not worth its making."""


@dataclass(frozen=True)
class _Band:
    """Rows, the reduced model as it was, with residuals as the band has them, and on its basis."""

    rows: range
    small: SmallPencil
    whole: SmallPencil
    basis: SmallPencil
    points: list[Values]
    spectra: list[ReducedSpectrum]


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
        self._last: _Band | None = None

    def of(self, number: int, small: SmallPencil) -> SmallPencil:
        """The basis for a row, given the whole one, which it is where no other holds."""
        if self._last is None or number not in self._last.rows or self._last.small is not small:
            self._last = self._made(self._band(number, small), small)
        return self._last.basis

    @property
    def whole(self) -> SmallPencil:
        """The whole basis with residuals measured where the last band is softest."""
        assert self._last is not None
        return self._last.whole

    def mend(self, number: int, values: Sequence[float]) -> None:
        """Take what there is at some values of a row of the last band into its basis."""
        assert self._last is not None
        last = self._last
        if last.basis is last.whole:
            return
        for value in values:
            point = self._scene.point((value, *self._rows[number]))
            last.points.append(self._scene.pencil.values(point))
            last.spectra.append(last.whole.at(last.points[-1]))
        self._last = replace(last, basis=self._basis(last.whole, last.points, last.spectra))

    def _band(self, number: int, small: SmallPencil) -> range:
        """Numbers of the rows from one on that are together."""
        stiff: list[list[float]] = []
        for row in self._rows[number : number + _MOST]:
            stiff.append(small.stiffness(self._at(0.0, row)))
            sizes = np.array(stiff)
            if (sizes.max(axis=0) > _WIDE * sizes.min(axis=0)).any():
                return range(number, number + len(stiff) - 1)
        return range(number, number + len(stiff))

    def _made(self, band: range, small: SmallPencil) -> "_Band":
        rows = [self._rows[i] for i in sorted({band[0], band[len(band) // 2], band[-1]})]
        parts = np.linspace(0.0, 1.0, _SEEN)
        points: list[Values] = [self._at(part, row) for row in rows for part in parts]
        # A stiffness may vary along rows too, and where it is least no end tells.
        along = np.linspace(0.0, 1.0, len(self._scene.axes[0].values))
        stiff = [small.stiffness(self._at(part, self._rows[i])) for i in band for part in along]
        whole = small.where(np.min(stiff, axis=0).tolist())
        if len(band) == 1 or small.contacts or small.size <= SMALL:
            return _Band(band, small, whole, whole, points, [])
        spectra = [whole.at(point) for point in points]
        basis = self._basis(whole, points, spectra)
        return _Band(band, small, whole, basis, points, spectra)

    def _basis(
        self, whole: SmallPencil, points: list[Values], spectra: list[ReducedSpectrum]
    ) -> SmallPencil:
        """The basis of what was solved in a band; the whole one where it is hardly smaller."""
        basis = shared(whole, points, dict(enumerate(spectra)), self._tolerance)
        return basis if basis.size <= _LESS * whole.size else whole

    def _at(self, part: float, others: Sequence[float]) -> dict[str, float]:
        """Values of all parameters at a part of the first axis, on a row."""
        values = self._scene.axes[0].values
        value = values[round(part * (len(values) - 1))]
        return self._scene.pencil.values(self._scene.point((value, *others)))
