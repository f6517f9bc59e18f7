"""Linear isotropic elasticity."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import is_number
from cea.errors import InputError


@dataclass(frozen=True)
class IsotropicMaterial:
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

    def __post_init__(self) -> None:
        if not (is_number(self.E) and self.E > 0):
            raise InputError("material.E", self.E, "a positive number (N/m^2)")
        if not (is_number(self.nu) and -1 < self.nu < 0.5):
            raise InputError("material.nu", self.nu, "between -1 and 0.5, both excluded")
        if self.rho is not None and not (is_number(self.rho) and self.rho > 0):
            raise InputError("material.rho", self.rho, "a positive number (kg/m^3)")

    def density(self, field: str) -> float:
        """Density (kg/m^3), which is needed here; refused where there is none."""
        if self.rho is None:
            raise InputError(f"{field}.rho", None, "a density (kg/m^3) is needed for eigenvalues")
        return self.rho

    @property
    def lame(self) -> tuple[float, float]:
        """Lame parameters (lambda, mu) (N/m^2) of the solid; plane strain uses the same."""
        lam = self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))
        return lam, self.E / (2 * (1 + self.nu))

    def stress(self, gradient: NDArray[np.float64]) -> NDArray[np.float64]:
        """Cauchy stress (N/m^2) from gradients d u_i / d x_j, shape (..., dim, dim) both."""
        lam, mu = self.lame
        dim = gradient.shape[-1]
        trace = np.trace(gradient, axis1=-2, axis2=-1)[..., None, None]
        return lam * trace * np.eye(dim) + mu * (gradient + gradient.swapaxes(-2, -1))
