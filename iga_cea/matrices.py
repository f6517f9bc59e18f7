"""Matrices of joined NURBS patches, from coefficients of bilinear forms at Gauss points.

For gradients grad N_a = sum_k D_k N_a grad xi_k, elasticity

    K[a i, b j] = int c_ipjq d_p N_a d_q N_b

(Hughes, The Finite Element Method, sec. 2.7) has the coefficients

    C_km[ij] = |J| c_ipjq (grad xi_k)_p (grad xi_m)_q.

With the derivative t_a of function a along a rotation (:mod:`cea.motion`),

    m_ab = int rho N_a N_b,    A_ab = int rho (N_a t_b - t_a N_b),    B_ab = int rho t_a t_b,

A skew, and W v = a x v, the components of Y and Z are

    Y = A (x) 1                 Z = B (x) 1                                 with Coriolis forces
    Y = A (x) 1 - 2 m (x) W     Z = B (x) 1 + A (x) W + m (x) W^T W         without
"""

from collections.abc import Callable
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Density
from cea.material import Elasticity
from cea.motion import Rotation
from iga_cea.entries import entries
from iga_cea.metric import VALUE, Metric
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.separation import Coefficients
from iga_cea.storage import block_matrix, combined, component_matrix
from iga_cea.sum_factorisation import Form


class NurbsMatrices:
    """Matrices of all dofs (full x full), PETSc AIJ, not cached; assembly is collective.

    They are symmetric or skew to the last bit. A folded patch raises InputError.
    """

    def __init__(self, multipatch: Multipatch, comm: Any) -> None:
        self.multipatch, self.comm, self.dim = multipatch, comm, multipatch.dim

    @cached_property
    def _pattern(self) -> Pattern:
        return Pattern.of(self.multipatch, self.comm.rank)

    def stiffness(self, elasticity: Elasticity) -> Any:
        """Return the elastic stiffness (N/m), symmetric."""
        dim = self.dim

        def coefficients(metric: Metric) -> Coefficients:
            shape, x = metric.measure.shape, metric.x.reshape(dim, -1)
            found: Coefficients = {
                (k, m): np.empty((dim, dim, x.shape[1]))
                for k, m in product(metric.gradients, repeat=2)
            }
            for m, slope in metric.gradients.items():
                along = (slope * metric.measure).reshape(dim, -1)
                for j in range(dim):
                    gradient = np.zeros((dim, *along.shape))
                    gradient[j] = along
                    stress = elasticity.stress(gradient, x)
                    for k, g in metric.gradients.items():
                        found[k, m][:, j] = np.einsum("ian,an->in", stress, g.reshape(dim, -1))
            return {key: each.reshape(dim * dim, *shape) for key, each in found.items()}

        data = entries(self.multipatch, self._pattern, Form(dim, coefficients), self.comm)
        return block_matrix(self._pattern, data, dim, self.comm)

    def mass(self, rho: Density) -> Any:
        """Return the consistent mass (kg) for a density (kg/m^3), symmetric."""
        return self._of_each_component(self._products(rho))

    def geometric_stiffness(self, elasticity: Elasticity, displacement: Floats) -> Any:
        """Return the geometric stiffness int sigma_ij d_i N_a d_j N_b of a displacement (N/m)."""
        dim = self.dim

        def coefficients(metric: Metric) -> Coefficients:
            slope = metric.field_gradient
            flat = elasticity.stress(slope.reshape(dim, dim, -1), metric.x.reshape(dim, -1))
            stress = flat.reshape(slope.shape) * metric.measure
            pulled = {
                k: np.einsum("ab...,b...->a...", stress, g) for k, g in metric.gradients.items()
            }
            return {
                (k, m): np.sum(metric.gradients[k] * pulled[m], axis=0)[None]
                for k, m in product(pulled, repeat=2)
            }

        form = Form(1, coefficients, displacement.reshape(-1, self.dim))
        data = entries(self.multipatch, self._pattern, form, self.comm)
        return self._of_each_component(data)

    def gyroscopic(self, rho: float, rotation: Rotation) -> Any:
        """Return Y of a rotation at 1 rad/s, kg, skew."""
        transport = self._transport(rho, rotation)
        if rotation.coriolis:
            return self._of_each_component(transport)
        spin = rotation.spin(self.dim)
        return self._sum((transport, np.eye(self.dim)), (self._products(rho), -2 * spin))

    def convective(self, rho: float, rotation: Rotation) -> Any:
        """Return Z of a rotation, kg, symmetric."""
        speeds = self._speeds(rotation)

        def coefficients(metric: Metric) -> Coefficients:
            along, weight = speeds(metric), rho * metric.measure
            return {
                (k, m): (weight * (along[k] * along[m]))[None] for k, m in product(along, repeat=2)
            }

        squares = self._scalar(coefficients)
        if rotation.coriolis:
            return self._of_each_component(squares)
        spin = rotation.spin(self.dim)
        return self._sum(
            (squares, np.eye(self.dim)),
            (self._transport(rho, rotation), spin),
            (self._products(rho), spin.T @ spin),
        )

    def _products(self, rho: Density) -> Floats:
        """Return the entries of m."""

        def coefficients(metric: Metric) -> Coefficients:
            if not callable(rho):
                return {(VALUE, VALUE): rho * metric.measure[None]}
            densities = rho(metric.x.reshape(self.dim, -1)).reshape(metric.measure.shape)
            return {(VALUE, VALUE): (densities * metric.measure)[None]}

        return self._scalar(coefficients)

    def _transport(self, rho: float, rotation: Rotation) -> Floats:
        """Return the entries of A."""
        speeds = self._speeds(rotation)

        def coefficients(metric: Metric) -> Coefficients:
            found: Coefficients = {}
            for k, speed in speeds(metric).items():
                if k != VALUE:
                    found[VALUE, k] = (rho * metric.measure * speed)[None]
                    found[k, VALUE] = -found[VALUE, k]
            return found

        return self._scalar(coefficients, sign=-1)

    def _speeds(self, rotation: Rotation) -> Callable[[Metric], dict[int, Floats]]:
        """Return a function that gives the velocity along each parameter at 1 rad/s."""
        spin, origin = rotation.spin(self.dim), np.asarray(rotation.origin[: self.dim])

        def speeds(metric: Metric) -> dict[int, Floats]:
            velocity = np.tensordot(spin, metric.x - origin[:, None, None, None], axes=1)
            return {k: np.sum(velocity * g, axis=0) for k, g in metric.gradients.items()}

        return speeds

    def _scalar(self, coefficients: Callable[[Metric], Coefficients], sign: int = 1) -> Floats:
        """Return the entries of a scalar matrix, symmetric or, for sign = -1, skew."""
        form = Form(1, coefficients)
        return entries(self.multipatch, self._pattern, form, self.comm, sign=sign)

    def _of_each_component(self, scalar: Floats) -> Any:
        return component_matrix(self._pattern, scalar, self.dim, self.comm)

    def _sum(self, *parts: tuple[Floats, Floats]) -> Any:
        """Return a sum of Kronecker products of scalar and small matrices."""
        data = combined(self._pattern, parts, self.dim)
        return block_matrix(self._pattern, data, self.dim, self.comm)
