"""Nutils: Lagrange hexahedra, and the same rational splines as this program."""

from typing import Any

import numpy as np
import treelog
from nutils import function, mesh
from scipy.optimize import brentq
from scipy.sparse import csr_array

from cea.arrays import Floats
from comparisons.bench.programs.annulus import HEIGHT, INNER, MATERIAL, OUTER, Discretisation


class Nutils:
    """A vector basis on a structured topology."""

    def __init__(self, discretisation: Discretisation) -> None:
        treelog.current = treelog.NullLog()  # Nutils does not tell of its work
        self._degree = 2 * discretisation.degree
        if discretisation.family == "Q":
            scalar, self._points = self._of_boxes(discretisation)
        else:
            scalar, self._points = self._of_nurbs(discretisation)
        self._scalar, self._basis = scalar, scalar.vector(3)

    def _of_boxes(self, discretisation: Discretisation) -> tuple[Any, Any]:
        """Lagrange functions on cells with straight edges."""
        nodes = [np.linspace(0, 1, n + 1) for n in discretisation.boxes]
        self._domain, _ = mesh.rectilinear(nodes)
        s, t, height = np.meshgrid(*nodes, indexing="ij")
        radius, angle = INNER + (OUTER - INNER) * s, np.pi / 2 * t
        corners = np.stack([radius * np.cos(angle), radius * np.sin(angle), HEIGHT * height], -1)
        linear = self._domain.basis("std", degree=1)
        points = linear @ corners.reshape(-1, 3)
        return self._domain.basis("std", degree=discretisation.degree), points

    def _of_nurbs(self, discretisation: Discretisation) -> tuple[Any, Any]:
        """Splines of highest continuity times the weight of the quarter circle."""
        r, theta, z = discretisation.boxes
        angles = np.linspace(0, np.pi / 2, theta + 1)[1:-1]
        inner = [brentq(lambda t, a=a: _angle(t) - a, 0, 1, xtol=1e-15) for a in angles]
        knots = [np.linspace(0, 1, r + 1), np.array([0.0, *inner, 1.0]), np.linspace(0, 1, z + 1)]
        self._domain, at = mesh.rectilinear(knots)
        s, t, height = at
        x, y, weight = _circle(t)
        radius = INNER + (OUTER - INNER) * s
        points = np.stack([radius * x / weight, radius * y / weight, HEIGHT * height])
        splines = self._domain.basis(
            "spline", degree=discretisation.degree, knotvalues=[each.tolist() for each in knots]
        )
        of_weight = self._domain.project(weight, onto=splines, geometry=at, degree=self._degree)
        return splines * of_weight / weight, points

    def _integrated(self, integrand: Any) -> Any:
        measure = function.J(self._points)
        return self._domain.integrate(integrand * measure, degree=self._degree, legacy=True)

    def stiffness(self) -> Any:
        """Its matrix."""
        lam, mu = MATERIAL.lame
        gradients = function.grad(self._basis, self._points)
        strains = 0.5 * (gradients + np.transpose(gradients, (0, 2, 1)))
        traces = np.trace(gradients, axis1=1, axis2=2)
        shears = (strains[:, None] * strains).sum([-2, -1])
        return self._integrated(lam * traces[:, None] * traces + 2 * mu * shears)

    def mass(self) -> Any:
        """Its matrix."""
        return self._integrated(MATERIAL.rho * (self._basis[:, None] * self._basis).sum(-1))

    def compressed(self, matrix: Any) -> csr_array:
        """Rows of a matrix."""
        values, columns, starts = matrix.export("csr")
        return csr_array((values, columns, starts), matrix.shape)

    def motions(self) -> Floats:
        """Rigid motions by projection, which is exact."""
        x, y, z = self._points
        fields = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -z, y), (z, 0, -x), (-y, x, 0)]
        return np.column_stack(
            [
                self._domain.project(
                    np.stack(field),
                    onto=self._basis,
                    geometry=self._points,
                    degree=self._degree,
                )
                for field in fields
            ]
        )


def _circle(t: Any) -> tuple[Any, Any, Any]:
    """A quarter of the unit circle as a rational curve: w x, w y and its weight w."""
    middle = 2**0.5 * t * (1 - t)
    return (1 - t) ** 2 + middle, middle + t**2, (1 - t) ** 2 + middle + t**2


def _angle(t: float) -> float:
    x, y, _ = _circle(t)
    return float(np.arctan2(y, x))
