"""Lumped systems of two degrees of freedom: the models of Hoffmann and of Hulten.

References: N. Hoffmann et al., European Journal of Mechanics A 21 (2002) 91-104;
J. Hulten, SAE paper 932965 (1993).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, cast

from flint import acb, arb, ctx, fmpq, fmpq_mat, fmpq_poly

from cea.errors import InputError
from exact_cea.numbers import Exact

Matrix = Sequence[Sequence[Fraction]]


@dataclass(frozen=True)
class LumpedSystem:
    """``(lambda^2 M + lambda C + K) x = 0`` with rational matrices."""

    name: str
    M: Matrix  # mass
    C: Matrix  # damping and gyroscopic matrix
    K: Matrix  # stiffness


def rationals(**values: str | float | Exact) -> list[Fraction]:
    """Return exact rational numbers; infinite numbers and multiples of pi are refused."""
    numbers = []
    for field, value in values.items():
        number = Exact(value, field)
        if number.infinite or number.pi_power:
            raise InputError(field, str(value), "a finite decimal number or fraction")
        numbers.append(number.rational)
    return numbers


def hoffmann(
    mu: Annotated[str | float, "Friction coefficient."],
    k11: Annotated[str | float, "Stiffness."] = "2.5",
    k12: Annotated[str | float, "Coupling."] = "0.5",
    k22: Annotated[str | float, "Stiffness."] = "2",
    k3: Annotated[str | float, "Stiffness of the contact."] = "4/3",
) -> LumpedSystem:
    """Minimal model of mode coupling: unit masses, ``K = [[k11, k12 - mu k3], [k12, k22]]``."""
    m, a, b, c, d = rationals(mu=mu, k11=k11, k12=k12, k22=k22, k3=k3)
    one, nil = Fraction(1), Fraction(0)
    return LumpedSystem(
        f"Hoffmann mu={mu}",
        [[one, nil], [nil, one]],
        [[nil, nil], [nil, nil]],
        [[a, b - m * d], [b, c]],
    )


def hoffmann_threshold(
    k11: str | float = "2.5",
    k12: str | float = "0.5",
    k22: str | float = "2",
    k3: str | float = "4/3",
) -> Fraction:
    """Friction coefficient at coalescence: ``(k11 - k22)^2 + 4 k12 (k12 - mu k3) = 0``."""
    a, b, c, d = rationals(k11=k11, k12=k12, k22=k22, k3=k3)
    if b * d == 0:
        raise InputError("k12, k3", f"{k12}, {k3}", "both nonzero: friction must couple the modes")
    return ((a - c) ** 2 + 4 * b * b) / (4 * b * d)


def hulten(
    mu: Annotated[str | float, "Friction coefficient."],
    k1: Annotated[str | float, "Stiffness of contact 1."] = "1",
    k2: Annotated[str | float, "Stiffness of contact 2."] = "1.44",
    c1: Annotated[str | float, "Damping of contact 1."] = "0",
    c2: Annotated[str | float, "Damping of contact 2."] = "0",
    rotation: Annotated[str | float, "Speed of the frame."] = "0",
) -> LumpedSystem:
    """Two orthogonal contacts on one unit mass, damped, in a frame turning at ``rotation``.

    ``K = [[k1, -mu k2], [mu k1, k2]]``, ``C = [[c1, -2 W], [2 W, c2]]``, W the rotation.
    """
    m, a, b, d1, d2, turn = rationals(mu=mu, k1=k1, k2=k2, c1=c1, c2=c2, rotation=rotation)
    one, nil = Fraction(1), Fraction(0)
    title = f"Hulten mu={mu} c=({c1},{c2})" + (f" Om={rotation}" if turn else "")
    return LumpedSystem(
        title,
        [[one, nil], [nil, one]],
        [[d1, -2 * turn], [2 * turn, d2]],
        [[a, -m * b], [m * a, b]],
    )


def hulten_threshold(
    k1: str | float = "1",
    k2: str | float = "1.44",
    c1: str | float = "0",
    c2: str | float = "0",
    digits: int = 30,
) -> tuple[arb, arb]:
    """Return the threshold mu_c of the Hulten model without rotation, and omega^2 there.

    Undamped: ``mu_c = |k2 - k1| / (2 sqrt(k1 k2))`` and ``omega^2 = (k1 + k2) / 2``. Damped: the
    Hurwitz condition ``a3 a2 a1 = a1^2 + a3^2 a0`` of the characteristic polynomial, and
    ``omega^2 = a1 / a3``.
    """
    a, b, d1, d2 = rationals(k1=k1, k2=k2, c1=c1, c2=c2)
    if a <= 0 or b <= 0 or d1 < 0 or d2 < 0:
        raise InputError("k1, k2, c1, c2", (k1, k2, c1, c2), "k positive, c zero or positive")
    a3, a2, a1 = d1 + d2, a + b + d1 * d2, d1 * b + d2 * a
    if a3 == 0:
        square, omega2 = (b - a) ** 2 / (4 * a * b), (a + b) / 2
    else:
        square, omega2 = (a2 * a1 / a3 - (a1 / a3) ** 2) / (a * b) - 1, a1 / a3
    with ctx.workdps(digits + 10):
        return Exact(str(square)).arb.sqrt(), Exact(str(omega2)).arb


def eigenvalues(system: LumpedSystem, digits: int = 30) -> list[acb]:
    """Return all eigenvalues with their multiplicity, sorted by imaginary, then real part.

    The characteristic polynomial is exact (interpolated at 2n + 1 integers). Its roots are computed
    as balls from its square-free factors, so that multiple eigenvalues lose no digits.
    """
    n = len(system.M)
    nodes = range(-n, n + 1)
    values = fmpq_mat([[fmpq_mat(_pencil(system, x)).det()] for x in nodes])
    powers = fmpq_mat([[fmpq(x) ** j for j in range(2 * n + 1)] for x in nodes])
    polynomial = fmpq_poly(powers.solve(values).entries())
    with ctx.workdps(digits + 10):
        factors = cast("list[tuple[acb, int]]", polynomial.numer().complex_roots())
    roots = [root for root, multiplicity in factors for _ in range(multiplicity)]
    return sorted(roots, key=lambda z: (float(z.imag.mid()), float(z.real.mid())))


def _pencil(system: LumpedSystem, x: int) -> list[list[fmpq]]:
    rows = zip(system.M, system.C, system.K, strict=True)
    return [
        [
            fmpq(value.numerator, value.denominator)
            for value in (x * x * m + x * c + k for m, c, k in zip(*row, strict=True))
        ]
        for row in rows
    ]
