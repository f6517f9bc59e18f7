"""Many values along one parameter, on local bases: a reduced model reduced once more.

At a few values the reduced model is solved as it is. Its eigenvectors there are a smaller basis for
all values between; residuals are those of the whole pencil, so that bounds say as much as before.
"""

from collections.abc import Sequence

import numpy as np

from cea.reduced.pieces import Values
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum

_SMALL = 120
"""Size of a basis up to which it is not reduced again, for as few values as a row has."""
_MOST = 12
"""Values solved on the whole basis after which all that are not certified yet are."""


def along(
    small: SmallPencil, line: Sequence[Values], tolerance: float, *, least: int = _SMALL
) -> tuple[list[ReducedSpectrum], SmallPencil]:
    """Spectra at values along a line in parameters.

    Parameters
    ----------
    small
        The reduced model.
    line
        Values of all parameters, one after the other along the line.
    tolerance
        Error of lambda, relative to its speed, above which a value is solved on the whole basis.
    least
        Size of a basis up to which it is not reduced again.

    Returns
    -------
    tuple
        The spectra, and the basis for values between these.
    """
    if small.size <= least or len(line) < 4:
        return [small.at(values) for values in line], small
    solved: dict[int, ReducedSpectrum] = {}
    local: dict[int, ReducedSpectrum] = {}
    bounds = np.full(len(line), np.inf)
    known, number = np.empty((small.size, 0)), len(line) // 2
    basis = small
    while True:
        found = solved[number] = small.at(line[number])
        bounds[number] = 0.0
        known = np.hstack([known, small.spanned(found, line[number])])
        basis = small.local(known)
        if basis.size > 0.8 * small.size:
            basis = small
        for each in np.flatnonzero(bounds > tolerance).tolist():
            local[each] = basis.at(line[each])
            bounds[each] = local[each].worst
        number = int(np.argmax(bounds))
        if len(solved) > _MOST and bounds[number] > tolerance:
            basis = small
            left = np.flatnonzero(bounds > tolerance).tolist()
            solved |= {each: small.at(line[each]) for each in left}
        if bounds[number] <= tolerance or basis is small:
            return [solved.get(i) or local[i] for i in range(len(line))], basis
