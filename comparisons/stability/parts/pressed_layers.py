"""Layers pressed by normal compliance between rollers: pressure and closure are uniform."""

from collections.abc import Mapping
from typing import Any

from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import OPEN, PENALTY, SADDLE, Way

UNIFORM_WAYS = tuple(
    way
    for way in (*PENALTY, *SADDLE, *OPEN)
    if way.name.startswith(("GPTS,", "segments", "mortar")) and way.name != "mortar, saddle"
)
"""Those that pass a uniform pressure on meshes that match, and that a law can meet."""
STIFF = 1e5
"""p above which a penalty loses digits; bodies have E = 1."""
ALLOWED = ("over-constrained", "under-sampled", "short-modes", "point-rule")
"""Warnings that such runs may give."""
_BACK = {"surface": "y_max", "components": ["x"]}
_WALLS = [{"surface": f"x_{end}", "components": ["x"]} for end in ("min", "max")]


def pressed_layers(way: Way, pressure: float, *, degree: int = 2, **law: Any) -> dict[str, Any]:
    """Layers of which a pressure on its back presses the upper one on the lower one.

    Parameters
    ----------
    way
        Backend and formulation.
    pressure
        On the back of the upper layer (N/m^2).
    degree
        Of both meshes.
    law
        Fields of the contact.
    """
    meshes = {"degree": degree}
    data = way.of(layers(p=1.0, mu=0.0, lower_elements=(5, 3), upper=meshes, lower=meshes))
    del data["contacts"]["interface"]["p"]
    data["contacts"]["interface"] |= law
    data["bodies"]["upper"]["supports"] = [_BACK, *_WALLS]
    return data | {"loads": [{"surface": "upper.y_max", "pressure": pressure}]}


def uniform(data: Mapping[str, Any], p: float) -> dict[str, Any]:
    """The same where p is known."""
    interface = dict(data["contacts"]["interface"])
    for name in ("c_n", "m_n"):
        interface.pop(name, None)
    known = changed(data, {"contacts.interface": interface | {"p": p}}) | {"loads": []}
    for name in ("load_steps", "geometric_stiffness"):
        known["analysis"].pop(name, None)
    return known
