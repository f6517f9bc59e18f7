"""Problems with exact eigenvalues: the scene, its meshes, the listed band, the exact list."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import count
from math import pi

import numpy as np

from cea.errors import InputError
from cea.modes import Complexes
from comparisons.exact import layouts
from comparisons.exact.blocks import Blocks
from comparisons.exact.drum import Drum
from comparisons.exact.galerkin import GalerkinContact, lowest

_BEYOND = 1.1
"""Upper end of the search relative to that of the listed band: edge modes keep their partners."""
_FAR = 1.15
"""Upper end of the exact list relative to that of the listed band."""
_REAL = 1e-9
"""Growth rates below this part of abs(lambda) are rounding of the Galerkin solve."""


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
    unit
        Unit of the contact stiffness p (N/m^3).
    mu
        Friction coefficient, or its amplitude.
    profile
        The friction coefficient in the scene, with ``{mu}`` for the number.
    families
        Exact eigenvalues by p, mu and highest Im lambda: one list for each harmonic.
    highest_order
        Order of convergence in lambda that a singularity caps; None where there is none.
    contact
        Name of the contact in the scene.
    """

    name: str
    bodies: tuple[BodyMesh, BodyMesh]
    band: tuple[float, float]
    unit: float
    mu: float
    profile: str
    families: Callable[[float, float, float], Iterator[Complexes]]
    highest_order: float | None = None
    contact: str = "interface"

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return len(self.bodies[0].coarsest)

    @property
    def friction(self) -> str:
        """Friction coefficient as TOML."""
        text = self.profile.format(mu=self.mu)
        return text if self.profile == "{mu}" else f'"{text}"'

    @property
    def max_frequency(self) -> float:
        """Highest frequency searched (Hz)."""
        return _BEYOND * self.band[1] / (2 * pi)

    def exact(self, stiffness: float) -> Complexes:
        """Exact eigenvalues with Im >= 0 to well beyond the band, by frequency.

        Parameters
        ----------
        stiffness
            Contact stiffness relative to the unit.
        """
        found = list(self.families(stiffness * self.unit, self.mu, _FAR * self.band[1]))
        values = np.concatenate(found)
        values = np.where(np.abs(values.real) < _REAL * np.abs(values), 1j * values.imag, values)
        return values[np.lexsort((values.real, values.imag))]

    def listed(self, values: Complexes) -> Complexes:
        """Those of the band."""
        return values[(values.imag >= self.band[0]) & (values.imag <= self.band[1])]


def problem(name: str) -> Problem:
    """A problem by name.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name not in PROBLEMS:
        raise InputError("problem", name, f"one of {', '.join(PROBLEMS)}")
    return PROBLEMS[name]


def _family(contact: GalerkinContact, scale: float, top: float) -> Complexes:
    """Eigenvalues of one harmonic up to a frequency."""
    wanted = 12
    values = lowest(contact, wanted, scale)
    while values[-1].imag <= top:
        wanted *= 2
        values = lowest(contact, wanted, scale)
    return values[values.imag <= top]


def _harmonics(family: Callable[[int], Complexes]) -> Iterator[Complexes]:
    """Families of every circumferential order, until two in a row have no eigenvalue.

    The harmonic ``e^{-i m theta}`` has the growth rates of ``e^{i m theta}`` with the other sign.
    """
    yield family(0)
    m, last = 1, 1
    while m <= last + 2:
        values = family(m)
        if len(values):
            last = m
            yield np.concatenate([values, -values.conj()])
        m += 1


def _drum(p: float, mu: float, top: float, kz: float | None = None) -> Iterator[Complexes]:
    def family(m: int) -> Complexes:
        drum = Drum.of(m, p, mu, kz)
        return _family(layouts.drum(drum, 24), drum.scale(), top)

    return _harmonics(family)


def _drum_3d(p: float, mu: float, top: float) -> Iterator[Complexes]:
    yield from _in_depth(lambda kz: list(_drum(p, mu, top, kz)), 1.0)


def _in_depth(
    families: Callable[[float | None], list[Complexes]], depth: float
) -> Iterator[Complexes]:
    """Families of every wave number in z that rollers admit, until one has no eigenvalue."""
    for j in count():
        found = families(j * pi / depth if j else None)
        if not any(len(values) for values in found):
            return
        yield from found


def _blocks(p: float, mu: float, top: float, kz: float | None = None) -> Iterator[Complexes]:
    blocks = Blocks.of(p, mu, kz)
    degree = 24 if kz is None else 19
    yield _family(layouts.blocks(blocks, degree, 0, constant=False), blocks.scale(), top)


def _blocks_3d(p: float, mu: float, top: float) -> Iterator[Complexes]:
    yield from _in_depth(lambda kz: list(_blocks(p, mu, top, kz)), 2.0)


def _blocks_constant(p: float, mu: float, top: float) -> Iterator[Complexes]:
    blocks = Blocks.of(p, mu)
    yield _family(layouts.blocks(blocks, 12, 4, constant=True), blocks.scale(), top)


def _ring(p: float, mu: float, top: float) -> Iterator[Complexes]:
    def family(m: int) -> Complexes:
        ring = layouts.Ring.of(m, p, mu)
        return _family(layouts.ring(ring, 9, 1), ring.scale(), top)

    return _harmonics(family)


_PLANE_RING = (False, True), (False, True)
_PLANE_BLOCK = (False, False), (True, False)
_WALL = (False, True, False), (False, True, True)
_PLATE = (False, True, False), (True, True, False)
_BLOCK = (False, False, False), (True, False, True)
_SINE = "{mu}*sin(pi*x/2)"


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
            *((0.0, 2.5), 1.0, 0.3, "{mu}", _drum),
        ),
        Problem(
            "drum_3d",
            _pair(("outer", (1, 12, 2)), ("inner", (1, 8, 3)), _WALL),
            *((0.0, 2.2), 1.0, 0.7, "{mu}", _drum_3d),
        ),
        Problem("blocks", _LAYERS, (0.0, 3.3), 1.0, 1.0, _SINE, _blocks),
        Problem(
            "blocks_constant_mu",
            _LAYERS,
            *((0.0, 3.3), 1.0, 0.7, "{mu}", _blocks_constant),
            highest_order=2.0,
        ),
        Problem(
            "blocks_3d",
            _pair(("upper", (4, 1, 3)), ("lower", (3, 2, 4)), _BLOCK),
            *((0.0, 2.8), 1.0, 1.0, _SINE, _blocks_3d),
        ),
        Problem(
            "ring",
            _pair(("pad", (1, 12, 1)), ("disc", (2, 16, 1)), _PLATE),
            *((1e4, 9e4), 1e12, 0.3, "{mu}", _ring),
        ),
    )
}
"""Problems by name."""


@cache
def exact(name: str, stiffness: float) -> Complexes:
    """Exact eigenvalues of a problem, computed once."""
    return problem(name).exact(stiffness)
