"""Modes that cases kept, merged for the viewer of a page."""

from typing import Any

import numpy as np

from comparisons.study.result import StudyResult
from comparisons.study.shapes import Shapes as Shapes

NUMBERS = "shapes"
"""Array of a case that holds the numbers of its shapes."""


def stored(shapes: Shapes) -> tuple[dict[str, Any], np.ndarray]:
    """Shapes as plain data and the bytes that it refers to."""
    return {"scenes": shapes.scenes, "modes": shapes.modes}, np.frombuffer(
        shapes.binary.content(), np.uint8
    )


def merged(result: StudyResult) -> Shapes:
    """Shapes of all cases: their numbers one after the other."""
    shapes = Shapes()
    for case in result.cases:
        if case["shapes"]["scenes"]:
            begin = shapes.binary.append(result.arrays[case["key"]][NUMBERS].tobytes())
            shapes.scenes |= _moved(case["shapes"]["scenes"], begin)
            shapes.modes |= _moved(case["shapes"]["modes"], begin)
    return shapes


def _moved(data: Any, by: int) -> Any:
    """Plain data whose places in the numbers lie farther on."""
    if isinstance(data, dict):
        if {"type", "at", "length"} == data.keys():
            return data | {"at": data["at"] + by}
        return {name: _moved(part, by) for name, part in data.items()}
    return [_moved(part, by) for part in data] if isinstance(data, list) else data
