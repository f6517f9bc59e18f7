"""Modes of a backend's newest mesh with their bars, clusters widened until bars part them."""

from dataclasses import dataclass
from math import log10, tau

import numpy as np

from cea.arrays import Ints
from cea.eigen.classify import GROWING, thresholds
from cea.eigen.eigenvalue_matching import connected
from comparisons.converge.following import Cluster, Sequence, clusters
from comparisons.converge.histories import Window, window_of
from comparisons.converge.quantities import Member, members_of
from comparisons.converge.request import Request
from scenes.read import Scene

_ROUNDS = 4
"""Times that clusters are widened at most."""


@dataclass(frozen=True)
class Judged:
    """Modes of one backend's newest mesh.

    Parameters
    ----------
    members
        A mode each, by rising frequency.
    clusters
        Their clusters.
    window
        What they show together.
    """

    members: tuple[Member, ...]
    clusters: tuple[Cluster, ...]
    window: Window

    def cluster_of(self, mode: int) -> Cluster:
        """The cluster that a mode belongs to."""
        return next(c for c in self.clusters if mode in c.newest)


def judge(sequence: Sequence, scene: Scene) -> Judged:
    """Bars and verdicts of the newest level's modes.

    Parameters
    ----------
    sequence
        The levels of one backend.
    scene
        What they are meshes of.
    """
    damped = scene.damped or scene.rotates
    grows = damped or any(contact.mu for contact in scene.contacts.values())
    assert scene.analysis.kind == "cea"
    threshold = scene.analysis.growth_threshold
    joined: list[Ints] = []
    for _ in range(_ROUNDS):
        found = clusters(sequence, joined)
        window = window_of(found, sequence, damped=damped)
        members: list[Member | None] = [None] * len(sequence.last.eigenvalues)
        for cluster in found:
            of_cluster = members_of(
                cluster, sequence, window, damped=damped, grows=grows, threshold=threshold
            )
            for number, member in zip(cluster.newest, of_cluster, strict=True):
                members[number] = member
        known = [member for member in members if member is not None]
        if damped or not grows:
            break
        wider = _overlapping(known, found)
        if not wider:
            break
        joined += wider
    return Judged(tuple(known), tuple(found), window)


def _overlapping(members: list[Member], found: list[Cluster]) -> list[Ints]:
    """Single modes whose bars overlap: they may have met, and are judged together."""
    single = np.array([int(c.newest[0]) for c in found if len(c.newest) == 1], int)
    single = np.array([i for i in single if np.isfinite(members[i].frequency_bar)], int)
    if len(single) < 2:
        return []
    values = np.array([members[i].value.imag for i in single])
    bars = np.array([members[i].frequency_bar for i in single])
    near = np.abs(values[:, None] - values) <= bars[:, None] + bars
    return [single[group] for group in connected(near) if len(group) > 1]


def shortfall(member: Member, request: Request, threshold: float | None) -> float:
    """Bar of a mode over the largest that the digits asked for allow; 1 or less when they hold.

    Parameters
    ----------
    member
        The mode.
    request
        The digits.
    threshold
        Growth rate (1/s) below which errors are relative to it; None takes 1e-4 of abs(lambda).
    """
    of_frequency = frequency_shortfall(member, request)
    if member.verdict not in GROWING:
        return of_frequency
    floor = thresholds(np.array([member.value]), threshold)[0]
    scale = max(abs(member.value.real), floor)
    return float(max(of_frequency, member.growth_bar / (request.growth_tolerance * scale)))


def frequency_shortfall(member: Member, request: Request) -> float:
    """The same for digits of frequency alone."""
    if member.rigid:  # zero has no digits
        return 0.0
    speed = max(abs(member.value), np.finfo(float).tiny)
    return float(member.frequency_bar / (request.tolerance * speed))


def digits_held(error: float, value: float) -> float | None:
    """Digits of a number that an error leaves, half a unit of the last; None for no error."""
    if error == 0 or value == 0:
        return None
    return -log10(2 * error / abs(value))


def frequency_of(member: Member) -> float:
    """Frequency (Hz)."""
    return member.value.imag / tau
