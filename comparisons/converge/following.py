"""Modes followed from mesh to mesh, and gathered in clusters that are judged together."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from cea.arrays import Complexes, Ints
from cea.eigen.eigenvalue_matching import assign, connected
from comparisons.converge.levels import Level
from comparisons.converge.parts import Parts
from scenes.run_matching import match_runs
from scenes.spec.body import Backend

_PARTNERS = 1e-9
"""Relative distance of the frequencies of a growing mode and its decaying partner."""


@dataclass
class Sequence:
    """Levels of one backend, with the modes that stand for one another.

    Parameters
    ----------
    backend
        The backend.
    singular
        Whether edges of the scene are singular.
    levels
        From the first mesh on; only the last holds its vectors.
    links
        Groups of modes of each level and of the next that were matched.
    correction
        The newest level in a richer space (:mod:`comparisons.converge.estimated`).
    parts
        Errors of the modes of a level in their parts, where they were measured.
    """

    backend: Backend
    singular: bool = False
    levels: list[Level] = field(default_factory=list)
    links: list[list[tuple[Ints, Ints]]] = field(default_factory=list)
    correction: Level | None = None
    parts: Parts | None = None

    @property
    def with_correction(self) -> "Sequence":
        """The sequence with the newest level corrected, where it was, as one more level."""
        if self.correction is None:
            return self
        each = [(np.array([n]), np.array([n])) for n in range(len(self.correction.eigenvalues))]
        levels = [*self.levels, self.correction]
        links = [*self.links, each]
        return Sequence(self.backend, self.singular, levels, links, parts=self.parts)

    def add(self, level: Level) -> None:
        """Match the modes of a new level with those of the last one; collective."""
        if self.levels:
            last = self.levels[-1]
            self.links.append(matched(last, level))
            self.levels[-1] = last.forgotten()
        self.levels.append(level)
        self.correction = None

    @property
    def last(self) -> Level:
        """The newest level."""
        return self.levels[-1]


def matched(first: Level, second: Level) -> list[tuple[Ints, Ints]]:
    """Groups of modes of two meshes that stand for one another, by their numbers; collective.

    Rigid motions stand for rigid motions where there are as many: rounding is no eigenvalue to
    match them by.
    """
    assert first.result is not None
    assert second.result is not None
    levels = (first, second)
    at_rest = [np.flatnonzero(level.rigid) for level in levels]
    if len(at_rest[0]) != len(at_rest[1]) or not len(at_rest[0]):
        match = match_runs(first.result, second.result)
        return [(group.first, group.second) for group in match.groups]
    moving = [np.flatnonzero(~level.rigid) for level in levels]
    match = match_runs(first.result, second.result, *moving)
    groups = [(moving[0][group.first], moving[1][group.second]) for group in match.groups]
    return [(at_rest[0], at_rest[1]), *groups]


@dataclass(frozen=True)
class Cluster:
    """Modes that cannot be told apart on some mesh: they meet there, or nearly.

    Parameters
    ----------
    members
        Their numbers on each level, of the same count on all; None where they were not found, or
        in another number.
    changed
        Whether some level has more or fewer of them than the newest.
    """

    members: tuple[Ints | None, ...]
    changed: bool

    @property
    def newest(self) -> Ints:
        """Numbers on the newest level."""
        found = self.members[-1]
        assert found is not None
        return found


def clusters(sequence: Sequence, joined: list[Ints] | None = None) -> list[Cluster]:
    """Clusters of the newest level's modes, by their first members.

    Parameters
    ----------
    sequence
        Levels and their links.
    joined
        Sets of the newest level's modes that are judged together besides.
    """
    starts = np.cumsum([0, *(len(level.eigenvalues) for level in sequence.levels)])
    linked = np.eye(starts[-1], dtype=bool)
    for i, groups in enumerate(sequence.links):
        for first, second in groups:
            _join(linked, np.concatenate([starts[i] + first, starts[i + 1] + second]))
    for start, level in zip(starts, sequence.levels, strict=False):
        for pair in partners(level.eigenvalues):
            _join(linked, start + pair)
    for members in joined or []:
        _join(linked, starts[-2] + members)
    found = []
    for nodes in connected(linked):
        each = [nodes[(nodes >= a) & (nodes < b)] - a for a, b in pairwise(starts)]
        count = len(each[-1])
        if count:
            alike = tuple(numbers if len(numbers) == count else None for numbers in each)
            changed = any(len(numbers) not in (0, count) for numbers in each)
            found.append(Cluster(alike, changed))
    return sorted(found, key=lambda cluster: int(cluster.newest[0]))


def lost(sequence: Sequence, highest: float) -> list[complex]:
    """Modes of the last level but one, below a frequency (rad/s), that the newest does not have."""
    if not sequence.links:
        return []
    values = sequence.levels[-2].eigenvalues
    followed = np.concatenate([np.empty(0, int), *(first for first, _ in sequence.links[-1])])
    alone = np.setdiff1d(np.arange(len(values)), followed)
    return [complex(v) for v in values[alone] if v.imag < highest]


def partners(values: Complexes) -> list[Ints]:
    """Pairs lambda, -conj(lambda) of growing and decaying modes of equal frequency."""
    grows = np.flatnonzero(values.real > 0)
    decays = np.flatnonzero(values.real < 0)
    if not len(grows) or not len(decays):
        return []
    mirrored = -values[decays].conj()
    distance = np.abs(values[grows][:, None] - mirrored) / np.abs(values[grows])[:, None]
    rows, columns = assign(distance, _PARTNERS)
    return [np.array([grows[i], decays[j]]) for i, j in zip(rows, columns, strict=True)]


def _join(linked: np.ndarray, nodes: Ints) -> None:
    """Link nodes with the first of them, which connects them all."""
    linked[nodes[0], nodes] = linked[nodes, nodes[0]] = True
