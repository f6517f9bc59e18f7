"""Linear elastic solids: isotropic, orthotropic, fully anisotropic.

In the axes of a material, which may vary from point to point,

    sigma = R S R^T,    S_pq = C_pqrs (R^T grad u R)_rs

where C is the elasticity tensor in the axes of the material, which are the columns of R(x).
Matrices use Voigt's order 11, 22, 33, 23, 13, 12 (Ting, Anisotropic Elasticity, 1996, sec. 2.3).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any, ClassVar, Literal

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError, require
from cea.expressions import Expression

_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
_PARALLEL = 1e-6
"""Sine of the angle below which two directions are treated as parallel."""
_SHEAR = 1e-9
"""Out-of-plane shear stress, relative to the largest stress, below which it is treated as zero."""

Direction = tuple[float | str, float | str, float | str]
"""Components: numbers, or expressions in the coordinates."""


@dataclass(frozen=True)
class Axes:
    """Axes of a material: along two given directions, or cylindrical.

    Parameters
    ----------
    first, second
        Directions of axes 1 and 2; the component of the second along the first is removed. Axis 3
        is normal to both, right-handed.
    cylindrical_about
        Direction of axis 3, instead of the other two: axis 1 is radial, 2 circumferential.
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
        """Whether the axes are the same everywhere."""
        given = (*(self.first or ("",)), *(self.second or ("",)))
        return not any(isinstance(each, str) for each in given)

    def at(self, x: Floats) -> Floats:
        """Return R at positions x (m), shape (dim, n): the axes as columns, (3, 3, n)."""
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
    """Linear elastic law: stress of a displacement gradient at any point of a body."""

    matrix: Floats  # constants in the axes of the material (N/m^2), symmetric, shape (6, 6)
    axes: Axes | None = None  # None: the coordinate axes
    factor: Callable[[Floats], Floats] | None = None  # of the stress, (dim, n) to (n,); None: 1

    @property
    def varies(self) -> bool:
        """Whether the elasticity tensor varies in space."""
        turns = self.axes is not None and not self.axes.uniform
        return turns or self.factor is not None

    def stress(self, gradient: Floats, x: Floats) -> Floats:
        """Return the Cauchy stress (N/m^2), shape (dim, dim, n); plane strain in 2D.

        The gradient is ``gradient[i, j] = d u_i / d x_j``, shape (dim, dim, n), at positions x (m),
        shape (dim, n). Raise :class:`InputError` if the axes are undefined at a point.
        """
        if self.factor is not None:
            return replace(self, factor=None).stress(gradient, x) * self.factor(x)
        dim, tensor = len(gradient), self.matrix[np.ix_(_VOIGT.ravel(), _VOIGT.ravel())]
        if self.axes is None:
            own = tensor.reshape((3,) * 4)[:dim, :dim, :dim, :dim].reshape(dim * dim, -1)
            return (own @ gradient.reshape(dim * dim, -1)).reshape(gradient.shape)
        R = self.axes.at(x)[:dim]
        along = np.einsum("ipn,ijn,jqn->pqn", R, gradient, R, optimize=True)
        own = (tensor @ along.reshape(9, -1)).reshape(along.shape)
        return np.einsum("ipn,pqn,jqn->ijn", R, own, R, optimize=True)

    def check(self, dim: int, field: str) -> None:
        """Raise InputError for undefined axes and, in 2D, for shear out of the plane."""
        somewhere = np.repeat(np.sqrt([[2.0], [3.0], [5.0]])[:dim], 4, axis=1)  # on no axis
        try:
            stress = self.stress(np.eye(9)[:, [0, 1, 3, 4]].reshape(3, 3, 4), somewhere)
        except InputError as error:
            raise InputError(f"{field}.axes", error.value, error.allowed) from None
        if dim == 2 and np.abs(stress[2, :2]).max() > _SHEAR * np.abs(stress).max():
            allowed = "constants and axes that are symmetric about the plane (plane strain)"
            raise InputError(field, "shear out of the plane", allowed)


def _vectors(components: Direction | None, x: Floats) -> Floats:
    """Return vectors at positions x (dim, n), shape (3, n)."""
    return np.stack([Expression(str(each))(x.T) for each in components or ()])


def _unit(vectors: Floats, whole: Floats) -> Floats:
    """Return unit vectors, (3, n); InputError if a vector is tiny relative to ``whole``."""
    length = np.linalg.norm(vectors, axis=0)
    if not (length > _PARALLEL * np.linalg.norm(whole, axis=0)).all():
        raise InputError("axes", "undefined at some point", "directions that differ at every point")
    return vectors / length


