"""Exact eigenvalues of named problems as arrays, for tests and studies.

    exact_eigenvalues("drum", m=2, p=1, mu=0.3, count=3)
    exact_eigenvalues("blocks", p="inf", mu=0.7, kz="pi/2", max_frequency=3.0)
    whole_spectrum("drum", p=1, mu=0.3, max_frequency=3.0).orders

Materials are ``Material.of(E, nu, rho)``, sizes are the keywords of ``Drum.of``, ``Blocks.of`` and
``Ring.of``. Results are cached in the process and read-only.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import count as count_from
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError
from exact_cea import galerkin_problems
from exact_cea.blocks import Blocks
from exact_cea.drum import Drum
from exact_cea.galerkin import lowest_in
from exact_cea.galerkin_problems import Ring
from exact_cea.material import Material
from exact_cea.numbers import Exact, check_window, positive
from exact_cea.numbers import parameters as names_of_parameters
from exact_cea.solve import spectrum

Problem = Drum | Blocks | Ring
Number = str | float
Values = NDArray[np.complex128]

_DIGITS = 16

_PROBLEMS: dict[str, type[Problem]] = {"drum": Drum, "ring": Ring}
_PROBLEMS |= {"blocks": Blocks, "blocks_constant": Blocks}


@dataclass(frozen=True)
class WholeSpectrum:
    """Eigenvalues of whole bodies by rising frequency, each with its harmonic."""

    values: Values  # lambda with Im >= 0, shape (n,)
    orders: NDArray[np.int64]  # circumferential order m of each, of either sign; 0 in blocks
    families: NDArray[np.int64]  # number j of the family kz = j pi / depth; 0 is plane strain


def exact_eigenvalues(
    problem: str,
    *,
    max_frequency: float | None = None,
    count: int | None = None,
    m: int | None = None,
    **parameters: Number | Material | None,
) -> Values:
    """Return the eigenvalues lambda with Im >= 0 of one harmonic of a reference problem.

    Those of the drum and of blocks with sinusoidal friction are exact to double precision. Their
    list is complete, by the argument principle, for ``abs(Re)`` up to half of the highest
    frequency. Blocks with constant friction and the ring are accurate to 10 digits.

    Parameters
    ----------
    problem
        "drum", "blocks" (friction ``mu sin(pi x / length)``), "blocks_constant" (constant
        friction mu) or "ring".
    max_frequency, count
        Upper end of Im lambda, or number of lowest eigenvalues: exactly one of the two.
    m
        Circumferential order of drum and ring; -m changes the sign of Re lambda.
    parameters
        Contact stiffness per area ``p``, which may be "inf" (default 1, ring 1e12); friction
        ``mu`` (0.3); wave number ``kz`` in z of drum and blocks (None: plane strain); materials
        ``a`` and ``b``; and sizes: ``inner``, ``interface``, ``outer`` (drum);
        ``height_a``, ``height_b``, ``length`` (blocks); ``inner``, ``outer``, ``height_a``,
        ``height_b`` (ring).

    Returns
    -------
    ndarray
        Eigenvalues sorted by frequency, then growth, shape (n,); read-only.

    Raises
    ------
    InputError
        If the problem is unknown, has no such parameter, or a value is out of range.
    """
    check_window(max_frequency, count)
    chosen = make_problem(problem, m=m, **parameters)
    values = _eigenvalues(chosen, problem == "blocks_constant", max_frequency, count)
    return values if m is None or m >= 0 else _mirrored(values)


def whole_spectrum(
    problem: str,
    *,
    max_frequency: float,
    depth: Number | None = None,
    **parameters: Number | Material | None,
) -> WholeSpectrum:
    """Return all eigenvalues up to a frequency: orders m of both signs, all families in z.

    A discretisation of the whole bodies has this spectrum. Orders and families are enumerated
    beyond the wave number of shear waves at that frequency, until two in a row have no eigenvalue.

    Parameters
    ----------
    problem
        As in ``exact_eigenvalues``.
    max_frequency
        Upper end of Im lambda.
    depth
        Length in z between rollers (u_z = 0) of drum or blocks; None: plane strain.
    parameters
        As in ``exact_eigenvalues``.

    Raises
    ------
    InputError
        As in ``exact_eigenvalues``.
    """
    check_window(max_frequency, None)
    m = None if problem.startswith("blocks") else 0
    base = make_problem(problem, m=m, **parameters)
    if depth is not None and isinstance(base, Ring):
        raise InputError("depth", depth, "None: the ring is already three-dimensional")
    highest_k = max_frequency / min(base.a.wave_speeds[1], base.b.wave_speeds[1])
    parts: list[tuple[Values, int, int]] = []

    def harmonic(member: Problem, order: int, j: int) -> int:
        values = _eigenvalues(member, problem == "blocks_constant", max_frequency, None)
        parts.append((values, order, j))
        if order:
            parts.append((_mirrored(values), -order, j))
        return values.size

    def family(j: int) -> int:
        member = _family(base, j, depth)
        if isinstance(member, Blocks):
            return harmonic(member, 0, j)
        radius = float(member.interface if isinstance(member, Drum) else member.outer)
        return _series(lambda m: harmonic(replace(member, m=m), m, j), highest_k * radius)

    if depth is None:
        family(0)
    else:
        _series(family, highest_k * float(positive("depth", depth)) / pi)
    values = np.concatenate([values for values, _, _ in parts])
    orders = np.concatenate([np.full(values.size, m) for values, m, _ in parts])
    families = np.concatenate([np.full(values.size, j) for values, _, j in parts])
    rising = np.lexsort((orders, values.real, values.imag))
    return WholeSpectrum(values[rising], orders[rising], families[rising])


def make_problem(problem: str, *, m: int | None = None, **parameters: Any) -> Problem:
    """Return a problem by name, with abs(m); parameters are those of ``exact_eigenvalues``."""
    if problem not in _PROBLEMS:
        raise InputError("problem", problem, " or ".join(_PROBLEMS))
    kind = _PROBLEMS[problem]
    known = {"mu" if name == "mu0" else name for name in names_of_parameters(kind)}
    for name, value in parameters.items():
        if name not in known:
            raise InputError(name, value, f"one of {', '.join(sorted(known))}")
    if (m is None) != (kind is Blocks):
        raise InputError("m", m, "a circumferential order for drum and ring, none for blocks")
    given = {name: value for name, value in parameters.items() if value is not None}
    if m is None:
        return Blocks.of(mu0=given.pop("mu", "0.3"), **given)
    return (Drum if kind is Drum else Ring).of(abs(m), **given)


@cache
def _eigenvalues(
    problem: Problem, constant: bool, max_frequency: float | None, count: int | None
) -> Values:
    if isinstance(problem, Ring) or (isinstance(problem, Blocks) and constant):
        contact = (
            galerkin_problems.ring(problem, 12, 1)
            if isinstance(problem, Ring)
            else galerkin_problems.blocks(problem, 12, 4, constant=True)
        )
        return _ordered(lowest_in(contact, problem.scale(), max_frequency, count))
    found = spectrum(
        problem, max_frequency, count, digits=_DIGITS, guess=galerkin_problems.guess(problem)
    )
    values = found.values + [complex(value) for value in found.contact_free]
    return _ordered(np.array(values, complex))[:count]


def _family(base: Problem, j: int, depth: Number | None) -> Problem:
    """Member j of the families ``kz = j pi / depth``; 0 is plane strain."""
    if j == 0 or depth is None or isinstance(base, Ring):
        return base
    length = Exact(depth)
    pis = "*pi" if length.pi_power == 0 else "/pi" * (length.pi_power - 1)
    return replace(base, kz=Exact(f"{Fraction(j) / length.rational}{pis}"))


def _series(found: Callable[[int], int], reach: float) -> int:
    """Call ``found`` with 0, 1, ... until it returns 0 twice beyond ``reach``; return the sum."""
    numbers: list[int] = []
    for i in count_from():
        numbers.append(found(i))
        if i > reach and not any(numbers[-2:]):
            break
    return sum(numbers)


def _mirrored(values: Values) -> Values:
    return _ordered(-values.conj())


def _ordered(values: Values) -> Values:
    """Sort by frequency rounded to 12 decimals, then growth; the result is read-only."""
    values = values[np.lexsort((values.real, np.round(values.imag, 12)))]
    values.flags.writeable = False
    return values
