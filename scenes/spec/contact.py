"""What a scene says of a contact."""

from dataclasses import dataclass
from typing import Annotated, Any, Union

from pydantic import Discriminator, Field, GetCoreSchemaHandler, Tag
from pydantic_core import CoreSchema

from cea.contact.formulations import Form, Formulation, registered
from cea.contact.friction import AlongField, AlongVector, Circumferential
from cea.contact.laws import NormalCompliance
from cea.errors import InputError
from cea.expressions import Expression
from scenes.spec.body import Backend


class _Registered:
    """Lets pydantic read every registered formulation, told apart by ``method``."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        every: Any = Union[tuple(registered().values())]  # noqa: UP007  (made of a list)
        return handler.generate_schema(Annotated[every, Field(discriminator="method")])


_DIRECTIONS = {
    "vector": "AlongVector",
    "circumferential_about": "Circumferential",
    "field": "AlongField",
}
"""Kinds of directions of friction by the field that each needs."""


def _kind_of_direction(value: Any) -> str | None:
    """The kind of a direction of friction; None where none of the fields is given."""
    if not isinstance(value, dict):
        return type(value).__name__
    return next((kind for name, kind in _DIRECTIONS.items() if name in value), None)


Direction = Annotated[
    Annotated[AlongVector, Tag("AlongVector")]
    | Annotated[Circumferential, Tag("Circumferential")]
    | Annotated[AlongField, Tag("AlongField")],
    Discriminator(
        _kind_of_direction,
        custom_error_type="form",
        custom_error_message="a table {vector = ...}, {circumferential_about = ...}, {field = ...}",
    ),
]


@dataclass(frozen=True)
class SlidingSpec:
    """What a contact does to small velocities because it slides at a speed.

    Each is a number or an expression in the coordinates.

    Parameters
    ----------
    pressure
        Contact pressure of steady sliding (N/m^2); left out where c_n makes it of the loads.
    speed
        Speed of sliding (m/s): friction that turns with the direction of sliding then damps motion
        across it, mu pressure / speed; in space only.
    mu_slope
        Derivative of mu in the speed (s/m), at constant pressure; below zero it feeds energy in.
    """

    pressure: float | str | None = None
    speed: float | str | None = None
    mu_slope: float | str | None = None

    def __post_init__(self) -> None:
        if isinstance(self.pressure, float) and not self.pressure >= 0:
            raise InputError("pressure", self.pressure, "greater than or equal to 0 (N/m^2)")
        if isinstance(self.speed, float) and not self.speed > 0:
            raise InputError("speed", self.speed, "greater than 0 (m/s)")
        if self.speed is None and self.mu_slope is None:
            raise InputError("speed", None, "speed, mu_slope or both")
        for name, value in self.fields.items():
            if isinstance(value, str):
                Expression(value).check(name)

    @property
    def fields(self) -> dict[str, float | str | None]:
        """What is given, and None for what is not, by name."""
        return {"pressure": self.pressure, "speed": self.speed, "mu_slope": self.mu_slope}


@dataclass(frozen=True)
class ContactSpec:
    """A contact between side a, where the points lie, and side b.

    Parameters
    ----------
    a, b
        Sides as "body.surface".
    formulation
        Points and weights.
    P
        Global contact stiffness, the integral of p over the interface (N/m).
    p
        Contact stiffness (N/m^3), a number or an expression in the coordinates
        (:class:`cea.expressions.Expression`), which is zero where the sides have lifted off;
        either P or p is given, or c_n.
    c_n, m_n
        Normal compliance -sigma_n = c_n (u_n - g_n)_+^m_n (N/m^(2 + m_n)), m_n 1 or more, 1 by
        default: the loads press the sides together, and p is that of steady sliding.
    added_gap
        With c_n: what is added to the distance between the sides (m), a number or an expression.
    mu
        Friction coefficient, likewise.
    friction_direction_on_a
        Direction of the friction traction on side a: {vector = [...]} or
        {circumferential_about = [...], origin = [...]}, or {field = [...]} with an expression for
        each component.
    full_pass
        Whether points lie on both sides, each half with half the stiffness; P and mu as in a half
        pass. Of the larger side, points that find nothing opposite are dropped.
    form
        ``penalty``, or ``saddle``: contact forces as unknowns, which takes P = inf too. Left open,
        it is the penalty form where that costs no more than six digits, saddle where it would.
    reach
        Largest distance (m) between the sides; left out, they must touch.
    max_missed
        Largest fraction of side a that may find nothing on side b.
    sliding
        Speed, pressure and slope of friction, where they damp or feed small motions.
    """

    a: str
    b: str
    formulation: Annotated[Formulation, _Registered()]
    P: Annotated[float, Field(gt=0, allow_inf_nan=True)] | None = None
    p: Annotated[float, Field(allow_inf_nan=True)] | str | None = None
    c_n: Annotated[float, Field(allow_inf_nan=True)] | None = None
    m_n: Annotated[float, Field(allow_inf_nan=True)] | None = None
    added_gap: float | str = 0.0
    mu: float | str = 0.0
    friction_direction_on_a: Direction | None = None
    full_pass: bool = False
    form: Form | None = None
    reach: Annotated[float, Field(gt=0)] | None = None
    max_missed: Annotated[float, Field(ge=0, lt=1)] = 0.0
    sliding: SlidingSpec | None = None

    def __post_init__(self) -> None:
        for name, value in (("p", self.p), ("mu", self.mu), ("added_gap", self.added_gap)):
            if isinstance(value, str):
                Expression(value).check(name)
        p, mu = _constant(self.p), _constant(self.mu)
        if p is not None and not p > 0:
            raise InputError("p", self.p, "greater than 0")
        if mu is not None and not mu >= 0:
            raise InputError("mu", self.mu, "greater than or equal to 0")
        self._check_stiffness()
        if self.mu != 0 and self.friction_direction_on_a is None:
            raise InputError("friction_direction_on_a", None, "needed when mu is not zero")
        coupling = self.formulation.coupling
        for name, stiffness in (("P", self.P), ("p", self.p)):
            if stiffness == float("inf") and self.form == "penalty":
                raise InputError(name, stiffness, "finite, or form = 'saddle'")
            if stiffness == float("inf") and coupling == "lumped":
                raise InputError(name, stiffness, "finite where lumped")
        if coupling == "lumped" and self.form == "saddle":
            raise InputError("form", "saddle", "penalty where lumped")
        if coupling == "bonded" and (self.mu != 0 or self.full_pass):
            method = self.formulation.method
            raise InputError("formulation.method", method, "a half pass with mu = 0")
        if self.sliding is not None:
            self._check_sliding()

    def _check_sliding(self) -> None:
        if self.formulation.coupling == "bonded":
            allowed = "one that is not bonded where it slides"
            raise InputError("formulation", self.formulation.method, allowed)
        if self.friction_direction_on_a is None:
            raise InputError("friction_direction_on_a", None, "needed where it slides")

    @property
    def law(self) -> NormalCompliance | None:
        """Its normal compliance; None where its stiffness is given."""
        return None if self.c_n is None else NormalCompliance(self.c_n, self.m_n or 1.0)

    def _check_stiffness(self) -> None:
        """Refuse another number of stiffnesses than one, and what does not go with a law."""
        given = {"P": self.P, "p": self.p, "c_n": self.c_n}
        if sum(value is not None for value in given.values()) != 1:
            others = ", ".join(f"{name} = {value}" for name, value in given.items() if name != "P")
            raise InputError("P", self.P, f"either P, p or c_n is given, not both ({others})")
        if self.c_n is None:
            for name, value in (("m_n", self.m_n), ("added_gap", self.added_gap or None)):
                if value is not None:
                    raise InputError(name, value, "left out where c_n is not given")
            return
        if self.m_n is not None:
            NormalCompliance(1.0, self.m_n)
        NormalCompliance(self.c_n, 1.0)
        if self.formulation.coupling in ("lumped", "bonded"):
            allowed = "one whose gaps at points meet a law, where c_n is given: not lumped, bonded"
            raise InputError("formulation.method", self.formulation.method, allowed)
        if self.formulation.coupling == "mortar" and self.form == "saddle":
            allowed = "penalty where c_n is given: open parts of mortar contact have no compliance"
            raise InputError("form", self.form, allowed)


def _constant(value: float | str | None) -> float | None:
    """Value of a field that is the same everywhere, else None."""
    return Expression(value).constant if isinstance(value, str) else value


_ABSCISSAE: dict[Backend, tuple[str, ...]] = {"fe": ("nodes",), "iga": ("greville", "botella")}
"""Kinds of abscissae that surfaces of each backend have."""


def suits(formulation: Formulation | type[Formulation], backend: Backend) -> bool:
    """Whether surfaces of a backend have the abscissae that a formulation needs."""
    return formulation.abscissae is None or formulation.abscissae in _ABSCISSAE[backend]
