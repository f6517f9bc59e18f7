"""Linear elasticity in the axes of a material, which may turn from point to point.

    sigma = R S R^T,    S_pq = C_pqrs (R^T grad u R)_rs

with the tensor C in the axes of the material, the columns of R(x). Matrices of constants have the
order 11, 22, 33, 23, 13, 12 of Voigt (Ting, Anisotropic Elasticity, 1996, sec. 2.3).
"""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from cea.expressions import Expression

_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
_PARALLEL = 1e-6
"""Sine of the angle below which two directions make no axes."""
_SHEAR = 1e-9
"""Shear out of the plane that counts as none, relative to the largest stress."""

Direction = tuple[float | str, float | str, float | str]
"""Components: numbers, or expressions in the coordinates."""


@dataclass(frozen=True)
class Axes:
    """Axes of a material: along two given directions, or cylindrical.

    Parameters
    ----------
    first, second
        Directions of axes 1 and 2; what of the second lies along the first is taken away. Axis 3 is
        normal to both, right-handed.
    cylindrical_about
        Direction of axis 3, given in the place of both: axis 1 is radial, 2 circumferential.
    origin
        A point of that axis (m).
    """

    first: Direction | None = None
    second: Direction | None = None
    cylindrical_about: tuple[float, float, float] | None = None
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if (self.cylindrical_about is None) == (self.first is None or self.second is None):
            raise InputError("axes", self, "first and second, or cylindrical_about")

    @property
    def uniform(self) -> bool:
        """Whether they are the same everywhere."""
        given = (*(self.first or ("",)), *(self.second or ("",)))
        return not any(isinstance(each, str) for each in given)

    def at(self, x: Floats) -> Floats:
        """R at positions x (m), shape (dim, n): the axes as columns, (3, 3, n)."""
        if self.cylindrical_about is None:
            one, other = (_vectors(each, x) for each in (self.first, self.second))
            e1 = _unit(one, one)
            e2 = _unit(other - e1 * np.sum(e1 * other, axis=0), other)
            return np.stack([e1, e2, np.cross(e1, e2, axis=0)], axis=1)
        axis = _vectors(self.cylindrical_about, x)
        e3, arm = _unit(axis, axis), np.zeros_like(axis)
        arm[: len(x)] = x - np.asarray(self.origin, dtype=float)[: len(x), None]
        e1 = _unit(arm - e3 * np.sum(e3 * arm, axis=0), arm)
        return np.stack([e1, np.cross(e3, e1, axis=0), e3], axis=1)


@dataclass(frozen=True, eq=False)
class Elasticity:
    """Stress of a displacement gradient at any point of a body."""

    matrix: Floats  # constants in the axes of the material (N/m^2), symmetric, shape (6, 6)
    axes: Axes | None = None  # None for those of space

    @property
    def varies(self) -> bool:
        """Whether the tensor is not the same everywhere."""
        return self.axes is not None and not self.axes.uniform

    def stress(self, gradient: Floats, x: Floats) -> Floats:
        """Cauchy stress (N/m^2), shape (dim, dim, n); in the plane that of plane strain.

        With ``gradient[i, j] = d u_i / d x_j``, shape (dim, dim, n), at positions x (m), shape
        (dim, n), which are not looked at where the tensor is uniform. Refused where there are no
        axes at a point.
        """
        dim, tensor = len(gradient), self.matrix[np.ix_(_VOIGT.ravel(), _VOIGT.ravel())]
        if not self.varies:
            if self.axes is not None:
                R = self.axes.at(np.zeros((3, 1)))[:, :, 0]
                turn = np.kron(R, R)
                tensor = turn @ tensor @ turn.T
            own = tensor.reshape((3,) * 4)[:dim, :dim, :dim, :dim].reshape(dim * dim, -1)
            return (own @ gradient.reshape(dim * dim, -1)).reshape(gradient.shape)
        R = self.axes.at(x)[:dim]  # type: ignore[union-attr]
        along = np.einsum("ipn,ijn,jqn->pqn", R, gradient, R, optimize=True)
        own = (tensor @ along.reshape(9, -1)).reshape(along.shape)
        return np.einsum("ipn,pqn,jqn->ijn", R, own, R, optimize=True)

    def check(self, dim: int, field: str) -> None:
        """Refuse axes that do not exist, and in the plane those that shear out of it."""
        somewhere = np.repeat(np.sqrt([[2.0], [3.0], [5.0]])[:dim], 4, axis=1)  # on no axis
        try:
            stress = self.stress(np.eye(9)[:, [0, 1, 3, 4]].reshape(3, 3, 4), somewhere)
        except InputError as error:
            raise InputError(f"{field}.axes", error.value, error.allowed) from None
        if dim == 2 and np.abs(stress[2, :2]).max() > _SHEAR * np.abs(stress).max():
            allowed = "constants and axes that are symmetric about the plane (plane strain)"
            raise InputError(field, "shear out of the plane", allowed)


def _vectors(components: Direction | None, x: Floats) -> Floats:
    """Vectors at positions x (dim, n), (3, n)."""
    return np.stack([Expression(str(each))(x.T) for each in components or ()])


def _unit(vectors: Floats, whole: Floats) -> Floats:
    """Vectors of length one, (3, n); refused where hardly anything is left of the whole."""
    length = np.linalg.norm(vectors, axis=0)
    if not (length > _PARALLEL * np.linalg.norm(whole, axis=0)).all():
        raise InputError("axes", "no direction somewhere", "directions that differ at every point")
    return vectors / length
