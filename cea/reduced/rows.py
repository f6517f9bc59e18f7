"""Many values along one parameter, on local bases: a reduced model reduced once more.

At a few values the reduced model is solved as it is. Its eigenvectors there are a smaller basis for
all values between; residuals are those of the whole pencil, so that bounds say as much as before.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from cea.reduced.pieces import Values
from cea.reduced.small import SmallPencil
from cea.reduced.spectrum import ReducedSpectrum

SMALL = 120
"""Size of a basis up to which it is not reduced again, for as few values as a row has."""
_LESS = 0.8
"""Size of a local basis relative to the whole one from which on it is not worth its making."""
_MAKING = 8
"""Values that its making costs as much as; many values are worth a basis that is little smaller."""
_WIDE = 10.0
"""Ratio of a stiffness along a line from which on its vectors are of no one energy norm."""
_FIRST = 5
"""Values solved on the whole basis before any other."""
_LEFT_OUT = 3e-6
"""Part of a vector that a basis with static displacements leaves out."""
_PART = 20
"""Values that share a basis where a line is parted: each is cheaper by the cube of the vectors."""
_FIRST_OF_PART = 3
"""Values of a part solved on the whole basis before any other, its ends among them."""
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


def in_parts(small: SmallPencil, line: Sequence[Values], tolerance: float) -> list[Line]:
    """Spectra along a line part by part, each on a basis of its own, neighbours sharing an end.

    Parameters
    ----------
    small, line, tolerance
        As of :func:`along`.

    Returns
    -------
    list
        Lines whose last spectrum is the first of the next.
    """
    count = max(round((len(line) - 1) / _PART), 1)
    if count == 1 or small.contacts or small.size <= SMALL:
        return [along(small, line, tolerance)]
    ends = np.linspace(0, len(line) - 1, count + 1).round().astype(int).tolist()
    parts: list[Line] = []
    known: dict[int, ReducedSpectrum] = {0: small.at(line[0])}
    for start, end in pairwise(ends):
        known[end - start] = small.at(line[end])
        part = along(small, line[start : end + 1], tolerance, first=_FIRST_OF_PART, known=known)
        known = {0: known[end - start]}
        parts.append(part)
    return parts


def along(
    small: SmallPencil,
    line: Sequence[Values],
    tolerance: float,
    *,
    least: int = SMALL,
    first: int = _FIRST,
    known: Mapping[int, ReducedSpectrum] = MappingProxyType({}),
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
    first
        Values solved on the whole basis before any other.
    known
        Spectra on the whole basis by the numbers of their values, those at both ends.
    """
    if small.size <= least or small.contacts or len(line) < 4:
        return _on_the_whole(small, line, dict(known))
    most = max(_LESS, 1 - _MAKING / len(line)) * small.size
    spread = np.unique(np.linspace(0, len(line) - 1, first).round().astype(int)).tolist()
    whole = {i: known[i] if i in known else small.at(line[i]) for i in spread}
    certified: dict[int, ReducedSpectrum] = {}
    bounds = dict.fromkeys(range(len(line)), np.inf)
    basis = shared(small, line, whole, tolerance)
    fresh: set[int] = set()
    while bounds and basis.size <= most:
        number = max(bounds, key=lambda each: bounds[each])
        if number in fresh:  # the worst of all that are left, on this basis
            if number in whole:
                del bounds[number]
                continue
            if len(whole) >= _MOST:
                break
            whole[number] = small.at(line[number])
            basis, fresh = shared(small, line, whole, tolerance), set()
        fresh.add(number)
        found = basis.at(line[number])
        bounds[number] = found.worst
        if found.worst <= tolerance:
            certified[number] = found
            del bounds[number]
    if basis.size > most:
        return _on_the_whole(small, line, whole)
    rest = [i for i in range(len(line)) if i not in certified]
    made = certified | {i: whole[i] if i in whole else small.at(line[i]) for i in rest}
    return Line([made[i] for i in range(len(line))], small if bounds else basis, frozenset(rest))


def shared(
    small: SmallPencil,
    line: Sequence[Values],
    solved: dict[int, ReducedSpectrum],
    tolerance: float,
) -> SmallPencil:
    """A basis of what is known along a line, with static displacements where it needs them.

    Parameters
    ----------
    small, line, tolerance
        As of :func:`along`.
    solved
        Spectra by the numbers of their values.
    """
    stiff = np.array([small.stiffness(values) for values in line])
    if not (stiff.max(axis=0) > _WIDE * stiff.min(axis=0)).any():
        basis = small.local(np.hstack([small.spanned(each) for each in solved.values()]), line[0])
        if all(
            basis.at(line[i]).worst <= max(tolerance, known.worst) for i, known in solved.items()
        ):
            return basis
    vectors = np.hstack([small.spanned(each, line[i]) for i, each in solved.items()])
    return small.local(vectors, tolerance=_LEFT_OUT)


def _on_the_whole(
    small: SmallPencil, line: Sequence[Values], known: dict[int, ReducedSpectrum]
) -> Line:
    spectra = [known[i] if i in known else small.at(line[i]) for i in range(len(line))]
    return Line(spectra, small, frozenset(range(len(line))))
