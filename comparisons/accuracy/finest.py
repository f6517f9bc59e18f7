"""Finest meshes: how many digits of exact eigenvalues each backend reaches.

High degree and few elements, as many along each direction as its shortest waves need. Contact is
mortar, but for the ring: there segments do as well, for its contact is soft, and keep the stiffness
sparse.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import product
from math import pi
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.matching import match_spectrum
from cea.eigen.modes import Modes
from exact_cea.reference import exact_eigenvalues
from scenes import run_modes
from scenes.spec.body import Backend
from scenes.spec.reading import load_scene

Data = dict[str, Any]

_REACH = 1e-3
"""Relative distance of partners; far above every error, far below most gaps."""
_MARGIN = 1.02
"""Upper end of the search relative to the highest eigenvalue compared."""


@dataclass(frozen=True)
class Finest:
    """Meshes and the digits asked of them.

    Parameters
    ----------
    problem
        Name of the scene.
    backend, degree
        Discretisation of both bodies.
    elements
        Elements of each body along each direction.
    bound
        Relative error of lambda that is asked for.
    formulation
        Formulation of contact.
    through
        Coordinates of element boundaries by body and direction, where they are not even.
    """

    problem: str
    backend: Backend
    degree: int
    elements: Mapping[str, tuple[int, ...]]
    bound: float
    formulation: str = "mortar"
    through: Mapping[str, Mapping[str, tuple[float, ...]]] = field(default_factory=dict)

    def overrides(self) -> list[str]:
        """Meshes and formulation as fields of the scene, as ``path=value``."""
        return [
            *(f"bodies.{body}.mesh.{self.backend}={self._mesh(body)}" for body in self.elements),
            f"contacts.interface.formulation={{method = '{self.formulation}'}}",
        ]

    def _mesh(self, body: str) -> str:
        elements = list(self.elements[body])
        dim = len(elements)
        boundaries = [f"{d} = {list(x)}" for d, x in self.through.get(body, {}).items()]
        shared = f"elements = {elements}, through = {{{', '.join(boundaries)}}}"
        if self.backend == "iga":
            return f"{{degree = {[self.degree] * dim}, {shared}}}"
        cell = {2: "quadrilateral", 3: "hexahedron"}[dim]
        return f"{{cell = '{cell}', degree = {self.degree}, {shared}}}"


@dataclass(frozen=True)
class Compared:
    """Eigenvalues that are compared: some of every harmonic, at some stiffness and friction.

    Parameters
    ----------
    solver
        Name of the problem of :mod:`exact_cea.reference`.
    orders
        Circumferential orders; None stands for the one harmonic of the blocks.
    stiffnesses
        Contact stiffnesses p, each with the highest Im lambda that is compared.
    frictions
        Friction coefficients or amplitudes.
    friction
        The friction coefficient in the scene, with ``{mu}`` for the number.
    count
        Lowest eigenvalues of each order that are compared; None compares all to the highest.
    """

    solver: str
    orders: tuple[int | None, ...]
    stiffnesses: Mapping[float, float]
    frictions: tuple[float, ...]
    friction: str = "{mu}"
    count: int | None = None

    def families(self, p: float, mu: float) -> dict[str, Complexes]:
        """Exact eigenvalues by harmonic, those of m and -m as one."""
        found = {}
        for m in self.orders:
            reach: Data = (
                {"max_frequency": self.stiffnesses[p]}
                if self.count is None
                else {"count": self.count}
            )
            values = exact_eigenvalues(self.solver, m=m, p=p, mu=mu, **reach)
            found["all" if m is None else f"m = {m}"] = both_signs(values, m)
        return found


def both_signs(values: Complexes, m: int | None) -> Complexes:
    """Eigenvalues of the orders m and -m; of order 0 or none, as they are."""
    return np.concatenate([values, -values.conj()]) if m else values


COMPARED = {
    "drum": Compared("drum", (1, 2, 3, 4, 5, 6), {0.1: 14.1, 1.0: 12.5, 1000.0: 12.5}, (0.3, 0.7)),
    "blocks": Compared(
        "blocks",
        (None,),
        {0.1: 3.65, 1.0: 2.95, 10.0: 3.65, 1000.0: 3.65},
        (0.3, 0.7, 1.0),
        "'{mu}*sin(pi*x/2)'",
    ),
    "ring": Compared("ring", (1, 2, 3, 4, 5, 6), {1e12: 2.21e5}, (0.3, 0.7), count=6),
}
"""What is compared of each problem: the lists of the reference files, the blocks at more p."""

FINEST = (
    Finest("drum", "iga", 8, {"outer": (19, 48), "inner": (13, 52)}, 1e-10),
    Finest("drum", "fe", 4, {"outer": (24, 56), "inner": (17, 60)}, 1e-8),
    Finest("blocks", "iga", 8, {"upper": (23, 6), "lower": (16, 8)}, 1e-10),
    Finest("blocks", "fe", 4, {"upper": (28, 7), "lower": (17, 8)}, 1e-8),
    Finest("ring", "iga", 5, {"pad": (8, 40, 1), "disc": (8, 36, 1)}, 1e-6, "segments"),
    Finest(
        "ring",
        "fe",
        4,
        {"pad": (4, 28, 2), "disc": (6, 32, 2)},
        1e-6,
        "segments",
        through={"disc": {"z": (-0.007,)}},
    ),
)
"""The finest meshes."""


def run_finest(
    chosen: Iterable[Finest] = FINEST, progress: Callable[[str], None] = lambda _: None
) -> list[Data]:
    """Run finest meshes at every stiffness and friction they are compared at.

    Returns
    -------
    list
        Plain data of each run, see :func:`measure`.
    """
    runs = []
    for finest in chosen:
        compared = COMPARED[finest.problem]
        for p, mu in product(compared.stiffnesses, compared.frictions):
            progress(f"{finest.problem}, {finest.backend} {finest.degree}, p = {p:g}, mu = {mu:g}")
            runs.append(measure(finest, p, mu, compared.families(p, mu)))
    return runs


def measure(finest: Finest, p: float, mu: float, families: Mapping[str, Complexes]) -> Data:
    """Errors of one run against exact eigenvalues.

    Parameters
    ----------
    finest
        The meshes.
    p, mu
        Contact stiffness (N/m^3), friction coefficient or its amplitude.
    families
        Exact eigenvalues by name of their harmonic.

    Returns
    -------
    dict
        The case, ``dofs``, ``seconds``, ``modes`` found, ``compared``, ``errors`` as the worst of
        each family (None where one was not found), ``worst``, and the largest ``residual`` and
        ``condition`` of all modes.
    """
    start = perf_counter()
    highest = max(float(values.imag.max()) for values in families.values())
    dofs, modes = solve(finest, p, mu, _MARGIN * highest)
    matches = {
        name: match_spectrum(modes.eigenvalues, values, (0.0, _MARGIN * highest), reach=_REACH)
        for name, values in families.items()
    }
    errors = {
        name: None if len(match.missing) else float(match.errors.max())
        for name, match in matches.items()
    }
    known = [error for error in errors.values() if error is not None]
    return {
        "problem": finest.problem,
        "backend": finest.backend,
        "degree": finest.degree,
        "formulation": finest.formulation,
        "elements": {name: list(n) for name, n in finest.elements.items()},
        "bound": finest.bound,
        "p": p,
        "mu": mu,
        "dofs": dofs,
        "seconds": perf_counter() - start,
        "modes": len(modes.eigenvalues),
        "compared": sum(len(match.exact) for match in matches.values()),
        "errors": errors,
        "worst": max(known) if len(known) == len(errors) else None,
        "residual": float(modes.residuals.max()),
        "condition": float(modes.conditions.max()),
    }


def solve(finest: Finest, p: float, mu: float, highest: float) -> tuple[int, Modes]:
    """Degrees of freedom and modes up to a highest Im lambda."""
    overrides = [
        *finest.overrides(),
        f"contacts.interface.p={p!r}",
        f"contacts.interface.mu={COMPARED[finest.problem].friction.format(mu=mu)}",
        f"analysis.max_frequency={highest / (2 * pi)!r}",
    ]
    result = run_modes(load_scene(Path(finest.problem), overrides, finest.backend))
    return result.system.size, result.modes
