"""Two annuli pressed together along a circle, one harmonic ``e^{i m theta}`` at a time.

Displacements come from potentials of Bessel functions (J. D. Achenbach, Wave Propagation in
Elastic Solids, chapter 6): ``u = grad(phi) + curl(chi e_z)`` and, in 3D, ``+ curl curl(psi e_z)``
with ``phi ~ Z_m(alpha r)`` and ``chi, psi ~ Z_m(beta r)``, Z = J or Y,

    alpha^2 = -rho kappa / (L + 2G) - kz^2,    beta^2 = -rho kappa / G - kz^2.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Any

from flint import acb, acb_mat, arb

from exact_cea.material import SOFT, STIFF, Material, Response, join
from exact_cea.numbers import Exact, exact_numbers, increasing, order
from exact_cea.solve import Characteristic

Column = list[acb]


@dataclass(frozen=True)
class Drum(Characteristic):
    """Annulus a around annulus b, clamped at the outermost and innermost circles.

    ``n = -e_r``, ``k = +e_theta``: at the interface ``sigma_rtheta = mu sigma_rr`` and
    ``sigma_rr / p = u_r^a - u_r^b``.
    """

    m: Annotated[int, "Circumferential order; may be repeated."]
    p: Annotated[Exact, "Contact stiffness per area, or inf."] = Exact("1")
    mu: Annotated[Exact, "Friction coefficient."] = Exact("0.3")
    # None: plane strain. Otherwise u_r, u_theta ~ cos(kz z) and u_z ~ sin(kz z)
    kz: Annotated[Exact | None, "Wave number in z, e.g. pi/2; none: plane strain."] = None
    a: Material = SOFT
    b: Material = STIFF
    inner: Annotated[Exact, "Inner radius."] = Exact("0.5")
    interface: Annotated[Exact, "Radius of the interface."] = Exact("1")
    outer: Annotated[Exact, "Outer radius."] = Exact("1.5")

    @classmethod
    def of(cls, m: int, *given: Any, **named: Any) -> "Drum":
        """Return a drum from numbers or strings, in the order of the fields or by keyword."""
        drum = cls(order("m", m), **exact_numbers(cls, given, named))
        increasing(inner=drum.inner, interface=drum.interface, outer=drum.outer)
        return drum

    @property
    def real(self) -> bool:
        """Whether the characteristic function is real for real ``lambda^2``: for m = 0 only."""
        return self.m == 0

    def scale(self) -> float:
        """Estimate of the lowest angular frequency: a quarter shear wave across an annulus."""
        return min(speeds[1] * math.pi / (2 * width) for speeds, width in self._walls())

    def turning(self, frequency: float) -> float:
        """Travel times of pressure and shear waves (twice in 3D) through both annuli."""
        del frequency
        shear = 1 if self.kz is None else 2
        return sum(width / speeds[0] + shear * width / speeds[1] for speeds, width in self._walls())

    def __call__(self, kappa: acb) -> acb:
        """Characteristic function of ``kappa = lambda^2``."""
        normal, tangential = join(
            self.response(self.a, self.outer.arb, kappa),
            self.response(self.b, self.inner.arb, kappa),
            self.p,
        )
        return normal + self.mu.arb * tangential

    def response(self, material: Material, clamp: arb, kappa: acb) -> Response:
        """Response of an annulus to ``sigma_rr`` and ``sigma_rtheta`` at the interface."""
        at_clamp = self._columns(material, clamp, kappa)
        here = self._columns(material, self.interface.arb, kappa)
        size = 2 if self.kz is None else 3
        fixed = [[column[i] for column in at_clamp] for i in range(size)]
        u_r, rr, rt, *rz = ([column[i] for column in here] for i in (0, *range(size, len(here[0]))))
        # The potentials become linearly dependent where kappa, or in 3D beta, vanishes.
        dependence = kappa * kappa
        if self.kz is not None:
            dependence *= (material.rho.arb * kappa / material.lame[1] + self.kz.arb**2) ** 2
        # For m = 0 torsion is uncoupled: the last determinant is zero, which LU decomposition
        # in ball arithmetic cannot detect.
        shear = acb(0) if self.m == 0 else -acb_mat([*fixed, *rz, rr, u_r]).det() / dependence
        return Response(
            free=acb_mat([*fixed, *rz, rt, rr]).det() / dependence,
            normal=acb_mat([*fixed, *rz, rt, u_r]).det() / dependence,
            tangential=shear,
        )

    def _walls(self) -> list[tuple[tuple[float, float], float]]:
        return [
            (self.a.wave_speeds, float(self.outer) - float(self.interface)),
            (self.b.wave_speeds, float(self.interface) - float(self.inner)),
        ]

    def _columns(self, material: Material, r: arb, kappa: acb) -> list[Column]:
        """Return (u_r, u_theta[, u_z], sigma_rr, sigma_rtheta[, sigma_rz]) of each potential."""
        L, G = material.lame
        rho = material.rho.arb
        kz = arb(0) if self.kz is None else self.kz.arb
        alpha2 = -rho * kappa / (L + 2 * G) - kz * kz
        beta2 = -rho * kappa / G - kz * kz
        columns = [
            _pressure(L, G, self.m, kz, r, alpha2, z, dz) for z, dz in _bessel(self.m, alpha2, r)
        ]
        shear = _bessel(self.m, beta2, r)
        columns += [_horizontal_shear(G, self.m, kz, r, beta2, z, dz) for z, dz in shear]
        if self.kz is None:
            return [[c[0], c[1], c[3], c[4]] for c in columns]
        return columns + [_vertical_shear(G, self.m, kz, r, beta2, z, dz) for z, dz in shear]


def _bessel(m: int, square: acb, r: arb) -> list[tuple[acb, acb]]:
    """Return (Z, dZ/dr) for ``Z = J_m`` and ``Y_m`` of ``sqrt(square) r``.

    The branch of the root does not change the determinants. One of Y_m and Y_{m+1} is computed
    from the other by ``J_{m+1} Y_m - J_m Y_{m+1} = 2 / (pi x)``, divided by the larger of J_m and
    J_{m+1}, which have no common zero.
    """
    a = square.sqrt()
    x = a * r
    j, j_next = x.bessel_j(m), x.bessel_j(m + 1)
    wronskian = 2 / (arb.pi() * x)
    if abs(complex(j)) > abs(complex(j_next)):
        y = x.bessel_y(m)
        y_next = (j_next * y - wronskian) / j
    else:
        y_next = x.bessel_y(m + 1)
        y = (j * y_next + wronskian) / j_next
    return [(j, m / r * j - a * j_next), (y, m / r * y - a * y_next)]


def _pressure(L: arb, G: arb, m: int, kz: arb, r: arb, alpha2: acb, z: acb, dz: acb) -> Column:
    """Column of ``u = grad(Z e^{i m theta} cos(kz z))``."""
    im = acb(0, m)
    second = -dz / r + (m * m / r**2 - alpha2) * z
    return [
        dz,
        im * z / r,
        -kz * z,
        2 * G * second - L * (alpha2 + kz * kz) * z,
        2 * G * im * (dz / r - z / r**2),
        -2 * G * kz * dz,
    ]


def _horizontal_shear(G: arb, m: int, kz: arb, r: arb, beta2: acb, z: acb, dz: acb) -> Column:
    """Column of ``u = curl(Z e^{i m theta} cos(kz z) e_z)``."""
    im = acb(0, m)
    second = -dz / r + (m * m / r**2 - beta2) * z
    return [
        im * z / r,
        -dz,
        acb(0),
        2 * G * im * (dz / r - z / r**2),
        G * (-(m * m) * z / r**2 - second + dz / r),
        -G * kz * im * z / r,
    ]


def _vertical_shear(G: arb, m: int, kz: arb, r: arb, beta2: acb, z: acb, dz: acb) -> Column:
    """Column of ``u = curl curl(Z e^{i m theta} sin(kz z) e_z) / kz``."""
    im = acb(0, m)
    second = -dz / r + (m * m / r**2 - beta2) * z
    return [
        dz,
        im * z / r,
        beta2 * z / kz,
        2 * G * second,
        2 * G * im * (dz / r - z / r**2),
        G * (beta2 / kz - kz) * dz,
    ]
