"""Matrices of a rotating body of joined patches (:mod:`cea.rotation`), by three scalar ones.

With the derivative t_a of function a along the rotation,

    m_ab = int rho N_a N_b,    A_ab = int rho (N_a t_b - t_a N_b),    B_ab = int rho t_a t_b,

A skew, and W v = a x v, the components of Y and Z are

    Y = A (x) 1                 Z = B (x) 1                                 with Coriolis forces
    Y = A (x) 1 - 2 m (x) W     Z = B (x) 1 + A (x) W + m (x) W^T W         without
"""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.rotation import Rotation
from iga_cea.entries import entries
from iga_cea.metric import VALUE, Metric
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.separation import Coefficients
from iga_cea.storage import Kept, block_matrix, combined, component_matrix
from iga_cea.sum_factorisation import Form


def gyroscopic(
    multipatch: Multipatch,
    pattern: Pattern,
    rho: float,
    rotation: Rotation,
    comm: Any,
    kept: Kept | None = None,
) -> Any:
    """Y at 1 rad/s.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    rho
        Density (kg/m^3).
    rotation
        The rotation.
    comm
        MPI communicator.
    kept
        Unknowns that stay; None of all.

    Returns
    -------
    PETSc.Mat
        AIJ matrix (kg), exactly skew; of block size dim where all unknowns stay.
    """
    scalar = _ScalarMatrices(multipatch, pattern, rho, rotation, comm)
    parts = [(scalar.transport(), np.eye(multipatch.dim))]
    if not rotation.coriolis:
        parts.append((scalar.mass(), -2 * rotation.spin(multipatch.dim)))
    return _matrix(pattern, parts, multipatch.dim, kept, comm)


def convective_stiffness(
    multipatch: Multipatch,
    pattern: Pattern,
    rho: float,
    rotation: Rotation,
    comm: Any,
    kept: Kept | None = None,
) -> Any:
    """Z: AIJ matrix (kg), exactly symmetric; of block size dim where all unknowns stay.

    Parameters are those of :func:`gyroscopic`.
    """
    scalar = _ScalarMatrices(multipatch, pattern, rho, rotation, comm)
    parts = [(scalar.square(), np.eye(multipatch.dim))]
    if not rotation.coriolis:
        spin = rotation.spin(multipatch.dim)
        parts += [(scalar.transport(), spin), (scalar.mass(), spin.T @ spin)]
    return _matrix(pattern, parts, multipatch.dim, kept, comm)


class _ScalarMatrices:
    """Entries of m, A and B of the rows of a rank (kg)."""

    def __init__(
        self, multipatch: Multipatch, pattern: Pattern, rho: float, rotation: Rotation, comm: Any
    ) -> None:
        self._space = multipatch, pattern
        self._comm, self._rho = comm, rho
        self._spin = rotation.spin(multipatch.dim)
        self._origin = np.asarray(rotation.origin[: multipatch.dim])

    def mass(self) -> Floats:
        """M."""

        def coefficients(metric: Metric) -> Coefficients:
            return {(VALUE, VALUE): self._rho * metric.measure[None]}

        return entries(*self._space, Form(1, coefficients), self._comm)

    def transport(self) -> Floats:
        """The transport A."""

        def coefficients(metric: Metric) -> Coefficients:
            found: Coefficients = {}
            for k, speed in self._speeds(metric).items():
                if k != VALUE:
                    found[VALUE, k] = (self._rho * metric.measure * speed)[None]
                    found[k, VALUE] = -found[VALUE, k]
            return found

        return entries(*self._space, Form(1, coefficients), self._comm, sign=-1)

    def square(self) -> Floats:
        """The square B."""

        def coefficients(metric: Metric) -> Coefficients:
            speeds, weight = self._speeds(metric), self._rho * metric.measure
            return {
                (k, m): (weight * (speeds[k] * speeds[m]))[None]
                for k, m in product(speeds, repeat=2)
            }

        return entries(*self._space, Form(1, coefficients), self._comm)

    def _speeds(self, metric: Metric) -> dict[int, Floats]:
        """Velocity along each parameter at 1 rad/s."""
        arm = metric.x - self._origin[:, None, None, None]
        velocity = np.tensordot(self._spin, arm, axes=1)
        return {k: np.sum(velocity * g, axis=0) for k, g in metric.gradients.items()}


def _matrix(
    pattern: Pattern,
    parts: Sequence[tuple[Floats, Floats]],
    dim: int,
    kept: Kept | None,
    comm: Any,
) -> Any:
    """Sum of Kronecker products of scalar matrices, the first alone with 1, with small ones."""
    if len(parts) == 1:
        return component_matrix(pattern, parts[0][0], dim, kept, comm)
    return block_matrix(pattern, combined(pattern, parts, dim), dim, kept, comm)
