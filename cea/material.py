"""Linear elastic solids: isotropic, orthotropic, fully anisotropic.

The compliance of an orthotropic solid in its axes (Ting, Anisotropic Elasticity, 1996, sec. 2.6):

    eps_ii = sigma_ii / E_i - sum_j nu_ji / E_j sigma_jj,    nu_ij / E_i = nu_ji / E_j,
    2 eps_ij = sigma_ij / G_ij.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from cea.arrays import Floats, is_number
from cea.elasticity import Axes, CylindricalAxes, Elasticity
from cea.errors import InputError, refuse


class Material(ABC):
    """What all solids have; ``rho`` (kg/m^3) is None where no mass is needed (static scenes)."""

    rho: float | None
    axes: Axes | CylindricalAxes | None = None

    @property
    @abstractmethod
    def constants(self) -> dict[str, float]:
        """Constants that are parameters of a pencil, by the names of their fields."""

    @abstractmethod
    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants in its axes (N/m^2), (6, 6), of others than its own, complex ones too."""

    @cached_property
    def matrix(self) -> Floats:
        """Constants in its axes (N/m^2), (6, 6)."""
        return self.matrix_of(self.constants)

    def __post_init__(self) -> None:
        refuse(self._faults())

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
        return Elasticity(self.matrix, self.axes)

    @cached_property
    def means(self) -> tuple[float, float]:
        """Bulk and shear modulus (N/m^2) of many grains in random directions at one stress.

        Reuss's means (Hill, Proc. Phys. Soc. A 65 (1952) 349), of isotropic solids their own.
        """
        s = np.linalg.inv(self.matrix)
        normal, cross, shear = np.trace(s[:3, :3]), s[0, 1] + s[0, 2] + s[1, 2], np.trace(s[3:, 3:])
        return 1 / (normal + 2 * cross), 15 / (4 * (normal - cross) + 3 * shear)

    @property
    def modulus(self) -> float:
        """Young's modulus (N/m^2) that tells how stiff the solid is, a mean of all directions."""
        bulk, shear = self.means
        return 9 * bulk * shear / (3 * bulk + shear)

    @property
    def lateral(self) -> float:
        """Poisson's ratio that tells how nearly incompressible the solid is."""
        bulk, shear = self.means
        return (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)


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
    kind: Literal["isotropic"] = "isotropic"

    def _faults(self) -> Iterator[InputError]:
        if not (is_number(self.E) and self.E > 0):
            yield InputError("material.E", self.E, "a positive number (N/m^2)")
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
        """The constant that is a parameter."""
        return {"E": self.E}

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants (N/m^2), (6, 6), at another modulus."""
        lam, mu = self.lame
        matrix = mu * np.diag([2.0, 2, 2, 1, 1, 1])
        matrix[:3, :3] += lam
        return constants["E"] / self.E * matrix

    @property
    def modulus(self) -> float:
        """Young's modulus (N/m^2)."""
        return self.E

    @property
    def lateral(self) -> float:
        """Poisson's ratio."""
        return self.nu


