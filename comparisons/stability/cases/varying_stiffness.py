"""Contact stiffness that varies over the interface by powers of ten."""

from collections.abc import Iterator

from comparisons.stability.parts.case import ACCURATE, HONEST, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import PENALTY, SADDLE

_ACROSS = {
    "jumps": "where(x < 1, 1.0, {ratio!r})",
    "grows": "exp(x/2*log({ratio!r}))",
}


@case("Contact stiffness p that varies by 1e4 to 1e15", subject="contact stiffness")
def varying_stiffness() -> Iterator[Run]:
    """The soft part keeps its stiffness beside the stiff one, the stiff one beside the soft."""
    for ratio in (1e4, 1e8, 1e12, 1e15):
        for word, field in _ACROSS.items():
            for way in (*PENALTY, *SADDLE):
                data = way.of(layers(p=field.format(ratio=ratio)))
                may_lose = ratio > 1e4 and way.contact["form"] == "penalty"
                yield Run(
                    f"p {word} by {ratio:.0e}",
                    way,
                    OfScene(data),
                    dense(data),
                    HONEST if may_lose else ACCURATE,
                    tolerance=1e-7,
                )
