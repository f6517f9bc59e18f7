"""Exceptional points: friction coefficients at which two modes of the blocks coalesce.

At a real ``kappa = lambda^2`` the characteristic function is a polynomial in ``q = mu0^2``. Its
roots ``q(kappa)`` form smooth branches. A double eigenvalue is an extremum of a branch, where
``D = dD/dkappa = 0``. Branches are sampled on a grid in double precision, and their extrema are
refined by Newton's method in two unknowns.
"""

import math
from dataclasses import dataclass

import numpy as np
from flint import acb, acb_mat, arb, ctx
from numpy.typing import NDArray

from cea.errors import require
from exact_cea.blocks import Blocks, BlocksAt
from exact_cea.solve import DIGITS, agreement


@dataclass(frozen=True)
class ExceptionalPoint:
    """Double eigenvalue of the blocks."""

    mu_c: arb  # friction amplitude mu0
    kappa: arb  # square of the double eigenvalue, negative
    digits: int  # correct digits of both

    @property
    def omega(self) -> arb:
        """Angular frequency, the imaginary part of the double eigenvalue."""
        with ctx.workdps(2 * self.digits):
            return (-self.kappa).sqrt()


def exceptional_points(
    blocks: Blocks, mu_max: float, max_frequency: float, grid: int = 1500, digits: int = DIGITS
) -> list[ExceptionalPoint]:
    """Return the exceptional points with ``0 < mu0 <= mu_max`` up to ``max_frequency``, by mu_c.

    ``blocks.mu0`` is not used. Branches are sampled at ``grid`` frequencies: extrema less than two
    steps apart are missed. At an exceptional point flutter may begin or end.
    """
    for name, value in (("mu0", mu_max), ("max_frequency", max_frequency)):
        require(0 < value < math.inf, name, value, "a positive number")
    blocks = blocks.for_frequency(max_frequency)
    omegas = np.linspace(0, max_frequency, grid + 1)[1:] * (1 + 1e-9)
    branches = [_branches(blocks, -(float(omega) ** 2)) for omega in omegas]
    found: list[ExceptionalPoint] = []
    for omega, before, here, after in zip(
        omegas[1:], branches, branches[1:], branches[2:], strict=False
    ):
        for q in here[(here > 0) & (here < 1.5 * mu_max**2)]:
            if not before.size or not after.size:
                continue
            left = before[np.argmin(abs(before - q))] - q
            right = after[np.argmin(abs(after - q))] - q
            if left * right <= 0:
                continue
            point = _polish(blocks, -(float(omega) ** 2), float(q), digits)
            if (
                point is not None
                and 0 < float(point.mu_c) <= mu_max
                and float(point.omega) <= max_frequency
                and not any(_same(point, other) for other in found)
            ):
                found.append(point)
    return sorted(found, key=lambda point: float(point.mu_c))


def _branches(blocks: Blocks, kappa: float) -> NDArray[np.float64]:
    """Real roots q, of either sign, of the characteristic function at a real kappa."""
    with ctx.workprec(80):
        rows = [blocks.gap_condition(n, acb(kappa)) for n in range(blocks.harmonics)]
        ratio = np.array([complex(c / d).real / 2 for d, c in rows])
    # s_n = -ratio_n mu0 (s_{n-1} - s_{n+1}): eigenvalues 1 / mu0 come in pairs of opposite sign.
    matrix = np.diag(-ratio[1:], -1) + np.diag(ratio[:-1], 1)
    squares = np.linalg.eigvals(matrix @ matrix)
    largest = abs(squares).max()
    real = squares.real[(abs(squares.imag) < 1e-9 * largest) & (abs(squares) > 1e-9 * largest)]
    return 1 / real


def _polish(blocks: Blocks, kappa: float, q: float, digits: int) -> ExceptionalPoint | None:
    """Solve ``D = dD/dkappa = 0`` with more and more harmonics; None if kappa moves away."""
    first = _newton(blocks, acb(kappa), acb(q), digits)
    if first is None or abs(float(first[0].real) / kappa - 1) > 0.05:
        return None
    while (refined := blocks.refined()) is not blocks:
        again = _newton(refined, *first, digits)
        if again is None:
            return None
        agreed = min(agreement(x, y, digits) for x, y in zip(first, again, strict=True))
        blocks, first = refined, again
        if agreed >= digits:
            break
    with ctx.workdps(3 * digits):
        return ExceptionalPoint(first[1].real.sqrt().mid(), first[0].real, agreed)


def _newton(blocks: Blocks, kappa: acb, q: acb, digits: int) -> tuple[acb, acb] | None:
    with ctx.workdps(4 * digits + 20):
        small = arb(10) ** (-digits)

        def d(i: int, j: int) -> acb:
            return BlocksAt(blocks, (q * (1 + j * small)).sqrt())(kappa * (1 + i * small))

        for _ in range(25):
            h, e = kappa * small, q * small
            east, centre, west = d(1, 0), d(0, 0), d(-1, 0)
            by_kappa, curvature = (east - west) / (2 * h), (east - 2 * centre + west) / (h * h)
            by_q = (d(0, 1) - d(0, -1)) / (2 * e)
            mixed = (d(1, 1) - d(-1, 1) - d(1, -1) + d(-1, -1)) / (4 * h * e)
            jacobian = acb_mat([[by_kappa, by_q], [curvature, mixed]])
            change = jacobian.solve(acb_mat([[centre], [by_kappa]]))
            kappa, q = (kappa - change[0, 0]).mid(), (q - change[1, 0]).mid()
            if not (kappa.is_finite() and q.is_finite()) or float(q.real) <= 0:
                return None
            moved = max(abs(complex(change[0, 0] / kappa)), abs(complex(change[1, 0] / q)))
            if moved < 10.0 ** (-digits - 5):
                return kappa, q
    return None


def _same(x: ExceptionalPoint, y: ExceptionalPoint) -> bool:
    return abs(float(x.mu_c) / float(y.mu_c) - 1) + abs(float(x.kappa / y.kappa) - 1) < 1e-10
