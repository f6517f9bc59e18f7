"""Steady rotation of an axisymmetric body, seen from the frame that does not rotate.

A particle that the rotation alone carries to x at time t is found at x + u(x, t). Its velocity is

    Omega a x r + D u,     D = d/dt + Omega R,     R u = (a x r) . grad u  =  d u / d theta

with the unit vector a of the axis, the rate Omega, r = x - origin, and the derivative taken of each
Cartesian component. In the weak form, with the test function v,

    M = int rho v . u
    Y = 2 Omega int rho v . R u  =  Omega int rho (v . R u - R v . u)      gyroscopic, skew
    - Omega^2 Z,  Z = int rho R v . R u                                     convective stiffness

On an axisymmetric body a x r has no divergence and no normal component: v . R u + R v . u
integrates to zero, and Y is assembled as its skew part.

D holds all inertia, Coriolis forces too. Without Coriolis forces the displacement is carried along
with its directions, R u = (a x r) . grad u - a x u: R then commutes with the elasticity of the
body, and a free body has exactly the eigenvalues lambda_0 +- i m Omega, m the number of nodal
diameters, as far as Z is there (Genta, Dynamics of Rotating Systems, 2005). The geometric stiffness
of the centrifugal forces, of the order of Z too, is not part of either.

Damping of the material acts on the velocity that the material sees, d u / d t + Omega R u with the
R that carries directions along, whatever the Coriolis forces. Beside C u_t stands the circulatory
stiffness Omega C R, without which waves that run backwards would be fed. On the space of the body
R u is its L2 projection, R = M^-1 B with B = int rho v . R u, skew:

    Rayleigh damping alpha M + beta K      alpha Omega B + beta Omega K M^-1 B
    modal damping                          Omega sum_j 2 zeta_j omega_j (M phi_j) (B^T phi_j)^T

M^-1 is full: the products are never formed (:mod:`cea.eigen.unformed`). Springs and friction stay
where they are in space; no rotation enters their damping.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cea.arrays import is_number, of_size_one
from cea.errors import require


@dataclass(frozen=True)
class Rotation:
    """Steady rotation of a body whose shape it leaves as it is.

    Supports, springs and contacts stay where they are in space while the material passes by.

    Parameters
    ----------
    rate
        Omega (rad/s), zero or positive: right-handed about the axis, which gives the sense.
    axis
        Direction of the axis, any length but zero; along z in the plane.
    origin
        A point of the axis (m).
    convective_stiffness
        Whether the term - Omega^2 Z is part of the stiffness. The geometric stiffness of the
        centrifugal forces, which is of the same order, is not.
    coriolis
        Whether Coriolis forces act. Without, displacements are carried along with their directions,
        and modes of a free body pass by with m Omega.
    """

    rate: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    convective_stiffness: bool = False
    coriolis: bool = True

    def __post_init__(self) -> None:
        allowed = "zero or positive (rad/s); the axis gives the sense"
        require(is_number(self.rate) and self.rate >= 0, "rotation.rate", self.rate, allowed)
        real = bool(np.isfinite(self.axis).all() and np.any(self.axis))
        require(real, "rotation.axis", self.axis, "a finite vector that is not zero")
        finite = bool(np.isfinite(self.origin).all())
        require(finite, "rotation.origin", self.origin, "finite coordinates (m)")

    def check(self, dim: int, field: str) -> None:
        """Refuse an axis that leaves the plane oblique, and an origin beside it."""
        if dim == 2:
            require(not any(self.axis[:2]), f"{field}.axis", self.axis, "along z in the plane")
            require(not self.origin[2], f"{field}.origin", self.origin, "z = 0 in the plane")

    @property
    def of_material(self) -> "Rotation":
        """The same, displacements being carried along with their directions."""
        return replace(self, coriolis=False)

    def spin(self, dim: int) -> NDArray[np.float64]:
        """W with W v = a x v, skew, shape (dim, dim)."""
        axis = of_size_one(self.axis)
        x, y, z = axis / np.linalg.norm(axis)
        whole = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.ascontiguousarray(whole[:dim, :dim])
