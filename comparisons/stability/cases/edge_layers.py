"""Layers of cells towards singular edges, down to a millionth of their neighbours."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, layers
from comparisons.stability.parts.ways import QUICK, WAYS, chosen

_FE = chosen(WAYS, *QUICK, backend="fe")
_FOOT, _HEAD = {"x": 0.0, "y": -1.0}, {"x": 2.0, "y": 0.0}
"""An edge of the face that is held, and one of the face that slides."""


def _crowded(number: int, *edges: dict[str, float], **options: Any) -> Scene:
    data = layers(**options)
    data["bodies"]["lower"]["mesh"]["fe"].update({"edges": list(edges), "layers": number})
    return data


@case("Layers of cells towards edges", subject="geometry")
def edge_layers() -> Iterator[Run]:
    """Cells 0.2^n as large as their neighbours, at a support and on the contact."""
    for degree in (1, 2, 4):
        for number in (1, 4, 8):
            for way in _FE:
                data = way.of(_crowded(number, _FOOT, _HEAD, lower={"degree": degree}))
                row = f"{number} layer{'s' if number > 1 else ''}, degree {degree}"
                yield Run(row, way, OfScene(data), dense(data))
    for way in _FE:
        one = way.of(_crowded(1, _FOOT, _HEAD, lower_elements=(1, 1)))
        row = "edges at opposite corners of a cell"
        yield Run(row, way, OfScene(one), None, REFUSED, names="elements")
