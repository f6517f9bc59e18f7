"""Contact formulations: each a choice of points and weights on side a.

A new one is a dataclass, in any module that is imported, which :func:`register` lets scenes name.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from types import MappingProxyType
from typing import ClassVar, Literal

from cea.errors import InputError, require
from cea.surface import Surface
from cea.surface_points import SurfacePoints

Coupling = Literal["pointwise", "lumped", "mortar", "bonded"]
"""What becomes of the gaps at the points of an interface.

``pointwise``: a penalty at each; ``lumped``: the same, the blocks of each side summed onto their
diagonal; ``mortar``: the gap projected on the traces of side a; ``bonded``: as mortar, with every
component of the jump tied.
"""

Form = Literal["penalty", "saddle"]
"""Whether contact forces are eliminated (penalty) or unknowns of their own (saddle)."""


class Formulation(ABC):
    """A choice of points and weights on side a, and of what becomes of the gaps there.

    Each is a frozen dataclass. Its fields are what a scene can say of it; the field ``method``, a
    ``Literal`` with a default, is the name by which a scene asks for it.
    """

    name: ClassVar[str]
    """Its name as people write it, e.g. "GPTS"."""
    abscissae: ClassVar[str | None] = None
    """Kind of abscissae that side a must have; None where it suits every surface.

    One of :attr:`cea.surface.Surface.abscissa_kinds`.
    """
    of_gaps: ClassVar[Coupling] = "pointwise"
    """What becomes of the gaps at its points, unless it is lumped."""

    @property
    @abstractmethod
    def method(self) -> str:
        """Name by which a scene asks for it."""

    @abstractmethod
    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a; at a corner a point with its own normal for each face.

        Parameters
        ----------
        a, b
            The two surfaces.
        reach
            Largest distance (m) between them.
        """

    @property
    def coupling(self) -> Coupling:
        """What becomes of the gaps at the points."""
        return "lumped" if getattr(self, "lumped", False) else self.of_gaps

    @property
    def options(self) -> tuple[str, ...]:
        """What sets it apart from its simplest form: its weights, and whether it is lumped."""
        weights = getattr(self, "weights", "equal")
        lumped = ("lumped",) if self.coupling == "lumped" else ()
        return lumped if weights == "equal" else (weights, *lumped)

    @property
    def label(self) -> str:
        """Name, points per direction where they are given, and options: "GPTS 5 × 5, lumped"."""
        points = getattr(self, "points", None)
        name = self.name if points is None else f"{self.name} {points} × {points}"
        return ", ".join((name, *self.options))


_MOST_POINTS = 200  # points per direction in an element: far more than any rule needs


def _check_points(points: int, least: int = 1) -> None:
    """Refuse a number of points per direction that makes no rule, or one beyond any use."""
    fits = least <= points <= _MOST_POINTS
    require(fits, "points", points, f"{least} to {_MOST_POINTS} per direction")


_REGISTER: dict[str, type[Formulation]] = {}


def register[T: type[Formulation]](formulation: T) -> T:
    """Let scenes name a formulation, a dataclass, by its method; a decorator."""
    where = f"{formulation.__module__}.{formulation.__qualname__}"
    if not is_dataclass(formulation):
        raise InputError("formulation", where, "a dataclass")
    method = next((f.default for f in fields(formulation) if f.name == "method"), MISSING)
    if not isinstance(method, str):
        raise InputError(f"{where}.method", None, "a field with a default, the name in scenes")
    other = _REGISTER.get(method, formulation)
    # The same class defined once more, as a notebook does, takes its own place.
    same = f"{other.__module__}.{other.__qualname__}" == where
    require(same, f"{where}.method", method, f"a name that {other.__qualname__} has not")
    _REGISTER[method] = formulation
    return formulation


def registered() -> Mapping[str, type[Formulation]]:
    """Formulations that scenes may name, by method."""
    return MappingProxyType(_REGISTER)


@dataclass(frozen=True)
class AtAbscissae(Formulation):
    """Contact collocated at abscissae of the traces of side a, at a corner once for each face."""

    weights: str = "equal"

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        assert self.abscissae is not None
        return a.abscissae(self.abscissae, self.weights)