@dataclass(frozen=True)
class OrthotropicMaterial(Material):
    """Solid with three planes of symmetry, or isotropic about its axis 3.

    Parameters
    ----------
    E_1, E_2, E_3
        Young's moduli along its axes (N/m^2).
    nu_12, nu_13, nu_23
        Poisson's ratios: nu_ij is the contraction along j under a tension along i.
    G_12, G_13, G_23
        Shear moduli (N/m^2). With E_2, nu_23, G_12 and G_23 left out, all four, the solid is
        transversely isotropic: they are those of its plane 1-2.
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
    axes: Axes | CylindricalAxes | None = None

    @property
    def constants(self) -> dict[str, float]:
        """Its constants by the names of their fields: nine, or five."""
        every = {name: value for name, value in vars(self).items() if name[0] in "EnG"}
        return {name: value for name, value in every.items() if value is not None}

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants in its axes (N/m^2), (6, 6), of others than its own, complex ones too."""
        return np.linalg.inv(_compliance(constants))

    def _faults(self) -> Iterator[InputError]:
        yield from super()._faults()
        given, wrong = self.constants, False
        if len(given) not in (5, 9):
            yield InputError(
                "material", sorted(given), "nine constants, or E_1, E_3, nu_12, nu_13, G_13"
            )
            return
        for name, value in given.items():
            modulus = name[0] != "n"
            if not is_number(value) or (modulus and value <= 0):
                wrong = True
                allowed = "a positive number (N/m^2)" if modulus else "a number"
                yield InputError(f"material.{name}", value, allowed)
        if wrong:
            return
        inverse = _compliance(given)
        for i, j in ((1, 2), (1, 3), (2, 3)):
            bound = (inverse[j - 1, j - 1] / inverse[i - 1, i - 1]) ** 0.5
            ratio = -inverse[i - 1, j - 1] / inverse[i - 1, i - 1]
            if not abs(ratio) < bound:
                allowed = f"below sqrt(E_{i} / E_{j}) = {bound:g} in size"
                yield InputError(f"material.nu_{i}{j}", ratio, allowed)
                return
        if (least := _least(inverse)) <= 0:
            ratios = {name: value for name, value in given.items() if name[0] == "n"}
            allowed = f"ratios whose compliance is positive definite: its least is {least:.2g} here"
            yield InputError("material", ratios, allowed)


@dataclass(frozen=True)
class AnisotropicMaterial(Material):
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
    axes: Axes | CylindricalAxes | None = None

    def _faults(self) -> Iterator[InputError]:
        yield from super()._faults()
        for name, value in self.C.items():
            if name not in _ENTRIES:
                yield InputError(f"material.C.{name}", value, "one of C_11, C_12, ... C_66")
                return
        for size in range(1, 7):
            if _least(self.matrix[:size, :size]) <= 0:
                name = f"C_{size}{size}"
                allowed = "so large that the constants up to it are positive definite"
                yield InputError(f"material.C.{name}", self.C.get(name, 0.0), allowed)
                return

    @property
    def constants(self) -> dict[str, float]:
        """Its constants by the paths of their fields."""
        return {f"C.{name}": value for name, value in self.C.items()}

    def matrix_of(self, constants: Mapping[str, Any]) -> Any:
        """Constants in its axes (N/m^2), (6, 6), of others than its own, complex ones too."""
        matrix = np.zeros((6, 6), dtype=np.result_type(*constants.values()))
        for name, value in constants.items():
            i, j = _ENTRIES[name.removeprefix("C.")]
            matrix[i, j] = matrix[j, i] = value
        return matrix


_ENTRIES = {f"C_{i + 1}{j + 1}": (i, j) for i in range(6) for j in range(i, 6)}


def _compliance(c: Mapping[str, Any]) -> Any:
    """Compliance (m^2/N), (6, 6), of nine constants, or five."""
    if "E_2" not in c:
        E, nu = c["E_1"], c["nu_12"]
        shear = E / (2 * (1 + nu)) if nu != -1 else np.inf
        c = {**c, "E_2": E, "nu_23": c["nu_13"], "G_23": c["G_13"], "G_12": shear}
    inverse = np.diag([1 / c[name] for name in ("E_1", "E_2", "E_3", "G_23", "G_13", "G_12")])
    for i, j in ((1, 2), (1, 3), (2, 3)):
        inverse[i - 1, j - 1] = inverse[j - 1, i - 1] = -c[f"nu_{i}{j}"] / c[f"E_{i}"]
    return inverse


def _least(matrix: Floats) -> float:
    """Smallest eigenvalue of a symmetric matrix scaled to ones on its diagonal."""
    diagonal = np.diag(matrix)
    if not (np.isfinite(matrix).all() and diagonal.min() > 0):
        return -np.inf
    scale = 1 / np.sqrt(diagonal)
    return float(np.linalg.eigvalsh(scale[:, None] * matrix * scale)[0])
