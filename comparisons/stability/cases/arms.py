"""Oblique arms on a base, whose growing modes lie far outside the frequencies looked at."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import (
    Scene,
    body,
    changed,
    contact,
    patch,
    rectangle,
    scene,
)
from comparisons.stability.parts.ways import WAYS, chosen


def _arm(
    width: float,
    lean: float,
    height: float,
    elements: tuple[int, int],
    *,
    E: float = 1.0,
    held: bool = False,
    base: Scene,
    frequency: float,
    **fields: Any,
) -> Scene:
    """An arm that leans by so much, its foot on a base."""
    half = width / 2
    shape = patch([[-half, 0.0], [half, 0.0]], [[lean - half, height], [lean + half, height]])
    data = scene(
        {
            "arm": body(shape, elements, E=E, supports=[{"surface": "head"}] if held else []),
            "base": base,
        },
        contact=contact("arm.foot", "base.y_max", **fields),
    )
    return changed(data, {"analysis.max_frequency": frequency})


def _base(size: tuple[float, float], elements: tuple[int, int], *, held: bool) -> Scene:
    supports = [{"surface": "y_min"}] if held else []
    return body(rectangle(size, (-size[0] / 2, -size[1])), elements, E=10.0, supports=supports)


_SMALL = ((2.0, 1.0), (9, 4))
_ARMS = {
    "divergence of 3.35": _arm(
        *(0.2, 0.36397023426620236, 1.0, (3, 8)),
        E=100.0,
        held=True,
        base=_base((6.0, 3.0), (15, 6), held=True),
        frequency=0.5,
        p=1e4,
        mu=1.0,
    ),
    "flutter of 4.56": _arm(
        *(0.25, -0.2151833689734136, 1.39, (5, 4)),
        base=_base(*_SMALL, held=True),
        frequency=0.4,
        p=98036.108,
        mu=2.75,
    ),
    "a copy of zero": _arm(
        *(0.55, 0.4549995702848617, 0.55, (5, 2)),
        base=_base(*_SMALL, held=False),
        frequency=1.29,
        p=531.164,
        mu=0.5,
    ),
}
"""Arms by what is easily missed of them."""


@case("Oblique arms: divergence, strong flutter, copies of zero", subject="friction and spectra")
def arms() -> Iterator[Run]:
    """Modes that grow by far more than the frequencies looked at, and one of several at zero."""
    for name, data in _ARMS.items():
        for way in chosen(WAYS, backend="iga"):
            own = way.of(data)
            yield Run(name, way, OfScene(own), dense(own), tolerance=1e-6)
