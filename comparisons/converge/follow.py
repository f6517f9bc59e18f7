"""Matching of modes from mesh to mesh by shape, and error bars on the finest mesh."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise

import numpy as np

from cea.arrays import Complexes, Ints
from cea.eigen.matching import assign, connected
from comparisons.converge.bars import Estimated, bar_of, opened, pair, single, splitting
from comparisons.converge.ladder import Ladder, Mesh
from scenes.results.matching import match_runs


@dataclass
class Followed:
    """Meshes of one backend, and matched groups of modes of each mesh and the next."""

    meshes: list[Mesh] = field(default_factory=list)
    links: list[list[tuple[Ints, Ints]]] = field(default_factory=list)

    def add(self, mesh: Mesh) -> None:
        """Add a mesh and match its modes with those of the last mesh; collective."""
        if self.meshes:
            last = self.meshes[-1]
            self.links.append(matched(last, mesh))
            self.meshes[-1] = replace(last, result=None)
        self.meshes.append(mesh)

    @property
    def lost(self) -> Complexes:
        """Eigenvalues of the last mesh but one without a match on the last mesh."""
        if not self.links:
            return np.empty(0, complex)
        followed = np.concatenate([np.empty(0, int), *(first for first, _ in self.links[-1])])
        return np.delete(self.meshes[-2].eigenvalues, followed)


def matched(first: Mesh, second: Mesh) -> list[tuple[Ints, Ints]]:
    """Return matched groups of modes of two meshes, by their numbers; collective.

    Rigid body modes form one group if there are equally many, because their eigenvalues are
    rounding errors.
    """
    assert first.result is not None
    assert second.result is not None
    at_rest = [np.flatnonzero(mesh.rigid) for mesh in (first, second)]
    moving = [np.flatnonzero(~mesh.rigid) for mesh in (first, second)]
    if len(at_rest[0]) != len(at_rest[1]):
        at_rest, moving = [], [np.arange(len(mesh.eigenvalues)) for mesh in (first, second)]
    match = match_runs(first.result, second.result, moving[0], moving[1])
    groups = [(moving[0][group.first], moving[1][group.second]) for group in match.groups]
    return [(at_rest[0], at_rest[1]), *groups] if at_rest and len(at_rest[0]) else groups


def estimated(followed: Followed, ladder: Ladder) -> list[Estimated]:
    """Return the modes of the finest mesh with error bars, in the order of its eigenvalues."""
    mesh, degree, scene = followed.meshes[-1], ladder.degree, ladder.scene
    damped = scene.damped or scene.rotates
    grows = damped or any(contact.mu for contact in scene.contacts.values())
    assert mesh.corrected is not None
    found: dict[int, Estimated] = {}
    histories: dict[int, Complexes] = {}
    for members in _clusters(followed):
        newest = members[-1]
        assert newest is not None
        values = _values(members[-1:] if ladder.by_degree else members, followed)  # single estimate
        corrected = mesh.corrected[newest]
        rounding = mesh.uncertainties[newest]
        if len(newest) == 2 and grows and not mesh.rigid[newest].any():
            both = pair(values, corrected, degree, float(rounding.max()), damped=damped)
            found |= dict(zip(newest.tolist(), both, strict=True))
            continue
        for i, number in enumerate(newest.tolist()):
            found[number] = single(
                values[:, i],
                complex(corrected[i]),
                degree,
                float(rounding[i]),
                damped=damped and grows,
            )
            histories[number] = values[:, i]
    if grows and not damped:
        _open_where_bars_meet(found, histories, mesh, degree)
    for i in np.flatnonzero(mesh.rigid).tolist():
        value = complex(mesh.eigenvalues[i])
        bar = abs(value) + float(mesh.uncertainties[i])
        found[i] = Estimated(value, bar, bar)
    return [found[i] for i in range(len(mesh.eigenvalues))]


def _open_where_bars_meet(
    found: dict[int, Estimated], histories: dict[int, Complexes], mesh: Mesh, degree: int
) -> None:
    """Mark modes without growth as undecided if the bar of their splitting contains zero."""
    assert mesh.corrected is not None
    still = [i for i in histories if found[i].still and not mesh.rigid[i]]
    for i, j in combinations(still, 2):
        a, b = found[i], found[j]
        apart = abs(a.value.imag - b.value.imag)
        multiple = mesh.stable[[i, j]].all() and apart <= mesh.uncertainties[[i, j]].sum()
        if multiple or apart > a.frequency_bar + b.frequency_bar:
            continue
        count = min(len(histories[i]), len(histories[j]))
        squares = np.column_stack([histories[k][-count:] ** 2 for k in (i, j)])
        richer = splitting(mesh.corrected[[i, j]] ** 2)
        splittings = splitting(squares).tolist()
        bar, root = bar_of(splittings, richer, degree), abs(splittings[-1])
        if root <= bar.size:
            for k in (i, j):
                found[k] = opened(found[k], root, bar.size)


def _values(members: Sequence[Ints | None], followed: Followed) -> Complexes:
    """Return the eigenvalues of a cluster on the last consecutive meshes that have all of it.

    Each column follows the nearest eigenvalue from mesh to mesh.
    """
    rows: list[Complexes] = []
    for numbers, mesh in zip(reversed(members), reversed(followed.meshes), strict=False):
        if numbers is None:
            break
        own = mesh.eigenvalues[numbers]
        rows.append(own if not rows else own[assign(np.abs(own[None, :] - rows[-1][:, None]))[1]])
    return np.array(rows[::-1])


def _clusters(followed: Followed) -> list[tuple[Ints | None, ...]]:
    """Return clusters of modes that are matched or coalesce on some mesh, by their numbers.

    An entry is None if that mesh has another number of modes of the cluster than the newest.
    """
    meshes = followed.meshes
    starts = np.cumsum([0, *(len(mesh.eigenvalues) for mesh in meshes)])
    linked = np.eye(starts[-1], dtype=bool)
    for i, groups in enumerate(followed.links):
        for first, second in groups:
            _join(linked, np.concatenate([starts[i] + first, starts[i + 1] + second]))
    for start, mesh in zip(starts, meshes, strict=False):
        for both in _partners(mesh):
            _join(linked, start + both)
    found = []
    for nodes in connected(linked):
        each = [nodes[(nodes >= a) & (nodes < b)] - a for a, b in pairwise(starts)]
        if count := len(each[-1]):
            found.append(tuple(own if len(own) == count else None for own in each))
    return found


def _partners(mesh: Mesh) -> list[Ints]:
    """Pairs lambda, -conj(lambda) of growing and decaying modes of equal frequency."""
    values = mesh.eigenvalues
    grows, decays = np.flatnonzero(values.real > 0), np.flatnonzero(values.real < 0)
    if not len(grows) or not len(decays):
        return []
    distance = np.abs(values[grows][:, None] + values[decays].conj())
    rows, columns = assign(distance)
    bound = mesh.uncertainties[grows][rows] + mesh.uncertainties[decays][columns]
    near = distance[rows, columns] <= bound
    return [np.array([grows[i], decays[j]]) for i, j in zip(rows[near], columns[near], strict=True)]


def _join(linked: np.ndarray, nodes: Ints) -> None:
    """Connect nodes by linking each of them with the first."""
    linked[nodes[0], nodes] = linked[nodes, nodes[0]] = True
