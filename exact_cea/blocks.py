"""Two clamped layers between roller walls, sliding with friction ``mu0 sin(pi x / length)``.

Body a is ``0 < y < height_a``, body b ``-height_b < y < 0``, both on ``0 < x < length``. With
rollers every field is a series in ``cos(n pi x / length)`` or ``sin(n pi x / length)``. Friction
couples the normal stress of harmonic n to the shear stress of n - 1 and n + 1,

    mu s = mu0 / 2 sum_n s_n [sin((n + 1) pi x / length) - sin((n - 1) pi x / length)],

so the gap conditions of all harmonics form a tridiagonal system. Its determinant, truncated to
n < N, converges faster than geometrically for finite p and geometrically for infinite p.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any

from flint import acb, arb

from exact_cea.material import SOFT, STIFF, Material, Response, join
from exact_cea.numbers import Exact, exact_numbers
from exact_cea.solve import Characteristic


@dataclass(frozen=True)
class Blocks(Characteristic):
    """Blocks with sinusoidal friction, in plane strain or for one wave number in z."""

    p: Annotated[Exact, "Contact stiffness per area, or inf."] = Exact("1")
    mu0: Annotated[Exact, "Friction mu0 sin(pi x / length)."] = Exact("0.3")
    # None: plane strain. Otherwise u_x, u_y ~ cos(kz z) and u_z ~ sin(kz z), as in a block of
    # length pi / kz with rollers at both ends
    kz: Annotated[Exact | None, "Wave number in z, e.g. pi/2; none: plane strain."] = None
    a: Material = SOFT
    b: Material = STIFF
    height_a: Annotated[Exact, "Thickness of body a."] = Exact("0.5")
    height_b: Annotated[Exact, "Thickness of body b."] = Exact("1")
    length: Annotated[Exact, "Distance of the roller walls."] = Exact("2")
    harmonics: int = 24  # truncation N

    @classmethod
    def of(cls, *given: Any, **named: Any) -> "Blocks":
        """Return blocks from numbers or strings, in the order of the fields or by keyword."""
        return cls(**exact_numbers(cls, given, named))

    @property
    def real(self) -> bool:
        """The characteristic function is real for real ``lambda^2``."""
        return True

    def scale(self) -> float:
        """Estimate of the lowest angular frequency: a quarter shear wave across a layer."""
        return min(
            material.wave_speeds[1] * math.pi / (2 * float(height))
            for material, height in ((self.a, self.height_a), (self.b, self.height_b))
        )

    def turning(self, frequency: float) -> float:
        """Travel times of both waves through each layer, times the propagating harmonics."""
        slowest = min(self.a.wave_speeds[1], self.b.wave_speeds[1])
        propagating = 2 + frequency * float(self.length) / (math.pi * slowest)
        return propagating * sum(
            float(height) / speed
            for material, height in ((self.a, self.height_a), (self.b, self.height_b))
            for speed in material.wave_speeds
        )

    def for_frequency(self, frequency: float) -> "Blocks":
        """Return the blocks with so many harmonics that all others are evanescent."""
        slowest = min(self.a.wave_speeds[1], self.b.wave_speeds[1])
        return replace(
            self, harmonics=math.ceil(frequency * float(self.length) / (math.pi * slowest)) + 6
        )

    def refined(self) -> "Blocks":
        """Return the blocks with 1.5 times the harmonics, or the same blocks beyond 200."""
        return self if self.harmonics > 200 else replace(self, harmonics=self.harmonics * 3 // 2)

    def __call__(self, kappa: acb) -> acb:
        """Characteristic function of ``kappa = lambda^2``."""
        return BlocksAt(self, self.mu0.arb)(kappa)

    def gap_condition(self, n: int, kappa: acb) -> tuple[acb, acb]:
        """Coefficients of the normal stress s_n and the shear stress t_n in gap condition n."""
        kx = n * arb.pi() / self.length.arb
        k = kx if self.kz is None else (kx * kx + self.kz.arb**2).sqrt()
        normal, tangential = join(
            mirrored(layer_response(self.a, self.height_a.arb, k, kappa)),
            layer_response(self.b, self.height_b.arb, k, kappa),
            self.p,
        )
        # Only the component of friction along the wave vector (kx, kz) causes normal displacement.
        return normal, tangential * kx / k if n else acb(0)

    def closed_form(self, frequency: float) -> list[acb]:
        """Eigenvalues up to a frequency of modes without contact pressure.

        With kz these are horizontally polarised shear waves, which have no normal displacement:
        ``lambda^2 = -c^2 (kx^2 + kz^2 + ((j + 1/2) pi / height)^2)`` in either body.
        """
        if self.kz is None:
            return []
        found = []
        for material, height in ((self.a, self.height_a), (self.b, self.height_b)):
            speed2 = material.lame[1] / material.rho.arb
            reach = frequency / material.wave_speeds[1] / math.pi
            for n in range(1, math.floor(reach * float(self.length)) + 1):
                for j in range(math.floor(reach * float(height) + 0.5) + 1):
                    kx = n * arb.pi() / self.length.arb
                    ky = (j + arb("0.5")) * arb.pi() / height.arb
                    omega = (speed2 * (kx * kx + ky * ky + self.kz.arb**2)).sqrt()
                    if float(omega) <= frequency:
                        found.append(acb(0, omega))
        return found


@dataclass(frozen=True)
class BlocksAt:
    """Determinant of the tridiagonal gap conditions for one value of mu0."""

    blocks: Blocks
    mu0: arb | acb

    def __call__(self, kappa: acb) -> acb:
        """Continuant: row n reads ``d_n s_n + mu0 / 2 f_n (s_{n-1} - s_{n+1}) = 0``, f_0 = 0."""
        quarter = self.mu0 * self.mu0 / 4
        before, now = acb(0), acb(1)
        coupling_before = acb(0)
        for n in range(self.blocks.harmonics):
            diagonal, coupling = self.blocks.gap_condition(n, kappa)
            before, now = now, diagonal * now + quarter * coupling_before * coupling * before
            coupling_before = coupling
        return now


def layer_response(material: Material, height: arb, k: arb, kappa: acb) -> Response:
    """Response of a clamped layer to ``sigma_yy ~ cos(kx)`` and ``sigma_xy ~ sin(kx)``.

    With y the distance from the clamp, ``C = cosh``, ``S = sinh(. y) / .``,
    ``alpha^2 = k^2 + rho kappa / (L + 2G)`` and ``beta^2 = k^2 + rho kappa / G``, the solutions
    clamped at y = 0 are spanned by

        u = (k (C_b - C_a), alpha^2 S_a - k^2 S_b),   u = (beta^2 S_b - k^2 S_a, k (C_a - C_b)),

    both divided by kappa here, as they vanish with it (J. D. Achenbach, Wave Propagation in
    Elastic Solids, chapter 6).
    """
    L, G = material.lame
    rho = material.rho.arb
    alpha2 = k * k + rho * kappa / (L + 2 * G)
    C_a, S_a = _hyperbolic(alpha2, height)
    if k.is_zero():
        return Response((L + 2 * G) * C_a, S_a, acb(0))
    beta2 = k * k + rho * kappa / G
    C_b, S_b = _hyperbolic(beta2, height)
    k2 = k * k
    mixed = beta2 + k2
    u_1 = (alpha2 * S_a - k2 * S_b) / kappa
    shear_1 = G * k * (mixed * S_b - 2 * alpha2 * S_a) / kappa
    pressure_1 = G * (mixed * C_a - 2 * k2 * C_b) / kappa
    u_2 = k * (C_a - C_b) / kappa
    shear_2 = G * (mixed * C_b - 2 * k2 * C_a) / kappa
    pressure_2 = G * k * (mixed * S_a - 2 * beta2 * S_b) / kappa
    return Response(
        free=shear_1 * pressure_2 - shear_2 * pressure_1,
        normal=shear_1 * u_2 - shear_2 * u_1,
        tangential=pressure_2 * u_1 - pressure_1 * u_2,
    )


def mirrored(response: Response) -> Response:
    """Response of the layer upside down: normal displacement and shear stress change sign."""
    return Response(response.free, -response.normal, response.tangential)


def _hyperbolic(square: acb, y: arb) -> tuple[acb, acb]:
    """Return cosh(a y) and sinh(a y) / a, which are entire functions of a^2."""
    a = square.sqrt() * y
    return a.cosh(), y * (a * acb(0, 1)).sinc()
