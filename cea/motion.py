"""Steady rotation of an axisymmetric body in the non-rotating frame, and damping.

A particle that would be at x at time t by rigid rotation alone is at x + u(x, t). Its velocity is

    Omega a x r + D u,     D = d/dt + Omega R,     R u = (a x r) . grad u  =  d u / d theta

where a is the unit vector of the axis, Omega the rate, r = x - origin, and the derivative applies
to each Cartesian component. In the weak form, with the test function v,

    M = int rho v . u
    Y = 2 Omega int rho v . R u  =  Omega int rho (v . R u - R v . u)      gyroscopic, skew
    - Omega^2 Z,  Z = int rho R v . R u                                     convective stiffness

On an axisymmetric body a x r has zero divergence and no normal component, so v . R u + R v . u
integrates to zero, and Y is assembled as its skew part.

D contains all inertia, with Coriolis forces. Without Coriolis forces the displacement rotates with
the material, R u = (a x r) . grad u - a x u: R then commutes with the elasticity of the body, and
a free body has exactly the eigenvalues lambda_0 +- i m Omega, m the number of nodal diameters, if
Z is included (Genta, Dynamics of Rotating Systems, 2005). The geometric stiffness of centrifugal
forces, which is of the same order as Z, is not included in either case.

Material damping acts on the velocity in the rotating material, d u / d t + Omega R u, always with
the R of displacements that rotate with the material. Besides C u_t it gives the circulatory
stiffness Omega C R, without which backward travelling waves would gain energy. In the space of the
body R u is its L2 projection, R = M^-1 B with the skew B = int rho v . R u:
    Rayleigh damping alpha M + beta K      alpha Omega B + beta Omega K M^-1 B
    modal damping                          Omega sum_j 2 zeta_j omega_j (M phi_j) (B^T phi_j)^T

M^-1 is dense: the products are never formed (:mod:`cea.eigen.unformed`). Springs are fixed in
space. Damping by friction acts on u_t alone too, although its slip velocity is u_t + Omega R u: a
part of the order m Omega / |lambda| is left out.
"""

from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np

from cea.arrays import Floats, of_size_one
from cea.errors import require

_SAME = 1e-8  # relative difference of frequencies treated as one multiple eigenvalue
_ROUNDING = 1e-15  # relative rounding error of ratios proportional to the frequency or its inverse


@dataclass(frozen=True)
class RayleighDamping:
    """Rayleigh damping C = alpha M + beta K, where K includes the springs of the body.

    A mode of the uncoupled body with angular frequency omega has the damping ratio
    alpha / (2 omega) + beta omega / 2 (Bathe, Finite Element Procedures, sec. 9.3.3). In a rotating
    body the damping rotates with the material, except for that of springs (:mod:`cea.motion`).

    Parameters
    ----------
    alpha
        Factor on the mass (1/s), zero or positive.
    beta
        Factor on the stiffness (s), zero or positive.
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        for name, value, unit in (("alpha", self.alpha, "1/s"), ("beta", self.beta, "s")):
            allowed = f"zero or positive, finite ({unit})"
            require(0 <= value < inf, f"damping.{name}", value, allowed)

    @classmethod
    def of_ratios(
        cls, ratios: tuple[float, float], frequencies: tuple[float, float]
    ) -> "RayleighDamping":
        """Return damping with given ratios (1 is critical) at two different frequencies (Hz).

        Raise InputError if alpha or beta would be negative: ratios must not fall faster than the
        inverse of the frequency, nor rise faster than the frequency.
        """
        different = all(f > 0 for f in frequencies) and len(set(frequencies)) == 2
        allowed = "two different positive ones (Hz)"
        require(different, "damping.frequencies", frequencies, allowed)
        require(min(ratios) >= 0, "damping.ratios", ratios, "zero or positive")
        (f, z), (F, Z) = sorted(zip(frequencies, ratios, strict=True))
        shared, rounding = (F - f) * (F + f), _ROUNDING * max(ratios) * F
        of_mass, of_stiffness = z * F - Z * f, Z * F - z * f
        allowed = f"{z * f / F:.6g} to {z * F / f:.6g} at {F} Hz where {z} at {f} Hz"
        require(min(of_mass, of_stiffness) >= -rounding, "damping.ratios", ratios, allowed)
        alpha = 4 * pi * f * F * max(of_mass, 0.0) / shared
        return cls(alpha, max(of_stiffness, 0.0) / (pi * shared))


@dataclass(frozen=True)
class ModalDamping:
    """Damping of the modes of the uncoupled body at rest, with its supports and springs.

    For modes phi_j with phi_i^T M phi_j = delta_ij, angular frequencies omega_j and damping ratios
    zeta_j it is

        C = sum_j 2 zeta_j omega_j (M phi_j) (M phi_j)^T,

    so that lambda_j = omega_j (-zeta_j +- i sqrt(1 - zeta_j^2)) for the uncoupled body (Clough,
    Penzien, Dynamics of Structures, sec. 12.5). Rigid body modes and modes above the table are
    undamped. In a rotating body the damping rotates with the material (:mod:`cea.motion`).

    Parameters
    ----------
    ratio
        Damping ratio of all modes up to ``max_frequency``, at least 0 and below 1 (critical).
    max_frequency
        Frequency (Hz) up to which modes are damped.
    ratios
        Alternative: ratios of modes at ``frequencies``, interpolated linearly.
    frequencies
        Increasing frequencies (Hz). Modes below the first have the first ratio, modes above the
        last none.

    Raises
    ------
    InputError
        If values are out of bounds, or not exactly one of ``ratio`` and ``ratios`` is given.
    """

    ratio: float | None = None
    max_frequency: float | None = None
    ratios: tuple[float, ...] | None = None
    frequencies: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        allowed = "one for all modes up to max_frequency, or ratios at frequencies"
        require((self.ratio is None) != (self.ratios is None), "ratio", self.ratio, allowed)
        together = (self.ratio is None) == (self.max_frequency is None)
        require(together, "max_frequency", self.max_frequency, "given together with ratio (Hz)")
        together = (self.ratios is None) == (self.frequencies is None)
        require(together, "frequencies", self.frequencies, "given together with ratios (Hz)")
        positive = self.max_frequency is None or 0 < self.max_frequency < inf
        require(positive, "max_frequency", self.max_frequency, "positive, finite (Hz)")
        require(self.ratio is None or 0 <= self.ratio < 1, "ratio", self.ratio, _RATIO)
        ratios, table = self._table
        valid = bool(ratios) and (self.ratios is None or all(0 <= z < 1 for z in ratios))
        require(valid, "ratios", ratios, f"one or more, each {_RATIO}")
        rising = bool(np.all(np.diff((0.0, *table)) > 0))
        require(rising, "frequencies", table, "positive, finite and rising (Hz)")
        allowed = f"as many as ratios, {len(ratios)}"
        require(len(table) == len(ratios), "frequencies", table, allowed)

    @property
    def _table(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Ratios, relative to ``ratio`` if it is given, and their frequencies (Hz)."""
        if self.max_frequency is not None:
            return (1.0,), (self.max_frequency,)
        return self.ratios or (), self.frequencies or ()

    @property
    def parameter(self) -> tuple[str, float]:
        """Name and value of the field that is a parameter of the pencil; a factor for a table."""
        return ("ratios", 1.0) if self.ratio is None else ("ratio", self.ratio)

    @property
    def end(self) -> float:
        """Frequency (Hz) above which no mode is damped."""
        return self._table[1][-1]

    @property
    def acts(self) -> bool:
        """Whether any mode is damped."""
        return bool(self.ratio) or any(self.ratios or ())

    def factors_at(self, frequencies: Floats) -> Floats:
        """Return damping ratios of elastic modes at frequencies (Hz), relative to ``ratio``."""
        ratios, table = self._table
        # Modes of a multiple eigenvalue, which rounding separates, are damped alike.
        inside = frequencies <= (1 + _SAME) * table[-1]
        return np.where(inside, np.interp(frequencies, table, ratios), 0.0)


