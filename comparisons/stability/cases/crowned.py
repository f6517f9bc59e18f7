"""A crowned face, from one that no rounding tells from a flat one to one that is refused."""

from collections.abc import Iterator

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, changed, pad
from comparisons.stability.parts.ways import WAYS, chosen

_WIDTH, _HEIGHT = 0.5, 0.4
"""Of the pad of :func:`pad`, which is as high whatever its width."""
_FLAT = 1e-10
"""Part of the height by which a face falls that changes no digit looked at."""
_OVERHANG = ("node", "Greville", "GPTS, penalty", "segments, penalty", "mortar, penalty")


def _crowned(radius: float) -> Scene:
    """The pad with its face crowned, on its base."""
    flat = pad(_WIDTH)
    crowned = {
        "shape": "crowned",
        "base": flat["bodies"]["pad"]["geometry"],
        "surface": "y_min",
        "radii": {"x": radius},
    }
    return changed(flat, {"bodies.pad.geometry": crowned})


@case("A crowned face, its radius of curvature from 0.05 to 1e30", subject="geometry")
def crowned() -> Iterator[Run]:
    """Nearly flat it is the flat one; where it leaves the other side, a run says so."""
    for radius in (1e4, 1e6, 1e8, 1e12, 1e30):
        fall = _WIDTH**2 / (8 * radius) / _HEIGHT
        for way in WAYS:
            flat = dense(way.of(pad(_WIDTH)))
            tolerance = max(1e-8, 10 * fall if fall > _FLAT else 0.0)
            problem = OfScene(way.of(_crowned(radius)))
            yield Run(f"radius {radius:.0e}", way, problem, flat, tolerance=tolerance)
    for way in chosen(WAYS, *_OVERHANG):
        data = way.of(changed(_crowned(0.5), {"contacts.contact.reach": 0.3}))
        apart = dense({**data, "contacts": {}})
        yield Run("radius 0.5, closed", way, OfScene(data), apart, ("warned", "refused"))
        yield Run("radius 0.05", way, OfScene(way.of(_crowned(0.05))), None, REFUSED, names="radii")
