"""Linear elastic solids: isotropic, orthotropic, fully anisotropic."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from cea.arrays import is_number
from cea.elasticity import Axes, Elasticity
from cea.errors import InputError


class Material(ABC):
    """What all solids have; ``rho`` (kg/m^3) is None where no mass is needed (static scenes)."""

    rho: float | None
    axes: Axes | None = None

    @property
    @abstractmethod
    def constants(self) -> dict[str, float]:
        """Constants that are parameters of a pencil, by the paths of their fields."""

    @abstractmethod
    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants in its axes (N/m^2), (6, 6), of others than its own, complex ones too."""

    @property
    def entries(self) -> dict[tuple[int, int], tuple[str, ...]]:
        """Constants that each entry of the matrix depends on, of a solid that has several."""
        return {}

    def __post_init__(self) -> None:
        for fault in self._faults():
            raise fault

    def _faults(self) -> Iterator[InputError]:
        if self.rho is not None and not (is_number(self.rho) and self.rho > 0):
            yield InputError("material.rho", self.rho, "a positive number (kg/m^3)")

    def density(self, field: str) -> float:
        """Density (kg/m^3), which is needed here; refused where there is none."""
        if self.rho is None:
            raise InputError(f"{field}.rho", None, "a density (kg/m^3) is needed for eigenvalues")
        return self.rho

    @cached_property
    def elasticity(self) -> Elasticity:
        """Stress of a displacement gradient."""
        return Elasticity(self.matrix_of(self.constants), self.axes)

    @cached_property
    def means(self) -> tuple[float, float, float]:
        """Young's modulus, shear modulus (N/m^2) and Poisson's ratio of grains in all directions.

        Reuss's means (Hill, Proc. Phys. Soc. A 65 (1952) 349); of isotropic solids their own.
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

    def _faults(self) -> Iterator[InputError]:
        if not (is_number(self.E) and self.E > 0):
            raise InputError("material.E", self.E, "a positive number (N/m^2)")
        if not (is_number(self.nu) and -1 < self.nu < 0.5):
            yield InputError("material.nu", self.nu, "between -1 and 0.5, both excluded")
        yield from super()._faults()

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
        """Constants (N/m^2), (6, 6), at another modulus."""
        lam, mu = self.lame
        matrix = mu * np.diag([2.0, 2, 2, 1, 1, 1])
        matrix[:3, :3] += lam
        return constants["E"] / self.E * matrix

    @property
    def means(self) -> tuple[float, float, float]:
        """Young's modulus, shear modulus (N/m^2) and Poisson's ratio."""
        return self.E, self.lame[1], self.nu


class SolidOfConstants(Material):
    """A solid of several constants, of which the matrix has to be positive definite."""

    def _faults(self) -> Iterator[InputError]:
        yield from super()._faults()
        for name, value in self.constants.items():
            if not is_number(value) or (name[0] in "EG" and value <= 0):
                allowed = "a positive number" if name[0] in "EG" else "a number"
                yield InputError(f"material.{name}", value, allowed)
                return
        matrix = self.matrix_of(self.constants)
        scale = np.sqrt(np.abs(np.diag(matrix)))
        scaled = matrix / np.where(scale > 0, scale, 1.0) / np.where(scale > 0, scale, 1.0)[:, None]
        if (least := float(np.linalg.eigvalsh(scaled)[0])) <= 0:
            allowed = "constants that are positive definite (abs(nu_ij) < sqrt(E_i / E_j) and more)"
            told = f"{allowed}: the least eigenvalue of their scaled matrix is {least:.2g}"
            yield InputError("material.constants", self.constants, told)


@dataclass(frozen=True)
class OrthotropicMaterial(SolidOfConstants):
    """Solid with three planes of symmetry, or isotropic about its axis 3.

    The compliance in its axes (Ting, Anisotropic Elasticity, 1996, sec. 2.6):
    eps_ii = sigma_ii / E_i - sum_j nu_ji / E_j sigma_jj, nu_ij / E_i = nu_ji / E_j.

    Parameters
    ----------
    E_1, E_2, E_3
        Young's moduli along its axes (N/m^2).
    nu_12, nu_13, nu_23
        Poisson's ratios: nu_ij is the contraction along j under a tension along i.
    G_12, G_13, G_23
        Shear moduli (N/m^2). Where E_2, nu_23, G_12 and G_23 are left out, all four, the solid is
        transversely isotropic: every direction of its plane 1-2 is like axis 1.
    rho
        Density (kg/m^3), positive; None where no mass is needed (static scenes).
    axes
        Axes of the material; those of space if left out.
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
        """Its constants by the names of their fields: nine, or five."""
        given = {name: value for name, value in vars(self).items() if name[0] in "EnG"}
        return {name: value for name, value in given.items() if value is not None}

    @property
    def entries(self) -> dict[tuple[int, int], tuple[str, ...]]:
        """All constants for each of the nine entries."""
        places = ((i, j) for i in range(6) for j in range(i, 6) if i == j or j < 3)
        return dict.fromkeys(places, tuple(self.constants))

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants in its axes (N/m^2), (6, 6), of others than its own, complex ones too."""
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

    def _faults(self) -> Iterator[InputError]:
        if len(self.constants) in (5, 9):
            yield from super()._faults()
        else:
            allowed = (
                "nine constants; E_1, E_3, nu_12, nu_13, G_13 alone are isotropic about axis 3"
            )
            yield InputError("material.constants", sorted(self.constants), allowed)


@dataclass(frozen=True)
class AnisotropicMaterial(SolidOfConstants):
    """Solid without any symmetry.

    Parameters
    ----------
    C
        Constants (N/m^2) by name: ``C_11`` to ``C_66``, the first number not above the second, in
        the order 11, 22, 33, 23, 13, 12. Those left out are zero.
    rho
        Density (kg/m^3), positive; None where no mass is needed (static scenes).
    axes
        Axes of the material; those of space if left out.
    """

    kind: Literal["anisotropic"]
    C: Mapping[str, float]
    rho: float | None = None
    axes: Axes | None = None

    @property
    def constants(self) -> dict[str, float]:
        """Its constants by the paths of their fields."""
        return {f"C.{name}": value for name, value in self.C.items()}

    @property
    def entries(self) -> dict[tuple[int, int], tuple[str, ...]]:
        """A constant for each entry that is given."""
        return {place: (f"C.{name}",) for place, name in _ENTRIES.items() if name in self.C}

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants in its axes (N/m^2), (6, 6), of others than its own, complex ones too."""
        matrix = np.zeros((6, 6), dtype=np.result_type(0.0, *constants.values()))
        for (i, j), name in _ENTRIES.items():
            matrix[i, j] = matrix[j, i] = constants.get(f"C.{name}", 0.0)
        return matrix

    def _faults(self) -> Iterator[InputError]:
        if unknown := set(self.C) - set(_ENTRIES.values()):
            yield InputError("material.C", sorted(unknown), "C_11, C_12, ... C_66")
        else:
            yield from super()._faults()


_ENTRIES = {(i, j): f"C_{i + 1}{j + 1}" for i in range(6) for j in range(i, 6)}
