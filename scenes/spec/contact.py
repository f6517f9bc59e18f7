"""Section of a contact in a scene."""

from dataclasses import dataclass
from math import inf
from typing import Annotated, Any, Union

from pydantic import Discriminator, Field, GetCoreSchemaHandler, GetPydanticSchema, Tag
from pydantic_core import CoreSchema

from cea.contact.formulations import Form, Formulation, registered
from cea.contact.pressure_and_friction import (
    AlongField,
    AlongVector,
    Circumferential,
    NormalCompliance,
)
from cea.errors import require
from cea.expressions import Expression
from scenes.spec.body import Backend


def _every_formulation(_: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
    """Return the schema of all registered formulations, a union discriminated by ``method``."""
    every: Any = Union[tuple(registered().values())]  # noqa: UP007  (built from a list)
    return handler.generate_schema(Annotated[every, Field(discriminator="method")])


B_ON_A = ", b on a"
"""Ending of the name of the second half of a full pass."""
_DIRECTIONS = {
    "vector": "AlongVector",
    "circumferential_about": "Circumferential",
    "field": "AlongField",
}
"""Class of a friction direction by the field that only it requires."""


def _kind_of_direction(value: Any) -> str | None:
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


def _check_field(name: str, value: float | str | None, allowed: str = "") -> None:
    """Raise an InputError for an invalid expression, or a constant of the wrong sign."""
    constant = value
    if isinstance(value, str):
        Expression(value).check(name)
        constant = Expression(value).constant
    if isinstance(constant, float) and allowed:
        zero = constant == 0 and "equal" in allowed
        require(constant > 0 or zero, name, value, allowed)


@dataclass(frozen=True)
class SlidingSpec:
    """Terms of a contact in the velocities of small motions, due to its sliding speed.

    Each field is a number or an expression in the coordinates.

    Parameters
    ----------
    pressure
        Contact pressure of steady sliding (N/m^2); left out with c_n, where the loads determine it.
    speed
        Sliding speed (m/s). Friction follows the direction of the slip velocity, which damps motion
        normal to the sliding direction by mu pressure / speed; only in three dimensions.
    mu_slope
        Derivative of mu with respect to the sliding speed (s/m); negative values are destabilising.
    """

    pressure: float | str | None = None
    speed: float | str | None = None
    mu_slope: float | str | None = None

    def __post_init__(self) -> None:
        _check_field("pressure", self.pressure, "greater than or equal to 0")
        _check_field("speed", self.speed, "greater than 0")
        _check_field("mu_slope", self.mu_slope)
        either = self.speed is not None or self.mu_slope is not None
        require(either, "speed", None, "speed, mu_slope or both")


@dataclass(frozen=True)
class ContactSpec:
    """A contact between side a, where the points lie, and side b.

    Parameters
    ----------
    a, b
        Sides as "body.surface".
    formulation
        Contact formulation: points, weights and coupling.
    P
        Global contact stiffness, the integral of p over the interface (N/m).
    p
        Contact stiffness (N/m^3), a number or an expression in the coordinates
        (:class:`cea.expressions.Expression`) that is zero where the contact is open. Exactly one of
        P, p and c_n is given.
    c_n, m_n
        Normal compliance -sigma_n = c_n (u_n - g_n)_+^m_n with c_n in N/m^(2 + m_n) and m_n >= 1,
        1 by default. The loads close the contact; p is its tangent stiffness in steady sliding.
    added_gap
        With c_n, value added to the initial gap (m), a number or an expression.
    mu
        Friction coefficient, a number or an expression.
    friction_direction_on_a
        Direction of the friction traction on side a: {vector = [...]} or
        {circumferential_about = [...], origin = [...]}, or {field = [...]} with an expression for
        each component.
    full_pass
        Whether points lie on both sides, with half the stiffness each; P and mu as in a half pass.
        Points of the larger side that have no opposite point are dropped.
    form
        ``penalty``, or ``saddle`` with contact forces as Lagrange multipliers, which also allows
        P = inf. By default penalty, unless it would lose more than six digits.
    reach
        Largest distance (m) between the sides; by default they must touch.
    max_missed
        Largest fraction of side a that may have no opposite point on side b.
    sliding
        Sliding speed, contact pressure and slope of mu, for friction terms in velocities.
    """

    a: str
    b: str
    formulation: Annotated[Formulation, GetPydanticSchema(_every_formulation)]
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
        _check_field("p", self.p, "greater than 0")
        _check_field("mu", self.mu, "greater than or equal to 0")
        _check_field("added_gap", self.added_gap)
        self._check_stiffness()
        method, coupling = self.formulation.method, self.formulation.coupling
        if inf in (self.P, self.p):
            stiffness = "P" if self.P is not None else "p"
            require(self.form != "penalty", stiffness, inf, "finite, or form = 'saddle'")
            require(coupling != "lumped", stiffness, inf, "finite for a lumped formulation")
        if coupling == "lumped":
            require(self.form != "saddle", "form", "saddle", "penalty for a lumped formulation")
        if coupling == "bonded":
            half_pass = self.mu == 0 and not self.full_pass
            require(half_pass, "formulation.method", method, "a half pass with mu = 0")
            allowed = "one that is not bonded where it slides"
            require(self.sliding is None, "formulation", method, allowed)
        directed = self.friction_direction_on_a is not None or not (self.mu or self.sliding)
        allowed = f"needed where {'it slides' if self.sliding else 'mu is not zero'}"
        require(directed, "friction_direction_on_a", None, allowed)

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Body and surface of side a, and of side b."""
        (a, _, on_a), (b, _, on_b) = self.a.partition("."), self.b.partition(".")
        return (a, on_a), (b, on_b)

    @property
    def law(self) -> NormalCompliance | None:
        """Normal compliance of the contact; None if P or p is given."""
        return None if self.c_n is None else NormalCompliance(self.c_n, self.m_n or 1.0)

    def _check_stiffness(self) -> None:
        """Require exactly one of P, p and c_n, and fields that are compatible with c_n."""
        one = sum(value is not None for value in (self.P, self.p, self.c_n)) == 1
        others = f"p = {self.p}, c_n = {self.c_n}"
        require(one, "P", self.P, f"either P, p or c_n is given, not both ({others})")
        if self.c_n is None:
            for name, value in (("m_n", self.m_n), ("added_gap", self.added_gap or None)):
                require(value is None, name, value, "left out where c_n is not given")
            return
        if self.m_n is not None:
            NormalCompliance(1.0, self.m_n)
        NormalCompliance(self.c_n, 1.0)
        method, coupling = self.formulation.method, self.formulation.coupling
        allowed = "one that evaluates a law at points, where c_n is given: not lumped, bonded"
        require(coupling not in ("lumped", "bonded"), "formulation.method", method, allowed)
        allowed = "penalty where c_n is given: open parts of mortar contact have no compliance"
        require(coupling != "mortar" or self.form != "saddle", "form", self.form, allowed)


_ABSCISSAE: dict[Backend, tuple[str, ...]] = {"fe": ("nodes",), "iga": ("greville", "botella")}
"""Kinds of abscissae available on surfaces of each backend."""


def suits(formulation: Formulation | type[Formulation], backend: Backend) -> bool:
    """Whether surfaces of a backend have the abscissae that a formulation needs."""
    return formulation.abscissae is None or formulation.abscissae in _ABSCISSAE[backend]
