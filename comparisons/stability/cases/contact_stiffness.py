"""Contact stiffness from next to nothing to infinity."""

from collections.abc import Iterator
from math import inf

from comparisons.stability.parts.case import ACCURATE, HONEST, MESH_AND_PENALTY, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import OPEN, PENALTY, SADDLE

_STIFFNESSES = (1e-6, 1.0, 1e6, 1e10, 1e14, 1e20, 1e25)
_HARMLESS = 1e6
"""P up to which a penalty costs no more digits than the tolerance leaves; bodies have E = 1."""
_LUMPED = 1e6
"""P up to which lumped contact, which has no other form, has a reference with digits."""


@case("Contact stiffness P from 1e-6 to 1e25 N/m and infinite", subject="contact stiffness")
def contact_stiffness() -> Iterator[Run]:
    """The saddle form loses nothing; a penalty loses digits as P grows, and must say so."""
    for P in _STIFFNESSES:
        for way in (*PENALTY, *SADDLE, *OPEN):
            if P > _LUMPED and "lumped" in way.name:
                continue
            may_lose = P > _HARMLESS and way in PENALTY
            data, expected = way.of(layers(P=P)), HONEST if may_lose else ACCURATE
            about = f"P = {P:.0e} N/m", way, OfScene(data), dense(data), expected
            yield Run(*about, warnings=MESH_AND_PENALTY)
    for way in (*SADDLE, *OPEN):
        data = way.of(layers(P=inf))
        yield Run("P infinite", way, OfScene(data), dense(data))
