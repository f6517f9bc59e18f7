"""Drum, blocks and ring as Galerkin problems of high degree."""

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from exact_cea.blocks import Blocks
from exact_cea.drum import Drum
from exact_cea.galerkin import GalerkinBody, GalerkinContact, Strain, lowest
from exact_cea.material import Material
from exact_cea.numbers import Exact, exact_numbers, increasing, order
from exact_cea.solve import Guess
from exact_cea.spectral import Axis, Single, graded

V, D, R, Z = "value", "slope", "over_r", "along z"


def cylindrical(m: int) -> Strain:
    """Strains rr, tt, zz, rt, rz, tz of ``(u_r, u_theta, u_z) e^{i m theta}`` on axes r, z."""
    im = 1j * m
    return [
        [(1, 0, D, V)],
        [(1, 0, R, V), (im, 1, R, V)],
        [(1, 2, V, D)],
        [(im, 0, R, V), (1, 1, D, V), (-1, 1, R, V)],
        [(1, 0, V, D), (1, 2, D, V)],
        [(1, 1, V, D), (im, 2, R, V)],
    ]


_CARTESIAN: Strain = [
    [(1, 0, D, V)],
    [(1, 1, V, D)],
    [(1, 2, V, Z)],
    [(1, 0, V, D), (1, 1, D, V)],
    [(1, 0, V, Z), (1, 2, D, V)],
    [(1, 1, V, Z), (1, 2, V, D)],
]
"""Strains xx, yy, zz, xy, xz, yz on axes x, y, with derivatives along z."""


def family(strain: Strain, kz: float | None, along_z: str) -> Strain:
    """Strains with the first two components ~ cos(kz z) and the third ~ sin(kz z).

    If ``kz`` is None: plane strain, without the third component.
    """
    if kz is None:
        return [[term for term in terms if term[1] < 2 and term[3] != along_z] for terms in strain]
    rate = (-kz, -kz, kz)
    return [
        [(c * rate[u], u, x, V) if y == along_z else (c, u, x, y) for c, u, x, y in terms]
        for terms in strain
    ]


def drum(problem: Drum, degree: int = 30) -> GalerkinContact:
    """Return the drum with one element through each wall."""
    kz = None if problem.kz is None else float(problem.kz)
    components = 2 if kz is None else 3

    def annulus(material: Material, start: Exact, end: Exact, clamp: int) -> GalerkinBody:
        axes = Axis((float(start), float(end)), (degree,), radial=True), Single()
        held = _at(axes, (0, clamp))
        return GalerkinBody(
            material,
            axes,
            components,
            family(cylindrical(problem.m), kz, D),
            dict.fromkeys(range(components), held),
            (0, -1 - clamp),
        )

    return GalerkinContact(
        annulus(problem.a, problem.interface, problem.outer, -1),
        annulus(problem.b, problem.inner, problem.interface, 0),
        normal=(0, -1.0),
        tangent=(1, 1.0),
        p=float(problem.p) * float(problem.interface),
        mu=float(problem.mu),
    )


