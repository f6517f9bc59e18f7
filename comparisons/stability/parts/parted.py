"""Scenes whose friction is bounded by what lies near the contacts, small as they are."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from cea.eigen.krylov_schur import solve_modes
from comparisons.stability.parts.answers import Answer, answer_of
from scenes.read import read_scene
from scenes.run import coupled


@dataclass(frozen=True)
class OfParts:
    """A scene with bodies of finite elements, of which only a part lies near contacts.

    Parameters
    ----------
    data
        What a scene file holds; ``analysis.max_frequency`` may be left to the reference.
    """

    data: Mapping[str, Any]

    def solve(self, max_frequency: float | None) -> Answer:
        """Modes of a window that rests on the part."""
        data = deepcopy(dict(self.data))
        top = data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
        system, _, _ = coupled(read_scene(data))
        pencil = system.pencil(parted_from=0)
        assert pencil.near_contact is not None
        modes = solve_modes(pencil, top)
        return answer_of(modes, (*system.warnings, *modes.warnings), None, system.size)
