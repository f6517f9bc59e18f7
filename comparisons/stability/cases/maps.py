"""Values of a map, between the full solves that it rests on."""

from collections.abc import Iterator

import numpy as np

from comparisons.stability.parts.case import HONEST, Run, case
from comparisons.stability.parts.mapped import OfMap
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import SADDLE, WAYS, chosen

_MU, _P = "contacts.interface.mu", "contacts.interface.P"
_FRICTIONS = (0.0, 0.5, 1.0)


@case("Maps of friction and contact stiffness by a reduced model", subject="friction and spectra")
def maps() -> Iterator[Run]:
    """Between full solves over eight decades of P all is as dense solves say.

    Where a contact is 1e11 times as stiff as its bodies, forces eliminated lose their digits, and
    the bounds say so.
    """
    decades = {_MU: _FRICTIONS, _P: tuple(np.geomspace(1e-3, 1e5, 9).tolist())}
    for P, mu in ((0.02, 0.3), (7.0, 0.83), (3e3, 0.61)):
        for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
            data = way.of(layers(P=P, mu=mu))
            yield Run(f"P = {P:g} N/m, μ = {mu:g}", way, OfMap(data, decades), dense(data))
    stiff = {_MU: _FRICTIONS, _P: tuple(np.geomspace(1e6, 1e14, 9).tolist())}
    for way in chosen(SADDLE, "GPTS, saddle", "mortar, saddle"):
        data = way.of(layers(P=2e11, mu=0.83))
        yield Run("P = 2e+11 N/m, μ = 0.83", way, OfMap(data, stiff), dense(data), HONEST)
