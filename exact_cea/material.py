"""Isotropic materials in exact numbers, and the gap condition between two bodies."""

from dataclasses import dataclass
from typing import Annotated

from flint import acb, arb

from cea.errors import InputError
from exact_cea.numbers import Exact, positive


@dataclass(frozen=True)
class Material:
    """Linear isotropic solid, in any consistent units."""

    E: Annotated[Exact, "Young's modulus"]
    nu: Annotated[Exact, "Poisson's ratio"]
    rho: Annotated[Exact, "Density"]

    @classmethod
    def of(
        cls,
        E: str | float | Exact,
        nu: str | float | Exact,
        rho: str | float | Exact,
        body: str = "body",
    ) -> "Material":
        """Return a material from numbers or strings; error messages name it by ``body``.

        Refused unless E > 0, -1 < nu < 1/2 and rho > 0.
        """
        poisson = Exact(nu, f"{body}.nu")
        if not -1 < float(poisson) < 0.5:
            raise InputError(f"{body}.nu", str(nu), "between -1 and 0.5, both excluded")
        return cls(positive(f"{body}.E", E), poisson, positive(f"{body}.rho", rho))

    @property
    def lame(self) -> tuple[arb, arb]:
        """Lame parameters (L, G) at the current precision."""
        E, nu = self.E.arb, self.nu.arb
        return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))

    @property
    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of pressure and shear waves, in double precision."""
        L, G = (float(value) for value in self.lame)
        rho = float(self.rho)
        return ((L + 2 * G) / rho) ** 0.5, (G / rho) ** 0.5

    def __str__(self) -> str:
        return f"E={self.E} nu={self.nu} rho={self.rho}"


SOFT = Material.of("0.1", "0.25", "0.35", "a")
STIFF = Material.of("1", "0.3", "1", "b")


@dataclass(frozen=True)
class Response:
    """Normal displacement of one harmonic of a body under tractions on its interface.

    ``u = (normal * s + tangential * t) / free`` for the amplitudes s of the normal and t of the
    tangential stress. Zeros of ``free`` are the eigenvalues of the body with a free interface. All
    three are entire functions of ``lambda^2``.
    """

    free: acb
    normal: acb
    tangential: acb


def join(a: Response, b: Response, p: Exact) -> tuple[acb, acb]:
    """Coefficients of s and t in the gap condition ``s / p = u^a - u^b``, times ``free^a free^b``.

    With friction, t = mu s, the characteristic function is the first plus mu times the second.
    """
    compliance = arb(0) if p.infinite else 1 / p.arb
    normal = a.normal * b.free - b.normal * a.free - compliance * a.free * b.free
    return normal, a.tangential * b.free - b.tangential * a.free
