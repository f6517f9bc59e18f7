"""Contacts of which a part has lifted off: p is zero there, and friction with it."""

from collections.abc import Iterator

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS

_ZONES = {
    "one end lifted": "where(x < 0.7, 0, {p!r})",
    "both ends lifted": "where(abs(x - 1) > 0.55, 0, {p!r})",
    "the middle lifted": "where(abs(x - 1) < 0.55, 0, {p!r})",
    "all but a corner lifted": "where(x < 1.93, 0, {p!r})",
    "p falls to zero": "{p!r}*maximum(1.1 - x, 0)",
}
"""Closed parts that end inside of elements of either side."""

_SLIVERS = ("one end lifted", "all but a corner lifted")


@case("Contact that has lifted off in part: p is zero there", subject="contact stiffness")
def lift_off() -> Iterator[Run]:
    """What is open takes part in nothing, whatever the formulation and its form."""
    for p, zones in ((1.0, tuple(_ZONES)), (1e4, _SLIVERS)):
        for word in zones:
            field = _ZONES[word]
            for way in WAYS:
                data = way.of(layers(p=field.format(p=p)))
                row = f"{word}, p to {p:.0e}"
                yield Run(row, way, OfScene(data), dense(data), tolerance=1e-7)
    for word, field in (("lifted everywhere", "0*x"), ("negative", "x - 0.5")):
        for way in WAYS:
            yield Run(word, way, OfScene(way.of(layers(p=field))), None, REFUSED, names="p")
