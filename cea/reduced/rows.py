"""Many values along one parameter, on local bases: a reduced model reduced once more.

At a few values the reduced model is solved as it is. Its eigenvectors there are a smaller basis for
all values between; residuals are those of the whole pencil, so that bounds say as much as before.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from cea.reduced.pieces import Values
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum

_SMALL = 120
"""Size of a basis up to which it is not reduced again, for as few values as a row has."""
_LESS = 0.8
"""Size of a local basis relative to the whole one from which on it is not worth its making."""
_LOOKS = 12
"""Values at which a local basis is looked at before it is at all of them."""
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
    known, basis, number = np.empty((small.size, 0)), small, len(line) // 2
    stride = max(len(line) // _LOOKS, 1)
    local: dict[int, ReducedSpectrum] = {}
    while True:
        found = solved[number] = small.at(line[number])
        known = np.hstack([known, small.spanned(found, line[number])])
        basis = small.local(known)
        if basis.size > _LESS * small.size:
            local = {}
            break
        if len(solved) > _MOST:
            stride = 1
        local = _looked_at(basis, line, solved, stride, {})
        if stride > 1 and _worst(local)[1] <= tolerance:
            local = _looked_at(basis, line, solved, 1, local)
        number, worst = _worst(local)
        if worst <= tolerance:
            return [{**local, **solved}[i] for i in range(len(line))], basis
        if len(solved) > _MOST:
            break
    certified = solved | {i: found for i, found in local.items() if found.worst <= tolerance}
    return [certified[i] if i in certified else small.at(line[i]) for i in range(len(line))], small


def _worst(local: Mapping[int, ReducedSpectrum]) -> tuple[int, float]:
    """Number of the spectrum with the largest bound, and that; 0 where there is none."""
    return max(((i, found.worst) for i, found in local.items()), key=lambda x: x[1], default=(0, 0))


def _looked_at(
    basis: SmallPencil,
    line: Sequence[Values],
    solved: Mapping[int, ReducedSpectrum],
    stride: int,
    before: Mapping[int, ReducedSpectrum],
) -> dict[int, ReducedSpectrum]:
    """Spectra on a local basis at every so many values, the last one, and none that was solved.

    Parameters
    ----------
    basis
        The local basis.
    line
        Values of all parameters, one after the other along the line.
    solved
        Where the whole basis was solved on.
    stride
        Steps between values looked at.
    before
        Spectra on this basis that are known.
    """
    looked = {*range(0, len(line), stride), len(line) - 1} - set(solved)
    return {i: before[i] if i in before else basis.at(line[i]) for i in sorted(looked)}