_RATIO = "zero or more and below 1, which is critical: 0.01 is one per cent"


@dataclass(frozen=True)
class Rotation:
    """Steady rotation of an axisymmetric body.

    Supports, springs and contacts are fixed in space while the material moves through them.

    Parameters
    ----------
    rate
        Omega (rad/s), zero or positive, right-handed about the axis.
    axis
        Direction of the axis, any nonzero length; along z in 2D.
    origin
        A point of the axis (m).
    convective_stiffness
        Whether the stiffness includes the term - Omega^2 Z. The geometric stiffness of the
        centrifugal forces, which is of the same order, is not included.
    coriolis
        Whether Coriolis forces act. If not, displacements rotate with the material, and modes of a
        free body are shifted by m Omega.
    """

    rate: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    convective_stiffness: bool = False
    coriolis: bool = True

    def __post_init__(self) -> None:
        allowed = "zero or positive (rad/s); the axis gives the sense"
        require(self.rate >= 0, "rotation.rate", self.rate, allowed)
        require(any(self.axis), "rotation.axis", self.axis, "a finite vector that is not zero")

    def check(self, dim: int, field: str) -> None:
        """Raise InputError in 2D for an axis that is not along z or an origin with z != 0."""
        if dim == 2:
            require(not any(self.axis[:2]), f"{field}.axis", self.axis, "along z in the plane")
            require(not self.origin[2], f"{field}.origin", self.origin, "z = 0 in the plane")

    @property
    def of_material(self) -> "Rotation":
        """The same rotation without Coriolis forces, for material damping."""
        return replace(self, coriolis=False)

    def spin(self, dim: int) -> Floats:
        """Return the skew matrix W with W v = a x v, shape (dim, dim)."""
        axis = of_size_one(self.axis)
        x, y, z = axis / np.linalg.norm(axis)
        whole = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.ascontiguousarray(whole[:dim, :dim])


@dataclass(frozen=True)
class Motion:
    """Damping and rotation of a body, the terms that act on its velocities."""

    damping: RayleighDamping | None = None  # Rayleigh damping, or None
    rotation: Rotation | None = None  # rotation, or None
    # modal damping (:mod:`cea.system.modal_damping`), or None
    modal: ModalDamping | None = None

    @property
    def circulates(self) -> bool:
        """Whether the body has damping that rotates with the material."""
        damped = self.damping is not None or self.modal is not None
        return damped and self.rotation is not None
