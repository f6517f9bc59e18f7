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
    """A body with the elements along each direction of its coarsest mesh."""

    name: str
    coarsest: tuple[int, ...]
    closed: tuple[bool, ...]  # directions that run all the way round
    in_contact: tuple[bool, ...]  # directions along the contact surface

    def elements(self, refinement: int) -> tuple[int, ...]:
        """Elements along each direction of a refined mesh."""
        return tuple(n * refinement for n in self.coarsest)


@dataclass(frozen=True)
class Problem:
    """A problem with exact eigenvalues, by the name of its scene."""

    name: str
    bodies: tuple[BodyMesh, BodyMesh]  # a and b; their meshes never match
    band: tuple[float, float]  # lowest and highest Im lambda of the listed modes
    mu: float  # friction coefficient, or its amplitude
    solver: str  # name of the problem of exact_cea.reference
    unit: float = 1.0  # of the contact stiffness p (N/m^3)
    profile: str = "{mu}"  # the friction coefficient in the scene
    depth: float | None = None  # length in z between rollers; None in plane strain and of the ring
    geometry_degree: int | None = None  # of Lagrange elements, where rims must meet
    most_dofs: int | None = None  # at the first p, where fewer resolve too little
    highest_order: float | None = None  # order of convergence in lambda that a singularity caps

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
        """Exact eigenvalues with Im >= 0 to well beyond the band, by frequency; p in the unit."""
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


_SINE = "{mu}*abs(sin(pi*x/2))"
"""Not negative at a wall by rounding of its coordinate either."""


def _pair(
    a: tuple[str, tuple[int, ...]], b: tuple[str, tuple[int, ...]], closed: str, in_contact: str
) -> tuple[BodyMesh, BodyMesh]:
    """Meshes of both bodies; letters name the directions that are closed and in contact."""
    directions = "rtz" if closed else "xyz"
    every = directions[: len(a[1])]
    flags = [tuple(d in letters for d in every) for letters in (closed, in_contact)]
    return BodyMesh(*a, *flags), BodyMesh(*b, *flags)


_LAYERS = _pair(("upper", (4, 1)), ("lower", (3, 2)), "", "x")
_RING = _pair(("outer", (1, 12)), ("inner", (1, 8)), "t", "t")
_WALL = _pair(("outer", (1, 12, 2)), ("inner", (1, 8, 3)), "t", "tz")
_BLOCKS = _pair(("upper", (4, 1, 3)), ("lower", (3, 2, 4)), "", "xz")
_PLATE = _pair(("pad", (1, 12, 1)), ("disc", (2, 16, 1)), "t", "rt")
_BAND = (0.0, 3.3)
_EVERY = (
    Problem("drum", _RING, (0.0, 2.5), 0.3, "drum"),
    Problem("drum_3d", _WALL, (0.0, 2.2), 0.7, "drum", depth=1.0),
    Problem("blocks", _LAYERS, _BAND, 1.0, "blocks", profile=_SINE),
    Problem("blocks_constant_mu", _LAYERS, _BAND, 0.7, "blocks_constant", highest_order=2.0),
    Problem("blocks_3d", _BLOCKS, (0.0, 2.8), 1.0, "blocks", profile=_SINE, depth=2.0),
    Problem(*("ring", _PLATE, (1e4, 9e4), 0.3, "ring", 1e12), geometry_degree=4, most_dofs=13_000),
)
PROBLEMS = {problem.name: problem for problem in _EVERY}
"""Problems by name."""
