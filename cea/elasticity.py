"""Linear elasticity in material axes, which may turn from point to point.

    sigma = R S R^T,    S_pq = C_pqrs (R^T grad u R)_rs

with the tensor C in the axes of the material, the columns of R(x). Matrices of constants have the
order 11, 22, 33, 23, 13, 12 of Voigt (Ting, Anisotropic Elasticity, 1996, sec. 2.3).
"""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats, of_size_one
from cea.errors import InputError
from cea.expressions import Expression

VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Components of the tensors of stress and strain in the order of their six numbers."""

_PARALLEL = 1e-6
"""Sine of the angle below which two directions make no axes."""
_COUPLED = 1e-9
"""Largest out-of-plane shear stress of a strain in the plane, relative to the largest constant."""

Component = float | str


@dataclass(frozen=True)
class Axes:
    """Material axes along given directions.

    Parameters
    ----------
    first, second
        Directions of axes 1 and 2, three components each: numbers, or expressions in the
        coordinates (:class:`cea.expressions.Expression`). What of the second lies along the first
        is taken away; axis 3 is normal to both, right-handed.
    """

    first: tuple[Component, Component, Component]
    second: tuple[Component, Component, Component]

    @property
    def uniform(self) -> bool:
        """Whether they are the same everywhere."""
        return not any(isinstance(each, str) for each in (*self.first, *self.second))

    def check(self, dim: int, field: str) -> None:
        """Refuse what is no expression in the coordinates of space, and parallel directions."""
        for name, direction in (("first", self.first), ("second", self.second)):
            for i, each in enumerate(direction):
                if isinstance(each, str):
                    Expression(each).check(f"{field}.{name}.{i}", dim)
        if self.uniform:
            self.at(np.zeros((dim, 1)), field)

    def at(self, x: Floats, field: str = "material.axes") -> Floats:
        """R at positions x (m), shape (dim, n): the axes as columns, (3, 3, n)."""
        first, second = (_field(each, x) for each in (self.first, self.second))
        e1 = _unit(first, first, f"{field}.first")
        e2 = _unit(second - e1 * np.sum(e1 * second, axis=0), second, f"{field}.second")
        return np.stack([e1, e2, np.cross(e1, e2, axis=0)], axis=1)


@dataclass(frozen=True)
class CylindricalAxes:
    """Material axes 1, 2, 3 in radial, circumferential and axial direction.

    Parameters
    ----------
    cylindrical_about
        Direction of the axis, any length but zero; along z in the plane.
    origin
        A point of the axis (m).
    """

    cylindrical_about: tuple[float, float, float]
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    uniform = False

    def check(self, dim: int, field: str) -> None:
        """Refuse an axis without a direction, and one that leaves the plane oblique."""
        axis = self.cylindrical_about
        if not (np.isfinite(axis).all() and np.any(axis)) or (dim == 2 and any(axis[:2])):
            allowed = "a finite vector that is not zero" + (", along z" if dim == 2 else "")
            raise InputError(f"{field}.cylindrical_about", axis, allowed)

    def at(self, x: Floats, field: str = "material.axes") -> Floats:
        """R at positions x (m), shape (dim, n): the axes as columns, (3, 3, n)."""
        axis = of_size_one(self.cylindrical_about)
        e3 = np.repeat((axis / np.linalg.norm(axis))[:, None], x.shape[1], axis=1)
        arm = np.zeros_like(e3)
        arm[: len(x)] = x - np.asarray(self.origin, dtype=float)[: len(x), None]
        e1 = _unit(arm - e3 * np.sum(e3 * arm, axis=0), arm, f"{field}.cylindrical_about")
        return np.stack([e1, np.cross(e3, e1, axis=0), e3], axis=1)


@dataclass(frozen=True, eq=False)
class Elasticity:
    """Stress of a displacement gradient at any point of a body.

    Parameters
    ----------
    matrix
        Constants in the axes of the material (N/m^2), symmetric, shape (6, 6).
    axes
        The axes; those of space if left out.
    """

    matrix: Floats
    axes: Axes | CylindricalAxes | None = None

    @property
    def varies(self) -> bool:
        """Whether the tensor is not the same everywhere."""
        return self.axes is not None and not self.axes.uniform

    def stress(self, gradient: Floats, x: Floats) -> Floats:
        """Cauchy stress.

        Parameters
        ----------
        gradient
            ``gradient[i, j] = d u_i / d x_j``, shape (dim, dim, n).
        x
            Positions (m), shape (dim, n); not looked at where the tensor is uniform.

        Returns
        -------
        ndarray
            Stress (N/m^2), shape (dim, dim, n); in the plane that of plane strain.

        Raises
        ------
        InputError
            When axes do not exist at a point, or strains in the plane shear it out of the plane.
        """
        dim, count = len(gradient), gradient.shape[2]
        if not self.varies:
            return (self._tensor(dim) @ gradient.reshape(dim * dim, -1)).reshape(gradient.shape)
        R = self.axes.at(x)  # type: ignore[union-attr]
        along = np.einsum("ipn,ijn,jqn->pqn", R[:dim], gradient, R[:dim], optimize=True)
        own = (_tensor(self.matrix) @ along.reshape(9, -1)).reshape(3, 3, count)
        return np.einsum("ipn,pqn,jqn->ijn", R[:dim], own, R[:dim], optimize=True)

    def _tensor(self, dim: int) -> Floats:
        """Of a uniform tensor in the axes of space, the map of gradients, (dim^2, dim^2)."""
        whole = _tensor(self.matrix)
        if self.axes is not None:
            R = self.axes.at(np.zeros((dim, 1)))[:, :, 0]
            turn = np.kron(R, R)
            whole = turn @ whole @ turn.T
        return whole.reshape((3,) * 4)[:dim, :dim, :dim, :dim].reshape(dim * dim, -1)

    def check(self, dim: int, field: str) -> None:
        """Refuse axes that do not exist, and in the plane those that shear out of it."""
        if self.axes is not None:
            self.axes.check(dim, f"{field}.axes")
        if dim == 3:
            return
        at = np.full((3, 1), 0.5)
        turn = np.eye(3) if self.axes is None else self.axes.at(at[:2])[:, :, 0]
        turned = np.kron(turn, turn)
        c = (turned @ _tensor(self.matrix) @ turned.T).reshape((3,) * 4)
        if np.abs(c[:2, 2, :2, :2]).max() > _COUPLED * np.abs(self.matrix).max():
            allowed = "constants and axes that are symmetric about the plane (plane strain)"
            raise InputError(field, "shear out of the plane", allowed)


def _tensor(matrix: Floats) -> Floats:
    """C as the map of gradients, both in the order of their rows, (9, 9)."""
    place = np.zeros((3, 3), dtype=int)
    for number, (i, j) in enumerate(VOIGT):
        place[i, j] = place[j, i] = number
    return matrix[np.ix_(place.ravel(), place.ravel())]


def _field(components: tuple[Component, ...], x: Floats) -> Floats:
    """A vector given by components at positions x (dim, n), (3, n)."""
    values = [
        Expression(c)(x.T) if isinstance(c, str) else np.full(x.shape[1], c) for c in components
    ]
    return np.stack(values)


def _unit(vector: Floats, whole: Floats, field: str) -> Floats:
    """Vectors of length one, (3, n); refused where hardly anything is left of the whole."""
    length = np.linalg.norm(vector, axis=0)
    if not (length > _PARALLEL * np.linalg.norm(whole, axis=0)).all():
        raise InputError(field, "no direction somewhere", "a direction of its own at every point")
    return vector / length
