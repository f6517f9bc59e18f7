"""What a contact formulation says of itself, and the register of those a scene may name."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import MappingProxyType
from typing import ClassVar

from cea.contact.coupling import Coupling
from cea.errors import InputError
from cea.surface import Surface
from cea.surface_points import SurfacePoints


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
        return "pointwise"

    @property
    def options(self) -> tuple[str, ...]:
        """What sets it apart from its simplest form, in words."""
        return ()

    @property
    def label(self) -> str:
        """Name, points per direction where they are given, and options: "GPTS 5 × 5, lumped"."""
        points = getattr(self, "points", None)
        name = self.name if points is None else f"{self.name} {points} × {points}"
        return ", ".join((name, *self.options))


MOST_POINTS = 200
"""Points per direction in an element: far more than any rule needs."""


def check_points(points: int, least: int = 1) -> None:
    """Refuse a number of points per direction that makes no rule, or one beyond any use.

    Raises
    ------
    InputError
        Naming the points.
    """
    if not least <= points <= MOST_POINTS:
        raise InputError("points", points, f"{least} to {MOST_POINTS} per direction")


_REGISTER: dict[str, type[Formulation]] = {}


def register[T: type[Formulation]](formulation: T) -> T:
    """Let scenes name a formulation by its method; a decorator.

    Raises
    ------
    InputError
        When the class is no dataclass, its method has no default, or another class has the name.
    """
    where = f"{formulation.__module__}.{formulation.__qualname__}"
    if not is_dataclass(formulation):
        raise InputError("formulation", where, "a dataclass")
    method = next((f.default for f in fields(formulation) if f.name == "method"), MISSING)
    if not isinstance(method, str):
        raise InputError(f"{where}.method", None, "a field with a default, the name in scenes")
    other = _REGISTER.get(method, formulation)
    # The same class defined once more, as a notebook does, takes its own place.
    if f"{other.__module__}.{other.__qualname__}" != where:
        raise InputError(f"{where}.method", method, f"a name that {other.__qualname__} has not")
    _REGISTER[method] = formulation
    return formulation


def registered() -> Mapping[str, type[Formulation]]:
    """Formulations that scenes may name, by method."""
    return MappingProxyType(_REGISTER)
