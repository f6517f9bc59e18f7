"""Which programs assemble what."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec

from cea.errors import InputError
from comparisons.bench.annulus import Boxes, Discretisation, Family

_HERE = "comparisons.bench.assembly.programs"
OURS = "this program"
PLAIN = "dolfinx"

DEGREES: Mapping[Family, tuple[int, ...]] = {
    "NURBS": (2, 3, 4),
    "Q": (1, 2, 3, 4),
    "P": (1, 2, 3, 4),
}
"""Degrees of each family."""
YARDSTICK: tuple[Family, int] = ("Q", 2)
"""What every other is measured by: plain dolfinx, assembled in each round beside the others."""


@dataclass(frozen=True)
class Entrant:
    """A program that takes part.

    Parameters
    ----------
    name
        Its name in tables.
    module
        Its file in this folder's ``programs``.
    degrees
        Degrees that it knows of each family.
    needs
        The package it needs beside those of this program.
    """

    name: str
    module: str
    degrees: Mapping[Family, tuple[int, ...]]
    needs: str | None = None

    @property
    def path(self) -> str:
        """Its module."""
        return f"{_HERE}.{self.module}"

    @property
    def installed(self) -> bool:
        """Whether what it needs is there."""
        return self.needs is None or find_spec(self.needs) is not None

    def knows(self, discretisation: Discretisation) -> bool:
        """Whether it can assemble a body so divided."""
        return discretisation.degree in self.degrees.get(discretisation.family, ())


_LAGRANGE: Mapping[Family, tuple[int, ...]] = {name: DEGREES[name] for name in ("Q", "P")}

ENTRANTS = (
    Entrant(OURS, "ours", DEGREES),
    Entrant(PLAIN, "plain_dolfinx", _LAGRANGE),
    Entrant("dolfinx, mass of vectors", "dolfinx_of_vectors", _LAGRANGE),
    Entrant("NGSolve", "ngsolve_forms", _LAGRANGE, "ngsolve"),
    Entrant("MFEM", "mfem_forms", _LAGRANGE, "mfem"),
    Entrant("scikit-fem", "scikit_fem", {"Q": (1, 2), "P": (1, 2)}, "skfem"),
    Entrant("Nutils", "nutils_integrals", {"NURBS": (2, 3, 4), "Q": (1, 2, 3, 4)}, "nutils"),
)
"""Every program; the first two come with this one."""


def discretisations(names: Iterable[str], boxes: Boxes, finest: Boxes) -> list[Discretisation]:
    """Discretisations by their names; all without any.

    Parameters
    ----------
    names
        As ``Q2`` or ``NURBS3``.
    boxes
        How the body is divided.
    finest
        How it is divided for Lagrange functions of degree 4, whose matrices are the largest.

    Raises
    ------
    InputError
        When there is none of a name.
    """
    known = {f"{family}{q}": (family, q) for family, of in DEGREES.items() for q in of}
    chosen = list(names) or list(known)
    for name in chosen:
        if name not in known:
            raise InputError("only", name, f"one of {', '.join(known)}")
    found = []
    for family, degree in (known[name] for name in chosen):
        most = finest if family != "NURBS" and degree == max(DEGREES[family]) else boxes
        found.append(Discretisation(family, degree, most))
    return found


def entrant(name: str) -> Entrant:
    """The program of a name."""
    return next(each for each in ENTRANTS if each.name == name)
