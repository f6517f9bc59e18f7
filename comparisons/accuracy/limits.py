"""Where nothing may grow, and how many digits the finest meshes reach.

Two problems cannot flutter, so what grows there is a fault of the contact rule: layers that mirror
each other (even modes load the contact, odd ones slide, and friction couples them one way only),
and axisymmetric modes of the drum, on which friction does no work.

The finest meshes have a high degree and few elements, as many along each direction as its shortest
waves need. Contact is mortar, but for the ring: there segments do as well, for its contact is soft,
and keep the stiffness sparse.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.matching import match_spectrum
from comparisons.accuracy.cases import Method, method_of, methods, scene_of
from comparisons.accuracy.problems import PROBLEMS, BodyMesh, Problem
from comparisons.study.session import Session
from comparisons.study.study import Case
from exact_cea.reference import exact_eigenvalues
from scenes import run_modes
from scenes.results.matching import circumferential_orders
from scenes.spec.body import Backend
from scenes.spec.reading import Scene, load_scene

_REFINEMENT = 3
"""Mesh of the problems that cannot flutter."""
_REACH = 1e-3
"""Relative distance of partners; far above every error, far below most gaps."""
_MARGIN = 1.02
"""Upper end of the search relative to the highest eigenvalue compared."""


@dataclass(frozen=True)
class NoFlutter:
    """A problem that cannot flutter: changes of its scene, and the order of the modes looked at."""

    problem: Problem
    changes: Mapping[str, Any] = field(default_factory=dict)
    order: int | None = None


_LAYERS = (
    BodyMesh("upper", (4, 1), (False, False), (True, False)),
    BodyMesh("lower", (4, 1), (False, False), (True, False)),
)
NO_FLUTTER = {
    "layers that mirror each other": NoFlutter(
        Problem("blocks", _LAYERS, (0.0, 3.3), 0.9, "blocks", profile="{mu}*abs(sin(pi*x/2))"),
        {
            "bodies.lower.geometry": {
                "shape": "rectangle",
                "size": [2, 0.5],
                "origin": [0, -0.5],
            },
            "bodies.lower.material": {"E": 0.1, "nu": 0.25, "rho": 0.35},
        },
    ),
    "drum, m = 0": NoFlutter(
        Problem("drum", PROBLEMS["drum"].bodies, (0.0, 2.5), 0.9, "drum"), order=0
    ),
}
"""Problems that cannot flutter, by name."""


def no_flutter_cases() -> Iterator[Case]:
    """Every problem with every contact rule on both backends, elements of degree 2."""
    for name in NO_FLUTTER:
        for method in methods():
            if method.degree == 2:
                yield {"problem": name, "p": 1.0, **vars(method)}


def growth(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Growth in a problem that cannot flutter.

    Returns
    -------
    dict
        Rows of ``no_flutter``: ``modes`` looked at; ``growth``, the largest abs(Re lambda) over
        abs(lambda); ``explained``, what residual times condition explains of it there; and
        ``unexplained``, modes that grow or decay by more than that.
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


@dataclass(frozen=True)
class Finest:
    """Elements of each body, their boundaries where not even, and the error asked of lambda."""

    problem: str
    method: Method
    elements: Mapping[str, tuple[int, ...]]
    bound: float
    through: Mapping[str, Mapping[str, tuple[float, ...]]] = field(default_factory=dict)

    def scene(self, p: float, friction: float | str, highest: float) -> Scene:
        """The scene with modes up to a highest Im lambda."""
        backend = self.method.backend
        changes: dict[str, Any] = {
            f"bodies.{body}.mesh.{backend}": self._mesh(body) for body in self.elements
        }
        changes["contacts.interface.formulation"] = {"method": self.method.rule}
        changes["contacts.interface.p"] = p
        changes["contacts.interface.mu"] = friction
        changes["analysis.max_frequency"] = highest / (2 * pi)
        return load_scene(self.problem, backend=backend).change(changes)

    def _mesh(self, body: str) -> dict[str, Any]:
        elements, degree = list(self.elements[body]), self.method.degree
        through = {d: list(x) for d, x in self.through.get(body, {}).items()}
        mesh = {"elements": elements, "through": through}
        if self.method.backend == "iga":
            return mesh | {"degree": [degree] * len(elements)}
        cell = {2: "quadrilateral", 3: "hexahedron"}[len(elements)]
        return mesh | {"cell": cell, "degree": degree}


@dataclass(frozen=True)
class Compared:
    """Eigenvalues compared, by order: up to a highest Im lambda for each p, or so many."""

    solver: str
    orders: tuple[int | None, ...]
    stiffnesses: Mapping[float, float]
    frictions: tuple[float, ...]
    friction: str = ""
    count: int | None = None

    def families(self, p: float, mu: float) -> dict[str, Complexes]:
        """Exact eigenvalues by harmonic, those of m and -m as one."""
        reach: dict[str, Any] = {"max_frequency": self.stiffnesses[p]}
        if self.count is not None:
            reach = {"count": self.count}
        return {
            "all" if m is None else f"m = {m}": both_signs(
                exact_eigenvalues(self.solver, m=m, p=p, mu=mu, **reach), m
            )
            for m in self.orders
        }


def both_signs(values: Complexes, m: int | None) -> Complexes:
    """Eigenvalues of the orders m and -m; of order 0 or none, as they are."""
    return np.concatenate([values, -values.conj()]) if m else values


_ORDERS = (1, 2, 3, 4, 5, 6)
COMPARED = {
    "drum": Compared("drum", _ORDERS, {0.1: 14.1, 1.0: 12.5, 1000.0: 12.5}, (0.3, 0.7)),
    "blocks": Compared(
        "blocks",
        (None,),
        {0.1: 3.65, 1.0: 2.95, 10.0: 3.65, 1000.0: 3.65},
        (0.3, 0.7, 1.0),
        "{mu}*sin(pi*x/2)",
    ),
    "ring": Compared("ring", _ORDERS, {1e12: 2.21e5}, (0.3, 0.7), count=6),
}
"""What is compared of each problem: the lists of the reference files, the blocks at more p."""


def _finest(
    problem: str,
    backend: Backend,
    degree: int,
    elements: Mapping[str, tuple[int, ...]],
    bound: float,
    **more: Any,
) -> Finest:
    method = Method(backend, degree, "segments" if problem == "ring" else "mortar")
    return Finest(problem, method, elements, bound, **more)


FINEST = (
    _finest("drum", "iga", 8, {"outer": (19, 48), "inner": (13, 52)}, 1e-10),
    _finest("drum", "fe", 4, {"outer": (24, 56), "inner": (17, 60)}, 1e-8),
    _finest("blocks", "iga", 8, {"upper": (23, 6), "lower": (16, 8)}, 1e-10),
    _finest("blocks", "fe", 4, {"upper": (28, 7), "lower": (17, 8)}, 1e-8),
    _finest("ring", "iga", 5, {"pad": (8, 40, 1), "disc": (8, 36, 1)}, 1e-6),
    _finest(
        *("ring", "fe", 4, {"pad": (4, 28, 2), "disc": (6, 32, 2)}, 1e-6),
        through={"disc": {"z": (-0.007,)}},
    ),
)
"""The finest meshes."""


def finest_cases() -> Iterator[Case]:
    """Every finest mesh at every stiffness it is compared at."""
    for each in FINEST:
        for p in COMPARED[each.problem].stiffnesses:
            yield {"problem": each.problem, "p": p, **vars(each.method)}


def digits(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Errors on a finest mesh, a row for each friction coefficient."""
    of_case = (case["problem"], method_of(case))
    finest = next(each for each in FINEST if (each.problem, each.method) == of_case)
    compared = COMPARED[finest.problem]
    return {
        "finest": [
            {"mu": mu, **compare(finest, case["p"], mu, compared.families(case["p"], mu))}
            for mu in compared.frictions
        ]
    }


def compare(
    finest: Finest, p: float, mu: float, families: Mapping[str, Complexes]
) -> dict[str, Any]:
    """Errors of one run against exact eigenvalues by name of their harmonic.

    Returns
    -------
    dict
        ``dofs``, ``compared``, ``modes`` found, ``lambda_worst`` (None where one was not found),
        the ``bound`` asked for, ``seconds``, and the largest ``residual`` and ``condition``.
    """
    highest = _MARGIN * max(float(values.imag.max()) for values in families.values())
    friction = COMPARED[finest.problem].friction
    result = run_modes(finest.scene(p, friction.format(mu=mu) if friction else mu, highest))
    modes = result.modes
    matches = [
        match_spectrum(modes.eigenvalues, values, (0.0, highest), reach=_REACH)
        for values in families.values()
    ]
    lost = any(len(match.missing) for match in matches)
    return {
        "dofs": result.system.size,
        "compared": sum(len(match.exact) for match in matches),
        "modes": len(modes.eigenvalues),
        "lambda_worst": None if lost else max(float(match.errors.max()) for match in matches),
        "bound": finest.bound,
        "residual": float(modes.residuals.max()),
        "condition": float(modes.conditions.max()),
        "seconds": result.timer.total,
    }
