"""Formulations beside exact eigenvalues: what some of them do to growth."""

from collections.abc import Iterator

from comparisons.stability.parts.case import ACCURATE, HONEST, MESH, NONE, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import exact
from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import WAYS

_FREQUENCY = 0.42
_TRUSTED = "mortar"
"""What must be right at any contact stiffness; of the others some are not, and must say so."""


@case("Every formulation beside exact eigenvalues", subject="contact stiffness")
def formulations() -> Iterator[Run]:
    """Collocation and lumping change growth by tens of per cent at some stiffnesses."""
    fields = {"degree": 3}
    for p in (1e-2, 1.0, 1e2, 1e4):
        scene = layers(
            upper=fields,
            lower=fields,
            upper_elements=(8, 3),
            lower_elements=(7, 4),
            p=p,
            mu="1.0*abs(sin(pi*x/2))",
        )
        true = exact("blocks", max_frequency=_FREQUENCY, p=p, mu="1.0")
        for way in WAYS:
            trusted = way.name.startswith(_TRUSTED)
            data = changed(way.of(scene), {"analysis.max_frequency": _FREQUENCY})
            yield Run(
                f"p = {p:.0e} N/m³",
                way,
                OfScene(data),
                true,
                ACCURATE if trusted else HONEST,
                tolerance=1e-2,
                warnings=MESH if trusted else NONE,
            )
