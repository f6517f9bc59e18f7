"""Matching of modes of two runs of a scene by shape and eigenvalue, at points located in both.

Nearly coalescing modes are arbitrary combinations: two discretisations agree on the space that they
span and the mean of their eigenvalues, not on single modes. Such modes are paired as groups.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth, subspace_angles

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign, connected, group
from scenes.results.result import Result

NEAR = 1e-3
"""Relative distance below which eigenvalues of one run are compared as a group."""
_FREQUENCY_SCALE = 0.02
"""Relative difference of eigenvalues with the same cost as a modal assurance of zero."""
ALONE = 2.0
"""Cost above which modes are not paired: that of orthogonal shapes and a difference of 2 %."""
_SAMPLES = 15


@dataclass(frozen=True)
class ModeSet:
    """Modes of one run: eigenvalues (1/s) and displacements at common points."""

    eigenvalues: Complexes
    shapes: Complexes


@dataclass(frozen=True)
class GroupMatch:
    """Indices of matching modes of two runs, one of each or groups.

    Also their mean eigenvalues, and the squared cosine of the largest principal angle between the
    spaces that they span. For single modes it is the modal assurance criterion abs(x^H y)^2 /
    (x^H x y^H y) (R. J. Allemang, The modal assurance criterion - twenty years of use and abuse,
    Sound and Vibration 37 (2003)).
    """

    first: Ints
    second: Ints
    means: tuple[complex, complex]
    assurance: float

    @property
    def distance(self) -> float:
        """Distance of the mean eigenvalues, relative to the second."""
        return float(abs(self.means[0] - self.means[1]) / abs(self.means[1]))


@dataclass(frozen=True)
class ModeMatch:
    """Matched groups, and the indices of unmatched modes of each run."""

    groups: tuple[GroupMatch, ...]
    only_first: Ints
    only_second: Ints


def match_modes(
    first: ModeSet, second: ModeSet, near: float = NEAR, limit: float | None = ALONE
) -> ModeMatch:
    """Pair the modes of two runs with minimal total cost in shapes and eigenvalues.

    Eigenvalues of one run within a relative distance ``near`` are compared as a group. Modes are
    not paired at costs above ``limit``; with None as many as possible are paired.
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


def match_runs(
    first: Result,
    second: Result,
    first_modes: NDArray[np.int64] | None = None,
    second_modes: NDArray[np.int64] | None = None,
    *,
    near: float = NEAR,
    limit: float | None = ALONE,
) -> ModeMatch:
    """Pair modes of two runs of one scene by shape on the contact surfaces and by eigenvalue.

    Scenes without contacts are compared on all surfaces. ``near`` and ``limit`` are those of
    :func:`match_modes`; indices of the matches count the given modes.
    """
    if first_modes is None:
        first_modes = np.arange(len(first.modes))
    if second_modes is None:
        second_modes = np.arange(len(second.modes))
    contacts = first.scene.contacts.values()
    places = [side for contact in contacts for side in contact.sides] or [
        (name, surface) for name, body in first.bodies.items() for surface in body.surfaces
    ]
    left, right = [], []
    for body, name in places:
        surface, other = first.bodies[body].surfaces[name], second.bodies[body].surfaces[name]
        points = surface.grid(max(2, round(_SAMPLES / np.sqrt(surface.num_elements))))
        found = other.locate(points.x, points.normal, other.mesh_size)
        hit, place = ~found.missed, f"{body}.{name}"
        left.append(first.mode_shapes(place, points.at[hit], first_modes))
        right.append(second.mode_shapes(place, found.at[hit], second_modes))
    own = ModeSet(first.eigenvalues[first_modes], _rows(left))
    others = ModeSet(second.eigenvalues[second_modes], _rows(right))
    return match_modes(own, others, near=near, limit=limit)


def _rows(shapes: list[Complexes]) -> Complexes:
    """Stack the displacements of surfaces, with a row for each component of each point."""
    every = np.concatenate(shapes)
    return every.reshape(len(every) * every.shape[1], every.shape[-1])


def _cost(
    first: ModeSet, second: ModeSet, first_groups: list[Ints], second_groups: list[Ints]
) -> Floats:
    """Return 1 - assurance plus the scaled relative distance of eigenvalues, for all pairs."""
    assurance = np.maximum(
        _assurance(first.shapes, second.shapes, second_groups),
        _assurance(second.shapes, first.shapes, first_groups).T,
    )
    one, other = first.eigenvalues[:, None], second.eigenvalues
    size = np.maximum(np.maximum(np.abs(one), np.abs(other)), np.finfo(float).tiny)
    return np.asarray(1 - assurance + np.abs(one - other) / size / _FREQUENCY_SCALE)


def _group_match(first: ModeSet, second: ModeSet, rows: Ints, columns: Ints) -> GroupMatch:
    rows, columns = np.sort(rows), np.sort(columns)
    angles = subspace_angles(first.shapes[:, rows], second.shapes[:, columns])
    means = (complex(s.eigenvalues[i].mean()) for s, i in ((first, rows), (second, columns)))
    return GroupMatch(rows, columns, (next(means), next(means)), float(np.cos(angles[0]) ** 2))


def _assurance(left: Complexes, right: Complexes, groups: list[Ints]) -> Floats:
    """Return norm(P x)^2 / norm(x)^2 for left modes x, shape (modes_left, modes_right).

    P projects onto the span of the group of a right mode; for groups of one mode this is the modal
    assurance criterion.
    """
    left = left / np.linalg.norm(left, axis=0)
    assurance = np.empty((left.shape[1], right.shape[1]))
    for members in groups:
        # numerically parallel members count once
        basis = orth(right[:, members] / np.linalg.norm(right[:, members], axis=0), rcond=1e-10)
        assurance[:, members] = (np.abs(basis.conj().T @ left) ** 2).sum(axis=0)[:, None]
    return assurance
