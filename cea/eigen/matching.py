"""Matching eigenvalues by distance, and complex modes by shape too, with multiplicities.

Modes that nearly coalesce mix freely: what two discretisations agree on is the space they span and
the mean of their eigenvalues, not its members. Such modes are paired as groups.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth, subspace_angles
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.arrays import Complexes, Floats, Ints
from cea.errors import InputError

DEGENERATE = 1e-8
"""Relative distance below which eigenvalues count as one of higher multiplicity."""

_NO_GROWTH = 1e-9
"""Growth rates below this part of abs(lambda) are rounding."""
_RIGID = 1e-6
"""Eigenvalues below this part of the largest stand for a rigid motion."""
NEAR = 1e-3
"""Relative distance below which eigenvalues of one run are compared as a group."""
_FREQUENCY_SCALE = 0.02
"""Relative difference of eigenvalues that counts as much as a modal assurance of zero."""
ALONE = 2.0
"""Cost at which a mode is rather left alone: other shape and 2 per cent away, or further."""


def assign(cost: Floats, limit: float | None = None) -> tuple[Ints, Ints]:
    """Pairs of rows, rising, and columns, each used once at most, of least total cost.

    No pair that costs more than the limit is made; without one min(n, m) pairs are.
    """
    if limit is None:
        rows, columns = linear_sum_assignment(cost)
        return rows, columns
    n, m = cost.shape
    rows, columns = linear_sum_assignment(np.hstack([cost, np.full((n, n), limit)]))
    paired = columns < m
    return rows[paired], columns[paired]


def group(values: Complexes, tolerance: float = DEGENERATE, least: float = 0.0) -> list[Ints]:
    """Groups of eigenvalues that touch, by first members: chains of near neighbours.

    The tolerance is relative to the larger of two, and to a least size: rigid motions touch.
    """
    if not tolerance >= 0:
        raise InputError("tolerance", tolerance, "zero or positive")
    sizes = np.maximum(np.abs(values), least)
    near = np.abs(values[:, None] - values) <= tolerance * np.maximum(sizes[:, None], sizes)
    return connected(near)


def connected(linked: NDArray[np.bool_]) -> list[Ints]:
    """Sets of indices joined by a symmetric relation, shape (n, n), by their first members."""
    if np.count_nonzero(linked) == np.count_nonzero(np.diag(linked)):
        return list(np.arange(len(linked))[:, None])
    count, label = connected_components(csr_array(linked), directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]


@dataclass(frozen=True)
class SpectrumMatch:
    """Exact eigenvalues with their computed partners, NaN where there is none, and spurious ones.

    Differences are computed less exact ones, those of a group of exact ones the difference of the
    means: near a coalescence the members lose half the digits of the mean.
    """

    exact: Complexes
    found: Complexes
    differences: Complexes
    spurious: Complexes

    @property
    def missing(self) -> Complexes:
        """Exact eigenvalues that were not found."""
        return self.exact[np.isnan(self.found)]

    @property
    def errors(self) -> Floats:
        """Relative errors of lambda, shape (n,); infinite where none was found."""
        return _relative(self.differences, np.abs(self.exact))

    @property
    def frequency_errors(self) -> Floats:
        """Errors of Im lambda relative to abs(lambda), shape (n,)."""
        return _relative(self.differences.imag, np.abs(self.exact))

    @property
    def growth_errors(self) -> Floats:
        """Errors of Re lambda relative to the largest growth rate; where none grows to lambda."""
        size = np.abs(self.exact)
        largest = np.abs(self.exact.real).max(initial=0.0)
        grows = largest > _NO_GROWTH * size.max(initial=0.0)
        return _relative(self.differences.real, np.where(grows, largest, size))


def _relative(differences: NDArray[Any], scale: Floats) -> Floats:
    error = np.abs(differences)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(error == 0, 0.0, error / scale)
    return np.where(np.isnan(error), np.inf, relative)


def match_spectrum(
    computed: Complexes,
    exact: Complexes,
    band: tuple[float, float] = (0.0, np.inf),
    *,
    reach: float = 0.5,
    tolerance: float = DEGENERATE,
) -> SpectrumMatch:
    """Find the computed partner of each exact eigenvalue whose Im lambda is in a band.

    Both lists, multiple eigenvalues as often as their multiplicity, may, and near the ends of the
    band should, reach beyond it: what lies there is matched too, but neither missed nor called
    spurious. Partners are no farther than a ``reach`` relative to the exact one; exact ones within
    a relative tolerance are compared by their mean.
    """
    if not band[0] < band[1]:
        raise InputError("band", band, "a lowest below a highest")
    if not reach > 0:
        raise InputError("reach", reach, "positive")
    # A rigid motion has lambda = 0, found as rounding: nothing is relative to that.
    size = np.maximum(np.abs(exact), _RIGID * np.abs(exact).max(initial=1.0))
    distance = np.abs(computed[None, :] - exact[:, None]) / size[:, None]
    rows, columns = assign(distance, reach)
    found = np.full(len(exact), np.nan, complex)
    found[rows] = computed[columns]
    alone = np.delete(computed, columns)
    spurious = alone[(alone.imag >= band[0]) & (alone.imag <= band[1])]
    listed = (exact.imag >= band[0]) & (exact.imag <= band[1])
    exact, found = exact[listed], found[listed]
    differences = found - exact
    for members in group(exact, tolerance):
        differences[members] = differences[members].mean()
    return SpectrumMatch(exact, found, differences, spurious)


def modal_assurance(left: Complexes, right: Complexes) -> Floats:
    """Modal assurance criterion abs(x^H y)^2 / (x^H x y^H y), shape (modes_left, modes_right).

    Displacements are at common points, shapes (n, modes_left) and (n, modes_right) (R. J. Allemang,
    The modal assurance criterion - twenty years of use and abuse, Sound and Vibration 37 (2003)).
    """
    return subspace_assurance(left, right, list(np.arange(right.shape[1])[:, None]))


def subspace_assurance(left: Complexes, right: Complexes, groups: list[Ints]) -> Floats:
    """Part norm(P x)^2 / norm(x)^2 of left modes in the space of groups of right modes.

    P projects on the group of the right mode, shape (modes_left, modes_right); of groups of one it
    is the modal assurance criterion.
    """
    left = left / np.linalg.norm(left, axis=0)
    assurance = np.empty((left.shape[1], right.shape[1]))
    for members in groups:
        # members that are parallel to rounding count once
        basis = orth(right[:, members] / np.linalg.norm(right[:, members], axis=0), rcond=1e-10)
        assurance[:, members] = (np.abs(basis.conj().T @ left) ** 2).sum(axis=0)[:, None]
    return assurance


@dataclass(frozen=True)
class ModeSet:
    """Modes of one run: lambda (1/s), and displacements at common points."""

    eigenvalues: Complexes
    shapes: Complexes

    def __post_init__(self) -> None:
        if self.shapes.shape[1:] != self.eigenvalues.shape:
            raise InputError("shapes", self.shapes.shape, f"{len(self.eigenvalues)} columns")


@dataclass(frozen=True)
class GroupMatch:
    """Numbers of modes of two runs that stand for one another, one of each, or groups.

    With their mean eigenvalues, and the principal angles between the spaces they span (rad),
    largest first: of single modes cos^2 of it is the modal assurance criterion.
    """

    first: Ints
    second: Ints
    means: tuple[complex, complex]
    angles: Floats

    @property
    def distance(self) -> float:
        """Distance of the means relative to the second."""
        return float(abs(self.means[0] - self.means[1]) / abs(self.means[1]))

    @property
    def assurance(self) -> float:
        """Square of the cosine of the largest principal angle."""
        return float(np.cos(self.angles[0]) ** 2)


@dataclass(frozen=True)
class ModeMatch:
    """What was matched, and every mode that was not."""

    groups: tuple[GroupMatch, ...]
    only_first: Ints
    only_second: Ints


def match_modes(
    first: ModeSet, second: ModeSet, near: float = NEAR, limit: float | None = ALONE
) -> ModeMatch:
    """Pair the modes of two runs so that shapes and eigenvalues agree best over all together.

    Eigenvalues of one run up to a relative distance ``near`` are compared as a group; at a cost of
    ``limit`` modes are rather left alone, without one as many are paired as there are.
    """
    groups = group(first.eigenvalues, near), group(second.eigenvalues, near)
    rows, columns = assign(_cost(first, second, *groups), limit)
    numbers = [np.empty(len(s.eigenvalues), np.int64) for s in (first, second)]
    for number, members in zip(numbers, groups, strict=True):
        for i, indices in enumerate(members):
            number[indices] = i
    # Pairs of one group, of either run, belong together.
    a, b = numbers[0][rows], numbers[1][columns]
    together = connected((a[:, None] == a) | (b[:, None] == b))
    return ModeMatch(
        tuple(_group_match(first, second, rows[pairs], columns[pairs]) for pairs in together),
        np.setdiff1d(np.arange(len(first.eigenvalues)), rows),
        np.setdiff1d(np.arange(len(second.eigenvalues)), columns),
    )


def _cost(
    first: ModeSet, second: ModeSet, first_groups: list[Ints], second_groups: list[Ints]
) -> Floats:
    """Unlikeness of shapes, plus distance of eigenvalues relative to the larger."""
    assurance = np.maximum(
        subspace_assurance(first.shapes, second.shapes, second_groups),
        subspace_assurance(second.shapes, first.shapes, first_groups).T,
    )
    one, other = first.eigenvalues[:, None], second.eigenvalues
    size = np.maximum(np.maximum(np.abs(one), np.abs(other)), np.finfo(float).tiny)
    return np.asarray(1 - assurance + np.abs(one - other) / size / _FREQUENCY_SCALE)


def _group_match(first: ModeSet, second: ModeSet, rows: Ints, columns: Ints) -> GroupMatch:
    rows, columns = np.sort(rows), np.sort(columns)
    angles = subspace_angles(first.shapes[:, rows], second.shapes[:, columns])
    means = (complex(s.eigenvalues[i].mean()) for s, i in ((first, rows), (second, columns)))
    return GroupMatch(rows, columns, (next(means), next(means)), angles)
