"""Contact formulations: each one chooses points and weights on side a.

To add one, decorate a dataclass in any imported module with :func:`register`.
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
"""Treatment of the gaps at the points of an interface.

``pointwise``: a penalty at each point; ``lumped``: the same with lumped diagonal blocks;
``mortar``: the gap is projected on the traces of side a; ``bonded``: as mortar, for every
component of the jump.
"""

Form = Literal["penalty", "saddle"]
"""Whether contact forces are eliminated (penalty) or additional unknowns (saddle)."""


class Formulation(ABC):
    """A choice of points and weights on side a, and of the treatment of the gaps there.

    Each is a frozen dataclass, whose fields are those of a scene; the default of the field
    ``method``, a ``Literal``, is its name in scenes.
    """

    name: ClassVar[str]
    """Its name in figures and tables, e.g. "GPTS"."""
    abscissae: ClassVar[str | None] = None
    """Kind of abscissae that side a must have, or None for any surface.

    One of :attr:`cea.surface.Surface.abscissa_kinds`.
    """
    of_gaps: ClassVar[Coupling] = "pointwise"
    """Treatment of the gaps at its points, unless it is lumped."""

    @property
    @abstractmethod
    def method(self) -> str:
        """Name in scenes."""

    @abstractmethod
    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Return points and weights on side a, with one point per smooth part at corners.

        Parameters
        ----------
        a, b
            The two surfaces.
        reach
            Largest distance (m) between them.
        """

    @property
    def coupling(self) -> Coupling:
        """Treatment of the gaps at the points."""
        return "lumped" if getattr(self, "lumped", False) else self.of_gaps

    @property
    def options(self) -> tuple[str, ...]:
        """Options that differ from the default: weights, and lumping."""
        weights = getattr(self, "weights", "equal")
        lumped = ("lumped",) if self.coupling == "lumped" else ()
        return lumped if weights == "equal" else (weights, *lumped)

    @property
    def label(self) -> str:
        """Name, points per direction if given, and options: "GPTS 5 × 5, lumped"."""
        points = getattr(self, "points", None)
        name = self.name if points is None else f"{self.name} {points} × {points}"
        return ", ".join((name, *self.options))


_MOST_POINTS = 200  # largest number of points per direction, far above any useful rule


def _check_points(points: int, least: int = 1) -> None:
    """Raise InputError if a number of points per direction is too small or too large."""
    fits = least <= points <= _MOST_POINTS
    require(fits, "points", points, f"{least} to {_MOST_POINTS} per direction")


_REGISTER: dict[str, type[Formulation]] = {}


def register[T: type[Formulation]](formulation: T) -> T:
    """Register a formulation, a dataclass, under its method for use in scenes; a decorator."""
    where = f"{formulation.__module__}.{formulation.__qualname__}"
    if not is_dataclass(formulation):
        raise InputError("formulation", where, "a dataclass")
    method = next((f.default for f in fields(formulation) if f.name == "method"), MISSING)
    if not isinstance(method, str):
        raise InputError(f"{where}.method", None, "a field with a default, the name in scenes")
    other = _REGISTER.get(method, formulation)
    # A class that is defined again, as in a notebook, replaces itself.
    same = f"{other.__module__}.{other.__qualname__}" == where
    require(same, f"{where}.method", method, f"a name other than that of {other.__qualname__}")
    _REGISTER[method] = formulation
    return formulation


def registered() -> Mapping[str, type[Formulation]]:
    """Return the formulations that scenes may use, by method."""
    return MappingProxyType(_REGISTER)


@dataclass(frozen=True)
class AtAbscissae(Formulation):
    """Contact collocated at abscissae of side a, with one point per smooth part at corners."""

    weights: str = "equal"

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Return points and weights on side a."""
        assert self.abscissae is not None
        return a.abscissae(self.abscissae, self.weights)


@register
@dataclass(frozen=True)
class NodeToSurface(AtAbscissae):
    """Contact at the interpolation nodes of side a, one point per smooth part at corners.

    Parameters
    ----------
    weights
        ``equal``: nodes share the area of their smooth part equally. ``tributary``: nodes share the
        area of each facet in proportion to int N_i^2. Integrals of N_i are unsuitable as weights:
        they vanish at corners of quadratic triangles.
    """

    name: ClassVar[str] = "node-to-surface"
    abscissae: ClassVar[str | None] = "nodes"
    weights: Literal["equal", "tributary"] = "equal"
    method: Literal["node_to_surface"] = "node_to_surface"


@register
@dataclass(frozen=True)
class Greville(AtAbscissae):
    """Contact collocated at the Greville abscissae of side a, one point per smooth part at corners.

    Parameters
    ----------
    weights
        ``equal``: each point has the stiffness P / n_points of its smooth part
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
        ``equal``: points share the area of their smooth part equally. ``area``: the integral of the
        trace function (Matzen & Bischoff 2016).
    """

    name: ClassVar[str] = "Botella"
    abscissae: ClassVar[str | None] = "botella"
    weights: Literal["equal", "area"] = "equal"
    method: Literal["botella"] = "botella"


@register
@dataclass(frozen=True)
class Grid(Formulation):
    """Contact collocated at equally spaced points of side a.

    The points share the area of their smooth part equally.

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
        """Return points and weights on side a."""
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
        Whether the diagonal blocks are lumped (eq. 41).
    """

    name: ClassVar[str] = "GPTS"
    points: int
    lumped: bool = False
    method: Literal["gpts"] = "gpts"

    def __post_init__(self) -> None:
        _check_points(self.points)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Return points and weights on side a."""
        return a.gauss_points(self.points)


@dataclass(frozen=True)
class OnSegments(Formulation):
    """Formulations with quadrature on the common refinement of both surface meshes."""

    points: int | None = None

    def __post_init__(self) -> None:
        if self.points is not None:
            _check_points(self.points)

    def points_on(self, a: Surface, b: Surface, reach: float) -> SurfacePoints:
        """Return points and weights on side a."""
        from cea.contact.segments import segment_points  # imports shapely

        return segment_points(a, b, self.points, reach)


@register
@dataclass(frozen=True)
class Segments(OnSegments):
    """Contact at Gauss points on the common refinement of both surface meshes.

    Integrates the penalty form exactly on flat interfaces, as a reference for other rules. It
    constrains the gap at more points than side a has dofs, and locks as p grows.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None: exact on flat interfaces.
    """

    name: ClassVar[str] = "segments"
    method: Literal["segments"] = "segments"


@register
@dataclass(frozen=True)
class Mortar(OnSegments):
    """Gap projected on the traces of side a, segments as quadrature (:mod:`cea.contact.mortar`).

    The reference contact formulation: it has as many gap constraints as side a has dofs, and does
    not lock at any stiffness. Traces are split at corners of side a into one per smooth part.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None: exact on flat interfaces.
    """

    name: ClassVar[str] = "mortar"
    of_gaps: ClassVar[Coupling] = "mortar"
    method: Literal["mortar"] = "mortar"


@register
@dataclass(frozen=True)
class Bonded(OnSegments):
    """Both sides tied in every direction, without friction, to join nonmatching meshes of one body.

    The jump is projected on the trace space of side a, as in mortar contact.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None: exact on flat interfaces.
    """

    name: ClassVar[str] = "bonded"
    of_gaps: ClassVar[Coupling] = "bonded"
    method: Literal["bonded"] = "bonded"