def blocks(problem: Blocks, degree: int, layers: int, constant: bool) -> GalerkinContact:
    """Return the blocks, with constant friction or ``mu0 sin(pi x / length)``.

    ``layers`` graded elements resolve the corners; smooth solutions need none.
    """
    length, mu0 = float(problem.length), float(problem.mu0)
    kz = None if problem.kz is None else float(problem.kz)
    components = 2 if kz is None else 3
    along = graded(0, length, degree, layers, (True, True))

    def layer(material: Material, start: float, end: float, clamp: int) -> GalerkinBody:
        axes = along, graded(start, end, degree, layers, (clamp == -1, clamp == 0))
        held = dict.fromkeys(range(components), _at(axes, (1, clamp)))
        held[0] = held[0] | _at(axes, (0, 0)) | _at(axes, (0, -1))
        return GalerkinBody(
            material, axes, components, family(_CARTESIAN, kz, Z), held, (1, -1 - clamp)
        )

    def sine(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return mu0 * np.sin(math.pi * x / length)

    return GalerkinContact(
        layer(problem.a, 0, float(problem.height_a), -1),
        layer(problem.b, -float(problem.height_b), 0, 0),
        normal=(1, -1.0),
        tangent=(0, 1.0),
        p=float(problem.p),
        mu=mu0 if constant else sine,
    )


def guess(problem: Drum | Blocks) -> Guess:
    """Return a function for approximate lowest eigenvalues, which polishing starts from."""

    def lowest_of(count: int) -> NDArray[np.complex128]:
        contact = (
            drum(problem, max(30, count))
            if isinstance(problem, Drum)
            else blocks(problem, max(16, count // 2), 0, constant=False)
        )
        return lowest(contact, count, problem.scale())

    return lowest_of


DISC = Material.of("2.1e11", "0.3", "7800", "b")
PAD = Material.of("1e10", "0.25", "2500", "a")


@dataclass(frozen=True)
class Ring:
    """Ring pad a on disc b, both ``inner < r < outer``, for one harmonic ``e^{i m theta}``.

    Rims are on rollers (u_r = 0, no shear), the top of the pad is clamped, the bottom of the disc
    is free; ``n = -e_z``, ``k = +e_theta``.
    """

    m: Annotated[int, "Circumferential order; may be repeated."]
    p: Annotated[Exact, "Contact stiffness per area, or inf."] = Exact("1e12")
    mu: Annotated[Exact, "Friction coefficient."] = Exact("0.3")
    a: Material = PAD
    b: Material = DISC
    inner: Annotated[Exact, "Inner radius."] = Exact("0.08")
    outer: Annotated[Exact, "Outer radius."] = Exact("0.16")
    height_a: Annotated[Exact, "Thickness of body a."] = Exact("0.01")
    height_b: Annotated[Exact, "Thickness of body b."] = Exact("0.02")

    @classmethod
    def of(cls, m: int, *given: Any, **named: Any) -> "Ring":
        """Return a ring from numbers or strings, in the order of the fields or by keyword."""
        ring = cls(order("m", m), **exact_numbers(cls, given, named))
        increasing(inner=ring.inner, outer=ring.outer)
        return ring

    def scale(self) -> float:
        """Estimate of the lowest angular frequency: shear waves around the mean circumference."""
        mean = (float(self.inner) + float(self.outer)) / 2
        return self.b.wave_speeds[1] / mean


def ring(problem: Ring, degree: int = 14, layers: int = 1) -> GalerkinContact:
    """Return the ring; elements are graded towards the rims and the interface."""
    rims = float(problem.inner), float(problem.outer)
    along = graded(*rims, degree, layers, (True, True), radial=True)

    def plate(material: Material, start: float, end: float, top: bool) -> GalerkinBody:
        axes = along, graded(start, end, degree, layers, (top, not top))
        rolling = _at(axes, (0, 0)) | _at(axes, (0, -1))
        clamp = _at(axes, (1, -1)) if top else np.zeros_like(rolling)
        held = {0: rolling | clamp, 1: clamp, 2: clamp}
        return GalerkinBody(material, axes, 3, cylindrical(problem.m), held, (1, 0 if top else -1))

    return GalerkinContact(
        plate(problem.a, 0, float(problem.height_a), True),
        plate(problem.b, -float(problem.height_b), 0, False),
        normal=(2, -1.0),
        tangent=(1, 1.0),
        p=float(problem.p),
        mu=float(problem.mu),
    )


def _at(axes: tuple[Axis, Axis | Single], end: tuple[int, int]) -> NDArray[np.bool_]:
    """Mask of the functions that do not vanish at one end, ``(axis, 0 or -1)``."""
    held = np.zeros((axes[0].size, axes[1].size), bool)
    np.moveaxis(held, end[0], 0)[end[1]] = True
    return held
