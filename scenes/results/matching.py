"""Matching modes of two runs of one scene on points that both can locate."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes
from cea.eigen.matching import ModeMatch, ModeSet, match_modes, modal_assurance
from scenes.results.result import Result

_SAMPLES = 15


def match_runs(
    first: Result,
    second: Result,
    first_modes: NDArray[np.int64] | None = None,
    second_modes: NDArray[np.int64] | None = None,
) -> ModeMatch:
    """Pair modes of two runs of one scene by shape on the contact surfaces and by eigenvalue.

    Scenes without contacts are compared on all surfaces.
    """
    return match_modes(*_mode_sets(first, second, first_modes, second_modes))


def match_unstable(first: Result, second: Result) -> dict[str, Any]:
    """Pair the unstable modes of two runs of one scene.

    They are paired so that shape and eigenvalue agree best over all ``pairs`` together, each with
    frequency and growth of both, and modal assurance; ``only_first`` and ``only_second`` hold the
    modes without a partner.
    """
    unstable = (np.flatnonzero(result.unstable) for result in (first, second))
    sets = _mode_sets(first, second, *unstable)
    match = match_modes(*sets, near=0.0, limit=None)
    assurance = modal_assurance(sets[0].shapes, sets[1].shapes)
    told = [
        [{"frequency": z.imag / (2 * np.pi), "growth": z.real} for z in each.eigenvalues.tolist()]
        for each in sets
    ]
    pairs = []
    # A group of one run is one mode here: groups are pairs, but for exact copies.
    for i, j in ((i, j) for g in match.groups for i, j in zip(g.first, g.second, strict=True)):
        both = {name: [told[0][i][name], told[1][j][name]] for name in ("frequency", "growth")}
        pairs.append({**both, "modal_assurance": float(assurance[i, j])})
    return {
        "pairs": pairs,
        "only_first": [told[0][i] for i in match.only_first],
        "only_second": [told[1][j] for j in match.only_second],
    }


def _mode_sets(
    first: Result,
    second: Result,
    first_modes: NDArray[np.int64] | None,
    second_modes: NDArray[np.int64] | None,
) -> tuple[ModeSet, ModeSet]:
    """Eigenvalues, and displacements at points of the contact surfaces that both can locate."""
    chosen = [
        np.arange(len(result.modes)) if modes is None else modes
        for result, modes in ((first, first_modes), (second, second_modes))
    ]
    left, right = [], []
    for place in _places(first):
        body, name = place.split(".")
        surface = first.system.bodies[body].surfaces[name]
        other = second.system.bodies[body].surfaces[name]
        points = surface.grid(max(2, round(_SAMPLES / np.sqrt(surface.num_elements))))
        found = other.locate(points.x, points.normal, other.mesh_size)
        hit = ~found.missed
        left.append(first.mode_shapes(place, points.at[hit], chosen[0]))
        right.append(second.mode_shapes(place, found.at[hit], chosen[1]))
    return (
        ModeSet(first.eigenvalues[chosen[0]], _rows(left)),
        ModeSet(second.eigenvalues[chosen[1]], _rows(right)),
    )


def _places(result: Result) -> list[str]:
    """Both sides of every contact; every surface of scenes without contacts."""
    contacts = result.scene.contacts.values()
    sides = [side for contact in contacts for side in (contact.a, contact.b)]
    return sides or [
        f"{name}.{surface}" for name, body in result.bodies.items() for surface in body.surfaces
    ]


def _rows(shapes: list[Complexes]) -> Complexes:
    """Displacements of several surfaces, a row for each component of each point."""
    every = np.concatenate(shapes)
    return every.reshape(len(every) * every.shape[1], every.shape[-1])
