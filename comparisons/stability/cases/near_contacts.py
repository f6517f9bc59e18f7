"""Friction bounded by what lies near the contacts, from soft and slight to stiff and strong."""

from collections.abc import Iterator
from itertools import product

from comparisons.stability.parts.case import WARNED, Run, case
from comparisons.stability.parts.parted import OfParts
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import changed, pad
from comparisons.stability.parts.ways import WAYS, chosen

_STIFFNESSES = (1e-3, 1.0, 1e4, 1e9)
_FRICTIONS = (0.3, 3.0)
_CONTRASTS = (1e-4, 1e4)


@case("Friction bounded by the part of the bodies near it", subject="friction and spectra")
def near_contacts() -> Iterator[Run]:
    """Windows are those of dense solves, whether the part says enough or the whole is asked.

    Eliminated forces of a stiff contact lose digits, and say so.
    """
    ways = [
        way
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar, saddle")
        if way.backend == "fe"
    ]
    scenes = {
        f"p = {p:g} N/m³, μ = {mu:g}": pad(0.3, 0.4, base_elements=(14, 6), p=p, mu=mu)
        for p, mu in product(_STIFFNESSES, _FRICTIONS)
    }
    for factor in _CONTRASTS:
        data = pad(0.3, 0.4, base_elements=(14, 6), p=1.0, mu=1.0)
        changes = {"bodies.pad.material.E": 0.5 * factor, "bodies.pad.material.rho": factor}
        scenes[f"pad {factor:g} times as stiff and heavy"] = changed(data, changes)
    for (row, data), way in product(scenes.items(), ways):
        data = way.of(data)
        yield Run(row, way, OfParts(data), dense(data), WARNED)
