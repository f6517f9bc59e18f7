"""Friction coefficient at which flutter begins, for named problems.

mu_critical("blocks", p=1, max_frequency=3.5)
mu_critical("hoffmann", k3="1.5")
"""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.errors import ConvergenceError, InputError
from exact_cea import galerkin_problems, lumped
from exact_cea.blocks import Blocks
from exact_cea.exceptional_points import exceptional_points
from exact_cea.galerkin import lowest_in
from exact_cea.material import Material
from exact_cea.numbers import Exact
from exact_cea.reference import Number, make_problem

_GROWING = 1e-5
"""Growth rate relative to abs(lambda) above which a mode counts as growing."""
_BRACKET = 1e-3
"""Relative width to which the coarse discretisation bisects the bracket."""
_DRIFT = 0.05
"""Relative distance from the bracket beyond which the secant method fails."""


def mu_critical(
    problem: str,
    *,
    max_frequency: float | None = None,
    mu_max: float = 1.0,
    m: int | None = None,
    **parameters: Number | Material | None,
) -> float:
    """Return the smallest friction coefficient, or amplitude, at which a mode begins to grow.

    Circular problems flutter at any friction, because their modes are degenerate pairs, except for
    m = 0, which never flutters. Blocks lose stability at an exceptional point, computed to double
    precision for sinusoidal and to 10 digits for constant friction. Lumped systems have closed
    forms.

    Parameters
    ----------
    problem
        As in ``exact_eigenvalues``, or "hoffmann" or "hulten".
    max_frequency
        Blocks only: highest angular frequency.
    mu_max
        Blocks only: highest friction. Constant friction is sampled at 20 values: flutter that
        begins and ends between two of them is missed.
    m, parameters
        As in ``exact_eigenvalues``; for lumped systems ``k11``, ``k12``, ``k22``, ``k3`` or ``k1``,
        ``k2``, ``c1``, ``c2``.

    Returns
    -------
    float
        Infinity if no mode grows up to ``mu_max``.

    Raises
    ------
    InputError
        As in ``exact_eigenvalues``, or if blocks have no ``max_frequency``.
    """
    if problem == "hoffmann":
        return float(lumped.hoffmann_threshold(**_known(parameters, "k11", "k12", "k22", "k3")))
    if problem == "hulten":
        return float(lumped.hulten_threshold(**_known(parameters, "k1", "k2", "c1", "c2"))[0])
    chosen = make_problem(problem, m=m, **parameters)
    if not isinstance(chosen, Blocks):
        return 0.0 if chosen.m else math.inf
    for name, value in (("max_frequency", max_frequency), ("mu_max", mu_max)):
        if value is None or not 0 < value < math.inf:
            raise InputError(name, value, "a positive number")
    assert max_frequency is not None
    first = _first_sine if problem == "blocks" else _first_constant
    return first(chosen, float(mu_max), float(max_frequency))


def _known(parameters: dict[str, Any], *names: str) -> dict[str, Any]:
    for name, value in parameters.items():
        if name not in names:
            raise InputError(name, value, f"one of {', '.join(names)}")
    return parameters


@cache
def _first_sine(blocks: Blocks, mu_max: float, max_frequency: float) -> float:
    points = exceptional_points(blocks, mu_max, max_frequency)
    return float(points[0].mu_c) if points else math.inf


@cache
def _first_constant(blocks: Blocks, mu_max: float, max_frequency: float) -> float:
    """Bracket the threshold on a coarse discretisation, then solve for it on a fine one."""

    def growing(mu: float) -> NDArray[np.complex128]:
        values = _constant(blocks, mu, max_frequency, degree=12, layers=1)
        return values[values.real > _GROWING * abs(values)]

    trials = np.linspace(0, mu_max, 21)
    unstable = next((i for i, mu in enumerate(trials) if i and growing(float(mu)).size), 0)
    if not unstable:
        return math.inf
    low, high = float(trials[unstable - 1]), float(trials[unstable])
    while high - low > _BRACKET * high:
        middle = (low + high) / 2
        low, high = (low, middle) if growing(middle).size else (middle, high)
        if high < _BRACKET**2 * mu_max:
            return 0.0
    return _coalescence(blocks, low, high, abs(growing(high)[0].imag))


def _coalescence(blocks: Blocks, low: float, high: float, frequency: float) -> float:
    """Return the root of the squared difference of two ``kappa = lambda^2``, by secants.

    The eigenvalues have a square root singularity there. The squared difference is analytic in
    mu, real, and has a simple root (T. Kato, Perturbation Theory for Linear Operators, II.1).
    """

    def discriminant(mu: float) -> float:
        kappa = _constant(blocks, mu, 1.1 * frequency, degree=12, layers=4) ** 2
        x, y = kappa[np.argsort(abs(kappa + frequency**2))[:2]]
        return float(((x - y) ** 2).real)

    x, y = low, high
    at_x, at_y = discriminant(x), discriminant(y)
    for _ in range(12):
        x, y, at_x = y, y - at_y * (y - x) / (at_y - at_x), at_y
        if abs(y - high) > _DRIFT * high:
            break
        if abs(y - x) < 1e-12 * y or (at_y := discriminant(y)) == at_x:
            return y
    raise ConvergenceError(f"no coalescence found near mu = {high}, frequency {frequency}")


def _constant(
    blocks: Blocks, mu: float, max_frequency: float, degree: int, layers: int
) -> NDArray[np.complex128]:
    contact = galerkin_problems.blocks(
        replace(blocks, mu0=Exact(mu)), degree, layers, constant=True
    )
    return lowest_in(contact, blocks.scale(), max_frequency)