class Material(ABC):
    """Base of all solids; ``rho`` (kg/m^3) may be None if no mass is needed (static scenes)."""

    rho: float | None
    axes: Axes | None = None

    @property
    @abstractmethod
    def constants(self) -> dict[str, float]:
        """Constants that are parameters of the matrix pencil, by the paths of their fields."""

    @abstractmethod
    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Return the elasticity matrix (N/m^2), (6, 6), for given, perhaps complex, constants."""

    @property
    def entries(self) -> dict[tuple[int, int], tuple[str, ...]]:
        """Constants that each entry of the elasticity matrix depends on; {} if isotropic."""
        return {}

    def __post_init__(self) -> None:
        given = self.rho is None or 0 < self.rho < inf
        require(given, "material.rho", self.rho, "a positive number (kg/m^3)")

    def density(self, field: str) -> float:
        """Return the density (kg/m^3); raise InputError if it is None."""
        if self.rho is None:
            raise InputError(f"{field}.rho", None, "a density (kg/m^3) is needed for eigenvalues")
        return self.rho

    @cached_property
    def elasticity(self) -> Elasticity:
        """Elastic law in the axes of the material."""
        return Elasticity(self.matrix_of(self.constants), self.axes)

    @cached_property
    def means(self) -> tuple[float, float, float]:
        """Young's modulus, shear modulus (N/m^2) and Poisson's ratio of the isotropic average.

        Reuss average over all orientations (Hill, Proc. Phys. Soc. A 65 (1952) 349).
        """
        s = np.linalg.inv(self.elasticity.matrix)
        normal, cross, shear = np.trace(s[:3, :3]), s[0, 1] + s[0, 2] + s[1, 2], np.trace(s[3:, 3:])
        K, G = 1 / (normal + 2 * cross), 15 / (4 * (normal - cross) + 3 * shear)
        return 9 * K * G / (3 * K + G), G, (3 * K - 2 * G) / (6 * K + 2 * G)


@dataclass(frozen=True)
class IsotropicMaterial(Material):
    """Linear isotropic elastic solid.

    Parameters
    ----------
    E
        Young's modulus (N/m^2), positive.
    nu
        Poisson's ratio, between -1 and 0.5, both excluded.
    rho
        Density (kg/m^3), positive; None where no mass is needed (static scenes).
    """

    E: float
    nu: float
    rho: float | None = None
    kind: ClassVar[str] = "isotropic"

    def __post_init__(self) -> None:
        require(0 < self.E < inf, "material.E", self.E, "a positive number (N/m^2)")
        require(-1 < self.nu < 0.5, "material.nu", self.nu, "between -1 and 0.5, both excluded")
        super().__post_init__()

    @property
    def lame(self) -> tuple[float, float]:
        """Lame parameters (lambda, mu) (N/m^2) of the solid; plane strain uses the same."""
        lam = self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))
        return lam, self.E / (2 * (1 + self.nu))

    @property
    def constants(self) -> dict[str, float]:
        """Young's modulus."""
        return {"E": self.E}

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Return the elasticity matrix (N/m^2), (6, 6), for a given Young's modulus."""
        lam, mu = self.lame
        matrix = mu * np.diag([2.0, 2, 2, 1, 1, 1])
        matrix[:3, :3] += lam
        return constants["E"] / self.E * matrix

    @property
    def means(self) -> tuple[float, float, float]:
        """Young's modulus, shear modulus (N/m^2) and Poisson's ratio."""
        return self.E, self.lame[1], self.nu


