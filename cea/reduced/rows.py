"""Many values along one parameter, on local bases: a reduced model reduced once more.

At a few values the reduced model is solved as it is. Its eigenvectors there are a smaller basis for
all values between; residuals are those of the whole pencil, so that bounds say as much as before.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cea.reduced.pieces import Values
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum

_SMALL = 120
"""Size of a basis up to which it is not reduced again, for as few values as a row has."""
_LESS = 0.8
"""Size of a local basis relative to the whole one from which on it is not worth its making."""
_FIRST = 5
"""Values solved on the whole basis before any other."""
_MOST = 12
"""Values solved on the whole basis after which all that are not certified yet are."""


@dataclass(frozen=True)
class Line:
    """Spectra at values along a line in parameters.

    Parameters
    ----------
    spectra
        One for each value, coordinates in the whole basis.
    basis
        The basis for values between.
    whole
        Numbers of those that were solved on the whole basis.
    """

    spectra: list[ReducedSpectrum]
    basis: SmallPencil
    whole: frozenset[int]


def along(
    small: SmallPencil, line: Sequence[Values], tolerance: float, *, least: int = _SMALL
) -> Line:
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
    """
    if small.size <= least or len(line) < 4:
        return _on_the_whole(small, line, {})
    first = np.unique(np.linspace(0, len(line) - 1, _FIRST).round().astype(int)).tolist()
    whole = {i: small.at(line[i]) for i in first}
    certified: dict[int, ReducedSpectrum] = {}
    while True:
        known = [small.spanned(found, line[i], line) for i, found in whole.items()]
        basis = small.local(np.hstack(known), line)
        if basis.size > _LESS * small.size:
            return _on_the_whole(small, line, whole)
        open_ = [i for i in range(len(line)) if i not in certified]
        looked = {i: basis.at(line[i]) for i in open_}
        certified |= {i: found for i, found in looked.items() if found.worst <= tolerance}
        left = [i for i in open_ if i not in certified and i not in whole]
        if not left:
            break
        if len(whole) >= _MOST:
            whole |= {i: small.at(line[i]) for i in left}
            break
        worst = max(left, key=lambda i: looked[i].worst)
        whole[worst] = small.at(line[worst])
    spectra = [certified[i] if i in certified else whole[i] for i in range(len(line))]
    return Line(spectra, basis, frozenset(whole) - frozenset(certified))


def _on_the_whole(
    small: SmallPencil, line: Sequence[Values], known: dict[int, ReducedSpectrum]
) -> Line:
    spectra = [known[i] if i in known else small.at(line[i]) for i in range(len(line))]
    return Line(spectra, small, frozenset(range(len(line))))
