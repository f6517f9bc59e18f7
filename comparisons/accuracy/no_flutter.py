"""Problems that cannot flutter: what grows there is a fault of the contact rule.

Layers that mirror each other (even modes load the contact, odd ones slide, and friction couples
them one way only), and axisymmetric modes of the drum, on which friction does no work.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from comparisons.accuracy.cases import method_of, methods, scene_of
from comparisons.accuracy.problems import PROBLEMS, BodyMesh, Problem
from comparisons.study.session import Session
from comparisons.study.study import Case
from scenes import run_modes
from scenes.results.matching import circumferential_orders

_REFINEMENT = 3
"""Mesh of these problems."""


@dataclass(frozen=True)
class NoFlutter:
    """A problem that cannot flutter: changes of its scene, and the order of the modes looked at."""

    problem: Problem
    changes: dict[str, Any] = field(default_factory=dict)
    order: int | None = None


_LAYERS = (
    BodyMesh("upper", (4, 1), (False, False), (True, False)),
    BodyMesh("lower", (4, 1), (False, False), (True, False)),
)
NO_FLUTTER = {
    "layers that mirror each other": NoFlutter(
        replace(PROBLEMS["blocks"], bodies=_LAYERS, mu=0.9),
        {
            "bodies.lower.geometry": {
                "shape": "rectangle",
                "size": [2, 0.5],
                "origin": [0, -0.5],
            },
            "bodies.lower.material": {"E": 0.1, "nu": 0.25, "rho": 0.35},
        },
    ),
    "drum, m = 0": NoFlutter(replace(PROBLEMS["drum"], mu=0.9), order=0),
}
"""Problems that cannot flutter, by name."""


def cases() -> Iterator[Case]:
    """Every problem with every contact rule on both backends, elements of degree 2."""
    for name in NO_FLUTTER:
        for method in methods():
            if method.degree == 2:
                yield {"problem": name, "p": 1.0, **vars(method)}


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Largest abs(Re lambda) over abs(lambda), what residual times condition explains of it there.

    ``unexplained`` modes grow or decay by more than that.
    """
    each = NO_FLUTTER[case["problem"]]
    scene = scene_of(each.problem, method_of(case), _REFINEMENT, case["p"], each.changes)
    result = run_modes(scene)
    modes = result.modes
    chosen = np.ones(len(modes.eigenvalues), bool)
    if each.order is not None:
        chosen = circumferential_orders(result).orders == each.order
    size = np.abs(modes.eigenvalues[chosen])
    rates, explained = np.abs(modes.growth_rates[chosen]), modes.growth_uncertainties[chosen]
    worst = int(np.argmax(rates / size))
    row = {
        "modes": len(size),
        "growth": float(rates[worst] / size[worst]),
        "explained": float(explained[worst] / size[worst]),
        "unexplained": int(np.sum(rates > explained)),
    }
    return {"no_flutter": [row]}
