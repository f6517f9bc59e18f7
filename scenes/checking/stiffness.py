"""How stiff a contact is beside its bodies, and from where on point rules are too crude for it."""

from collections.abc import Sequence
from math import inf

from cea.contact.contact import Contact
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_COLLOCATION: dict[tuple[str, int], float] = {
    ("equal", 2): 600.0,  # abscissae of NURBS: 2 % at 60, 0.02 % at 6000
    ("equal", 3): inf,
    ("area", 3): inf,  # 3 to 90 % from 0.1 to 1100; in the plane about 1 %
    ("nodes", 2): 30.0,  # nodes of equal weights: 10 % at 6, 0.9 % at 60
    ("nodes", 3): 30.0,
    ("grid", 2): 30.0,  # 9 % at 6, 0.5 % at 60
    ("grid", 3): 600.0,  # 5 % at 11, 0.7 % at 1100
}
"""Relative stiffness of a contact below which points of a rule are too crude, by dimension."""
_LUMPED: dict[tuple[str, int], float] = {
    ("iga", 2): 0.0,  # 2 % at 0.6, 9 % at 6, 70 % at 60
    ("iga", 3): 0.0,
    ("fe", 2): 60.0,  # 0.5 % at 60, 11 % at 6000
    ("fe", 3): 3.0,  # 0.8 % at 1, modes lost at 11
}
"""The same above which lumping is too crude, by backend of side a and dimension.

Both are errors of growth rates in `uses.csv` of `cea study accuracy`, where p in units of each
problem is a relative stiffness of 6 in blocks and drum, of 1 in ring.
"""


def limit_of(scene: Scene, spec: ContactSpec) -> float:
    """Relative stiffness below which a rule of points is too crude, above which lumping is."""
    side, rule = scene.bodies[spec.a.split(".")[0]], spec.formulation
    if rule.coupling == "lumped":
        return _LUMPED[side.backend, side.dim]
    weights = getattr(rule, "weights", "")
    of_nodes = {"node_to_surface/equal": "nodes", "grid/": "grid"}
    abscissae = weights if rule.method in ("greville", "botella") else ""
    kind = of_nodes.get(f"{rule.method}/{weights}", abscissae)
    return _COLLOCATION.get((kind, side.dim), 0.0)


def relative_stiffness(scene: Scene, halves: Sequence[Contact]) -> float:
    """P (L_a / E_a + L_b / E_b): how much more the bodies yield than the contact.

    L is the least length of a body, or the width of the contact where that is less; p the mean
    contact stiffness (N/m^3).
    """
    half, compliance = halves[0], 0.0
    width = float(half.interface.points.weight.sum()) ** (1 / (half.interface.a.dim - 1))
    for name in (half.a, half.b):
        body = scene.bodies[name]
        compliance += min(*body.lengths, width) / body.material.means[0]
    return mean_stiffness(halves) * compliance


def mean_stiffness(halves: Sequence[Contact]) -> float:
    """Mean contact stiffness p (N/m^3), of steady sliding where a law makes it, open parts too."""
    return sum(half.P / float(half.interface.points.weight.sum()) for half in halves)
