"""Scenes that are not searched: their modes are continued from those of a coarser mesh."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from comparisons.stability.parts.answers import ModesAnswer, answer_of
from scenes.nested import continued_modes
from scenes.read import Scene, read_scene
from scenes.run import run_modes

_BEYOND = 1.5
"""How far the coarser scene is searched, relative to the window of the finer one."""
_STEPS = 4
"""Block inverse steps: few modes of small scenes lie far from those beyond them."""


@dataclass(frozen=True)
class OfContinued:
    """A scene whose modes start from those of a coarser one.

    Parameters
    ----------
    data, coarse
        What scene files of it and of the coarser one hold.
    """

    data: Mapping[str, Any]
    coarse: Mapping[str, Any]

    def solve(self, max_frequency: float | None) -> ModesAnswer:
        """Modes of the coarser scene, prolonged and improved."""
        top = max_frequency or 1.0
        fine, coarse = _read(self.data, top), _read(self.coarse, _BEYOND * top)
        result = continued_modes(run_modes(coarse, left=True), fine, steps=_STEPS)
        threshold = result.analysis.growth_threshold
        return answer_of(result.modes, result.warnings, threshold, result.system.size)


def _read(data: Mapping[str, Any], max_frequency: float) -> Scene:
    given = deepcopy(dict(data))
    given["analysis"].setdefault("max_frequency", max_frequency)
    return read_scene(given)