@register
@dataclass(frozen=True)
class NodeToSurface(AtAbscissae):
    """Contact at the interpolation nodes of side a, at a corner once for each face.

    Parameters
    ----------
    weights
        ``equal``: each node bears the same share of the area of its smooth part. ``tributary``:
        each facet's area shared among its nodes in proportion to int N_i^2. Integrals of N_i are
        no weights: they vanish at corners of quadratic triangles.
    """

    name: ClassVar[str] = "node-to-surface"
    abscissae: ClassVar[str | None] = "nodes"
    weights: Literal["equal", "tributary"] = "equal"
    method: Literal["node_to_surface"] = "node_to_surface"


@register
@dataclass(frozen=True)
class Greville(AtAbscissae):
    """Contact collocated at the Greville abscissae of side a, at a corner once for each face.

    Parameters
    ----------
    weights
        ``equal``: each point carries the stiffness P / n_points of its smooth part
        (Mohanasundaram et al. 2023, section 3). ``area``: the integral of its trace function
        (Matzen & Bischoff 2016).
    """

    name: ClassVar[str] = "Greville"
    abscissae: ClassVar[str | None] = "greville"
    weights: Literal["equal", "area"] = "equal"
    method: Literal["greville"] = "greville"


@register
@dataclass(frozen=True)
class Botella(AtAbscissae):
    """Contact collocated at the maxima of the B-splines of side a (Botella 2002).

    Parameters
    ----------
    weights
        ``equal``: each point bears the same share of the area of its smooth part. ``area``: the
        integral of its trace function (Matzen & Bischoff 2016).
    """

    name: ClassVar[str] = "Botella"
    abscissae: ClassVar[str | None] = "botella"
    weights: Literal["equal", "area"] = "equal"
    method: Literal["botella"] = "botella"


@register
@dataclass(frozen=True)
class Grid(Formulation):
    """Contact collocated at equally spaced points of side a.

    Each has the same share of the area of its smooth part.

    Parameters
    ----------
    points
        Points per direction over each NURBS face, or per side of each facet of a mesh; both
        include the boundary.
    """

    name: ClassVar[str] = "grid"
    points: int
    method: Literal["grid"] = "grid"

    def __post_init__(self) -> None:
        _check_points(self.points, least=2)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.grid(self.points)


@register
@dataclass(frozen=True)
class GaussPointToSurface(Formulation):
    """Contact at Gauss points of side a (GPTS): Mohanasundaram et al. (2023), eqs. 36 and 37.

    Parameters
    ----------
    points
        Gauss points per direction in each surface element.
    lumped
        Whether the block of each side is summed onto its diagonal (eq. 41).
    """

    name: ClassVar[str] = "GPTS"
    points: int
    lumped: bool = False
    method: Literal["gpts"] = "gpts"

    def __post_init__(self) -> None:
        _check_points(self.points)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        return a.gauss_points(self.points)


@dataclass(frozen=True)
class OnSegments(Formulation):
    """Formulations whose quadrature is the common refinement of both surface meshes."""

    points: int | None = None

    def __post_init__(self) -> None:
        if self.points is not None:
            _check_points(self.points)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Points and weights on side a."""
        from cea.contact.segments import segment_points  # brings shapely and scipy.spatial

        return segment_points(a, b, self.points, reach)


@register
@dataclass(frozen=True)
class Segments(OnSegments):
    """Contact at Gauss points on the common refinement of both surface meshes.

    The exact integral of the penalty form on flat interfaces: the yardstick of quadrature. It
    enforces the gap at more points than side a has dofs, and locks as p grows.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    name: ClassVar[str] = "segments"
    method: Literal["segments"] = "segments"


@register
@dataclass(frozen=True)
class Mortar(OnSegments):
    """Gap projected on the traces of side a, segments as quadrature (:mod:`cea.contact.mortar`).

    The yardstick of contact: it enforces the gap as often as side a has dofs, at any stiffness.
    Traces that reach over a corner of side a are split into one for each face.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    name: ClassVar[str] = "mortar"
    of_gaps: ClassVar[Coupling] = "mortar"
    method: Literal["mortar"] = "mortar"


@register
@dataclass(frozen=True)
class Bonded(OnSegments):
    """Both sides tied in every direction, without friction: parts of one body that do not match.

    The jump is projected on the trace space of side a, as in mortar contact.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    name: ClassVar[str] = "bonded"
    of_gaps: ClassVar[Coupling] = "bonded"
    method: Literal["bonded"] = "bonded"
