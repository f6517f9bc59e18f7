"""Matching complex modes by shape and eigenvalue, and their circumferential orders.

Modes that nearly coalesce mix freely: what two discretisations agree on is the space they span and
the mean of their eigenvalues, not its members. Such modes are paired as groups.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import subspace_angles

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign, connected, group
from cea.errors import InputError

NEAR = 1e-3
"""Relative distance below which eigenvalues of one run are compared as a group."""
_FREQUENCY_SCALE = 0.02
"""Relative difference of eigenvalues that counts as much as a modal assurance of zero."""
ALONE = 2.0
"""Cost at which a mode is rather left alone: other shape and 2 per cent away, or further."""


def modal_assurance(left: Complexes, right: Complexes) -> Floats:
    """Modal assurance criterion of every pair of complex modes.

    Parameters
    ----------
    left, right
        Displacements at common points, shapes (n, modes_left) and (n, modes_right).

    Returns
    -------
    ndarray
        abs(x^H y)^2 / (x^H x y^H y) between 0 and 1, shape (modes_left, modes_right).

    References
    ----------
    R. J. Allemang, The modal assurance criterion - twenty years of use and abuse, Sound and
    Vibration 37 (2003).
    """
    left = left / np.linalg.norm(left, axis=0)
    right = right / np.linalg.norm(right, axis=0)
    return np.abs(left.conj().T @ right) ** 2


def subspace_assurance(left: Complexes, right: Complexes, groups: list[Ints]) -> Floats:
    """Part of every mode that lies in the space of each group of the other side's modes.

    Parameters
    ----------
    left, right
        Displacements at common points, shapes (n, modes_left) and (n, modes_right).
    groups
        Groups of the right modes, each of them in one.

    Returns
    -------
    ndarray
        norm(P x)^2 / norm(x)^2 between 0 and 1, P the projection on the group of the right mode,
        shape (modes_left, modes_right). For groups of one, the modal assurance criterion.
    """
    left = left / np.linalg.norm(left, axis=0)
    assurance = np.empty((left.shape[1], right.shape[1]))
    for members in groups:
        basis = _orthonormal(right[:, members])
        assurance[:, members] = (np.abs(basis.conj().T @ left) ** 2).sum(axis=0)[:, None]
    return assurance


def _orthonormal(vectors: Complexes) -> Complexes:
    """Orthonormal basis of a span; members that are parallel to rounding count once."""
    u, s, _ = np.linalg.svd(vectors / np.linalg.norm(vectors, axis=0), full_matrices=False)
    return u[:, s > 1e-10 * s[0]]


@dataclass(frozen=True)
class ModeSet:
    """Modes of one run, as far as matching looks at them.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,).
    shapes
        Displacements at common points, shape (rows, n).
    orders
        Circumferential orders, shape (n,), of bodies of revolution.
    """

    eigenvalues: Complexes
    shapes: Complexes
    orders: Ints | None = None

    def __post_init__(self) -> None:
        if self.shapes.shape[1:] != self.eigenvalues.shape:
            raise InputError("shapes", self.shapes.shape, f"{len(self.eigenvalues)} columns")


@dataclass(frozen=True)
class GroupMatch:
    """Modes of two runs that stand for one another: one of each, or groups.

    Parameters
    ----------
    first, second
        Numbers of the modes in either run.
    means
        Mean eigenvalue of either.
    angles
        Principal angles between the spaces they span (rad), largest first; of single modes the
        one with cos^2 the modal assurance criterion.
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

    Parameters
    ----------
    first, second
        Modes of either run.
    near
        Relative distance of eigenvalues of one run that are compared as a group.
    limit
        Cost at which modes are rather left alone; None pairs as many as there are.
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
    """Unlikeness of shapes, plus distance of eigenvalues, plus 1 where orders differ."""
    assurance = np.maximum(
        subspace_assurance(first.shapes, second.shapes, second_groups),
        subspace_assurance(second.shapes, first.shapes, first_groups).T,
    )
    cost = 1 - assurance + distances(first.eigenvalues, second.eigenvalues) / _FREQUENCY_SCALE
    if first.orders is not None and second.orders is not None:
        cost += first.orders[:, None] != second.orders
    return cost


def distances(first: Complexes, second: Complexes) -> Floats:
    """Distances of eigenvalues, relative to the larger, shape (n_first, n_second)."""
    size = np.maximum(np.abs(first)[:, None], np.abs(second))
    return np.abs(first[:, None] - second) / np.maximum(size, np.finfo(float).tiny)


def _group_match(first: ModeSet, second: ModeSet, rows: Ints, columns: Ints) -> GroupMatch:
    rows, columns = np.sort(rows), np.sort(columns)
    angles = subspace_angles(first.shapes[:, rows], second.shapes[:, columns])
    means = (complex(s.eigenvalues[i].mean()) for s, i in ((first, rows), (second, columns)))
    return GroupMatch(rows, columns, (next(means), next(means)), angles)


@dataclass(frozen=True)
class CircumferentialContent:
    """Fourier content in theta of complex modes on a body of revolution.

    Parameters
    ----------
    energy
        Part of ``e^{i m theta}`` in each mode, shape (2 top + 1, modes), m from -top to top;
        columns add up to 1.
    """

    energy: Floats

    @property
    def orders(self) -> Ints:
        """Circumferential order abs(m) that holds most of each mode, shape (modes,)."""
        return self._by_order.argmax(axis=0)

    @property
    def shares(self) -> Floats:
        """Part of each mode in its order, m and -m together, shape (modes,)."""
        return self._by_order.max(axis=0)

    @property
    def travelling(self) -> Floats:
        """Sense of travel of each mode, shape (modes,).

        1 where all of its order is ``e^{+i m theta}``, -1 where all is ``e^{-i m theta}``, 0 for
        a standing wave and for order 0.
        """
        top = len(self.energy) // 2
        modes = np.arange(self.energy.shape[1])
        forward = self.energy[top + self.orders, modes]
        backward = self.energy[top - self.orders, modes]
        return (forward - backward) / (forward + backward)

    @property
    def _by_order(self) -> Floats:
        top = len(self.energy) // 2
        both = self.energy[top:] + self.energy[top::-1]
        both[0] /= 2
        return both


def circumferential_content(u: Complexes) -> CircumferentialContent:
    """Fourier analysis in theta of displacements in cylindrical components.

    Parameters
    ----------
    u
        Radial, circumferential and, in 3D, axial components at equally spaced angles from 0 on
        circles about the axis, shape (circles, angles, dim, modes).
    """
    angles = u.shape[1]
    if angles < 3:
        raise InputError("u", u.shape, "3 angles or more")
    top = (angles - 1) // 2
    power = (np.abs(np.fft.fft(u, axis=1)) ** 2).sum(axis=(0, 2))
    energy = power[np.arange(-top, top + 1)]
    return CircumferentialContent(energy / energy.sum(axis=0))
