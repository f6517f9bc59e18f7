"""Problems with exact eigenvalues: the scene, its meshes, the listed band, the exact list."""

from dataclasses import dataclass
from math import pi

import numpy as np

from cea.arrays import Complexes
from exact_cea.reference import whole_spectrum

_BEYOND = 1.1
"""Upper end of the search relative to that of the listed band: edge modes keep their partners."""
_FAR = 1.15
"""Upper end of the exact list relative to that of the listed band."""
_REAL = 1e-9
"""Growth rates below this part of abs(lambda) are rounding of the exact solver."""


@dataclass(frozen=True)
class BodyMesh:
    """Elements of a body on the coarsest mesh.

    Parameters
    ----------
    name
        Name of the body in the scene.
    coarsest
        Elements along each direction.
    closed
        Directions that run all the way round.
    in_contact
        Directions along the contact surface.
    """

    name: str
    coarsest: tuple[int, ...]
    closed: tuple[bool, ...]
    in_contact: tuple[bool, ...]

    def elements(self, refinement: int) -> tuple[int, ...]:
        """Elements along each direction of a refined mesh."""
        return tuple(n * refinement for n in self.coarsest)


@dataclass(frozen=True)
class Problem:
    """A problem with exact eigenvalues.

    Parameters
    ----------
    name
        Name of its scene.
    bodies
        Bodies a and b; their meshes never match.
    band
        Lowest and highest Im lambda of the listed modes.
    mu
        Friction coefficient, or its amplitude.
    solver
        Name of the problem of :mod:`exact_cea.reference` that it is.
    unit
        Unit of the contact stiffness p (N/m^3).
    profile
        The friction coefficient in the scene, with ``{mu}`` for the number.
    depth
        Length in z between rollers; None in plane strain, and for the ring.
    geometry_degree
        Of Lagrange elements, where the rims of both bodies must meet on coarse meshes; None takes
        that of the displacements, 2 at least on curved bodies.
    most_dofs
        Of a case at the first stiffness of a thorough study, where fewer do not resolve the band on
        several meshes; None takes those of the study.
    highest_order
        Order of convergence in lambda that a singularity caps; None where there is none.
    """

    name: str
    bodies: tuple[BodyMesh, BodyMesh]
    band: tuple[float, float]
    mu: float
    solver: str
    unit: float = 1.0
    profile: str = "{mu}"
    depth: float | None = None
    geometry_degree: int | None = None
    most_dofs: int | None = None
    highest_order: float | None = None

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return len(self.bodies[0].coarsest)

    @property
    def friction(self) -> float | str:
        """Friction coefficient as scenes have it: a number, or an expression."""
        return self.mu if self.profile == "{mu}" else self.profile.format(mu=self.mu)

    @property
    def max_frequency(self) -> float:
        """Highest frequency searched (Hz)."""
        return _BEYOND * self.band[1] / (2 * pi)

    @property
    def highest_exact(self) -> float:
        """Upper end of the exact list, well beyond the band: Im lambda."""
        return _FAR * self.band[1]

    def exact(self, stiffness: float) -> Complexes:
        """Exact eigenvalues with Im >= 0 to well beyond the band, by frequency, computed.

        Parameters
        ----------
        stiffness
            Contact stiffness relative to the unit.
        """
        values = whole_spectrum(
            self.solver,
            max_frequency=self.highest_exact,
            depth=self.depth,
            p=stiffness * self.unit,
            mu=self.mu,
        ).values
        values = np.where(np.abs(values.real) < _REAL * np.abs(values), 1j * values.imag, values)
        return values[np.lexsort((values.real, values.imag))]

    def listed(self, values: Complexes) -> Complexes:
        """Those of the band."""
        return values[(values.imag >= self.band[0]) & (values.imag <= self.band[1])]


_PLANE_RING = (False, True), (False, True)
_PLANE_BLOCK = (False, False), (True, False)
_WALL = (False, True, False), (False, True, True)
_PLATE = (False, True, False), (True, True, False)
_BLOCK = (False, False, False), (True, False, True)
_SINE = "{mu}*abs(sin(pi*x/2))"
"""Not negative at a wall by rounding of its coordinate either."""


def _pair(
    a: tuple[str, tuple[int, ...]],
    b: tuple[str, tuple[int, ...]],
    directions: tuple[tuple[bool, ...], tuple[bool, ...]],
) -> tuple[BodyMesh, BodyMesh]:
    return BodyMesh(*a, *directions), BodyMesh(*b, *directions)


_LAYERS = _pair(("upper", (4, 1)), ("lower", (3, 2)), _PLANE_BLOCK)

PROBLEMS = {
    p.name: p
    for p in (
        Problem(
            "drum",
            _pair(("outer", (1, 12)), ("inner", (1, 8)), _PLANE_RING),
            band=(0.0, 2.5),
            mu=0.3,
            solver="drum",
        ),
        Problem(
            "drum_3d",
            _pair(("outer", (1, 12, 2)), ("inner", (1, 8, 3)), _WALL),
            band=(0.0, 2.2),
            mu=0.7,
            solver="drum",
            depth=1.0,
        ),
        Problem("blocks", _LAYERS, band=(0.0, 3.3), mu=1.0, profile=_SINE, solver="blocks"),
        Problem(
            "blocks_constant_mu",
            _LAYERS,
            band=(0.0, 3.3),
            mu=0.7,
            solver="blocks_constant",
            highest_order=2.0,
        ),
        Problem(
            "blocks_3d",
            _pair(("upper", (4, 1, 3)), ("lower", (3, 2, 4)), _BLOCK),
            band=(0.0, 2.8),
            mu=1.0,
            profile=_SINE,
            solver="blocks",
            depth=2.0,
        ),
        Problem(
            "ring",
            _pair(("pad", (1, 12, 1)), ("disc", (2, 16, 1)), _PLATE),
            band=(1e4, 9e4),
            unit=1e12,
            mu=0.3,
            solver="ring",
            geometry_degree=4,
            most_dofs=13_000,
        ),
    )
}
"""Problems by name."""
