"""Problems that cannot flutter, with every contact rule: what grows there is a fault of the rule.

Two layers that mirror each other: even modes load the contact, odd ones slide, and friction
couples them one way only. Axisymmetric modes of the drum: friction does no work on them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.accuracy.problems import PROBLEMS, BodyMesh, Problem
from comparisons.accuracy.study import RULES, Case, Method, overrides
from scenes import run_modes
from scenes.results.matching import circumferential_orders
from scenes.spec.reading import load_scene

Data = dict[str, Any]

_DEGREE = 2
_REFINEMENT = 3


@dataclass(frozen=True)
class NoFlutter:
    """A problem that cannot flutter.

    Parameters
    ----------
    label
        Its name, as shown.
    problem
        Scene, meshes, friction and highest frequency.
    changes
        Fields of the scene that make it so, as ``path=value``.
    order
        Circumferential order of the modes that are looked at; None looks at all.
    """

    label: str
    problem: Problem
    changes: tuple[str, ...] = ()
    order: int | None = None


def _layer(name: str) -> BodyMesh:
    return BodyMesh(name, (4, 1), (False, False), (True, False))


NO_FLUTTER = (
    NoFlutter(
        "layers that mirror each other",
        Problem(
            "blocks",
            (_layer("upper"), _layer("lower")),
            band=(0.0, 3.3),
            mu=0.9,
            solver="blocks",
            profile="{mu}*abs(sin(pi*x/2))",
        ),
        (
            "bodies.lower.geometry={ shape = 'rectangle', size = [2, 0.5], origin = [0, -0.5] }",
            "bodies.lower.material={ E = 0.1, nu = 0.25, rho = 0.35 }",
        ),
    ),
    NoFlutter(
        "drum, m = 0",
        Problem("drum", PROBLEMS["drum"].bodies, band=(0.0, 2.5), mu=0.9, solver="drum"),
        order=0,
    ),
)
"""Problems that cannot flutter."""


def run_no_flutter(progress: Callable[[str], None] = lambda _: None) -> list[Data]:
    """Run every problem with every contact rule on both backends, elements of degree 2.

    Returns
    -------
    list
        Plain data of each run, see :func:`measure`.
    """
    runs = []
    for each in NO_FLUTTER:
        for rule in RULES.values():
            for backend in rule.backends:
                method = Method(backend, _DEGREE, rule.key)
                progress(f"{each.label}, {method.label}")
                runs.append(measure(each, method))
    return runs


def measure(each: NoFlutter, method: Method, refinement: int = _REFINEMENT) -> Data:
    """Growth of a problem that cannot flutter.

    Returns
    -------
    dict
        ``problem``, ``method``; ``modes`` looked at; ``growth``, the largest abs(Re lambda) over
        abs(lambda); ``rounding``, what residual times condition explains of it there; and
        ``unexplained``, modes that grow or decay by more than that.
    """
    case = Case(each.problem.name, method, refinement, 1.0)
    fields = [*each.changes, *overrides(each.problem, case)]
    result = run_modes(load_scene(Path(each.problem.name), fields, method.backend))
    modes = result.modes
    chosen = np.ones(len(modes.eigenvalues), bool)
    if each.order is not None:
        chosen = circumferential_orders(result).orders == each.order
    size = np.abs(modes.eigenvalues[chosen])
    growth = np.abs(modes.growth_rates[chosen])
    rounding = modes.growth_uncertainties[chosen]
    worst = int(np.argmax(growth / size))
    return {
        "problem": each.label,
        "method": case.described()["method"],
        "modes": len(size),
        "growth": float(growth[worst] / size[worst]),
        "rounding": float(rounding[worst] / size[worst]),
        "unexplained": int(np.sum(growth > rounding)),
    }