class SolidOfConstants(Material):
    """Solid with several constants; its elasticity matrix must be positive definite."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in self.constants.items():
            positive = name[0] in "EG"
            valid = (0 if positive else -inf) < value < inf
            require(valid, f"material.{name}", value, f"a {'positive ' * positive}number")
        matrix = self.matrix_of(self.constants)
        diagonal = np.abs(np.diag(matrix))
        scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        least = float(np.linalg.eigvalsh(matrix / scale / scale[:, None])[0])
        allowed = "constants that are positive definite (abs(nu_ij) < sqrt(E_i / E_j) and more)"
        told = f"{allowed}: the least eigenvalue of their scaled matrix is {least:.2g}"
        require(least > 0, "material.constants", self.constants, told)


@dataclass(frozen=True)
class OrthotropicMaterial(SolidOfConstants):
    """Solid with three planes of symmetry, or isotropic about its axis 3.

    The compliance in the axes of the material (Ting, Anisotropic Elasticity, 1996, sec. 2.6):
    eps_ii = sigma_ii / E_i - sum_j nu_ji / E_j sigma_jj, nu_ij / E_i = nu_ji / E_j.

    Parameters
    ----------
    E_1, E_2, E_3
        Young's moduli along the axes of the material (N/m^2).
    nu_12, nu_13, nu_23
        Poisson's ratios: nu_ij is the contraction along j under a tension along i.
    G_12, G_13, G_23
        Shear moduli (N/m^2). If E_2, nu_23, G_12 and G_23 are all omitted, the solid is
        transversely isotropic: every direction in the plane 1-2 is equivalent to axis 1.
    rho
        Density (kg/m^3), positive; None where no mass is needed (static scenes).
    axes
        Axes of the material; the coordinate axes if omitted.
    """

    kind: Literal["orthotropic"]
    E_1: float
    E_3: float
    nu_12: float
    nu_13: float
    G_13: float
    E_2: float | None = None
    nu_23: float | None = None
    G_12: float | None = None
    G_23: float | None = None
    rho: float | None = None
    axes: Axes | None = None

    @property
    def constants(self) -> dict[str, float]:
        """Given constants by field name: nine, or five."""
        given = {name: value for name, value in vars(self).items() if name[0] in "EnG"}
        return {name: value for name, value in given.items() if value is not None}

    @property
    def entries(self) -> dict[tuple[int, int], tuple[str, ...]]:
        """All constants, for each of the nine entries."""
        places = ((i, j) for i in range(6) for j in range(i, 6) if i == j or j < 3)
        return dict.fromkeys(places, tuple(self.constants))

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Return the elasticity matrix (N/m^2), (6, 6), for given, perhaps complex, constants."""
        c = dict(constants)
        if len(c) == 5:
            E, nu = c["E_1"], c["nu_12"]
            c |= {"E_2": E, "nu_23": c["nu_13"], "G_23": c["G_13"]}
            c["G_12"] = E / (2 * (1 + nu)) if nu != -1 else np.inf
        order = ("E_1", "E_2", "E_3", "G_23", "G_13", "G_12")
        inverse = np.diag([1 / c[name] for name in order]).astype(np.result_type(*c.values()))
        for i, j in ((0, 1), (0, 2), (1, 2)):
            inverse[i, j] = inverse[j, i] = -c[f"nu_{i + 1}{j + 1}"] / c[f"E_{i + 1}"]
        return np.linalg.inv(inverse)

    def __post_init__(self) -> None:
        allowed = "nine constants, or E_1, E_3, nu_12, nu_13, G_13 for isotropy about axis 3"
        known = sorted(self.constants)
        require(len(known) in (5, 9), "material.constants", known, allowed)
        super().__post_init__()


@dataclass(frozen=True)
class AnisotropicMaterial(SolidOfConstants):
    """Solid without material symmetry.

    Parameters
    ----------
    C
        Constants (N/m^2) by name, ``C_11`` to ``C_66``, the first index not above the second, in
        the order 11, 22, 33, 23, 13, 12. Omitted constants are zero.
    rho
        Density (kg/m^3), positive; None where no mass is needed (static scenes).
    axes
        Axes of the material; the coordinate axes if omitted.
    """

    kind: Literal["anisotropic"]
    C: Mapping[str, float]
    rho: float | None = None
    axes: Axes | None = None

    @property
    def constants(self) -> dict[str, float]:
        """Given constants by the paths of their fields."""
        return {f"C.{name}": value for name, value in self.C.items()}

    @property
    def entries(self) -> dict[tuple[int, int], tuple[str, ...]]:
        """The constant of each given entry."""
        return {place: (f"C.{name}",) for place, name in _ENTRIES.items() if name in self.C}

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Return the elasticity matrix (N/m^2), (6, 6), for given, perhaps complex, constants."""
        matrix = np.zeros((6, 6), dtype=np.result_type(0.0, *constants.values()))
        for (i, j), name in _ENTRIES.items():
            matrix[i, j] = matrix[j, i] = constants.get(f"C.{name}", 0.0)
        return matrix

    def __post_init__(self) -> None:
        unknown = sorted(set(self.C) - set(_ENTRIES.values()))
        require(not unknown, "material.C", unknown, "C_11, C_12, ... C_66")
        super().__post_init__()


_ENTRIES = {(i, j): f"C_{i + 1}{j + 1}" for i in range(6) for j in range(i, 6)}
