"""One side's points against the other, and what happens between them."""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.contact.coupling import Coupling, Form
from cea.contact.interface import Interface
from cea.contact.laws import Friction, NormalLaw
from cea.errors import InputError


@dataclass(frozen=True)
class HalfPass:
    """One side's points against the other, and what happens between them.

    Parameters
    ----------
    a, b
        Names of the bodies on its two sides.
    interface
        Its points, which lie on a.
    law
        What penetrations meet.
    friction
        Friction of steady sliding; None without.
    coupling
        What becomes of the gaps at the points.
    form
        Penalty or saddle form; None leaves the choice to :func:`cea.contact.forms.chosen_forms`.
    pair
        Name of the contact it belongs to, where that is not its own: a full pass has two halves.
    added_gap
        What is added to the distance of the sides (m), at all points, shape (n,), or one number; a
        linear law takes the sides to touch.
    penetration
        Penetrations at all points in the state that is linearised about (m), shape (n,); a linear
        law needs none.

    Raises
    ------
    InputError
        When law, friction, coupling and form do not go together.
    """

    a: str
    b: str
    interface: Interface
    law: NormalLaw
    friction: Friction | None = None
    coupling: Coupling = "pointwise"
    form: Form | None = None
    pair: str | None = None
    added_gap: Floats | float = 0.0
    penetration: Floats | None = None

    def __post_init__(self) -> None:
        tied = np.isinf(self.stiffness).any()
        if tied and (self.form == "penalty" or self.coupling == "lumped"):
            allowed = "finite; or, in the saddle form, infinite everywhere"
            raise InputError("p", float("inf"), allowed)
        if self.coupling == "bonded" and self.friction is not None and self.friction.acts:
            mu = float(np.max(self.friction.mu))
            raise InputError("mu", mu, "0 where both sides are bonded")
        if self.coupling == "lumped" and self.form == "saddle":
            allowed = "penalty: lumped contact is not of the form G^T D G"
            raise InputError("form", self.form, allowed)
        if not self.law.linear:
            self._check_law()

    def _check_law(self) -> None:
        """Refuse what cannot meet its gaps by a law that is not linear."""
        if self.coupling in ("lumped", "bonded"):
            allowed = "pointwise or mortar for a law of the gap: here no gap at the points decides"
            raise InputError("coupling", self.coupling, allowed)
        if self.projected and self.form == "saddle":
            allowed = "penalty where a law meets projected gaps: open parts have no compliance"
            raise InputError("form", self.form, allowed)

    @property
    def stiffness(self) -> Floats:
        """Contact stiffness p at all points (N/m^3): the law's slope, shape (n,)."""
        points = len(self.interface.points)
        return self.law.slope(np.zeros(points) if self.penetration is None else self.penetration)

    @property
    def projected(self) -> bool:
        """Whether gaps are projected on the traces of side a."""
        return self.coupling in ("mortar", "bonded")

    @property
    def pressure(self) -> Floats:
        """Contact pressure at all points in the state that is linearised about (N/m^2), (n,).

        Raises
        ------
        InputError
            Where no such state is known: the law is linear, or was not linearised yet.
        """
        if self.penetration is None:
            raise InputError("penetration", None, "that of a steady sliding state")
        return self.law.pressure(self.penetration)


def friction_at(half: HalfPass) -> tuple[Floats, float]:
    """Friction coefficient at the points of this rank, and what of it is its size.

    Where it is zero everywhere, 1 stands in its place.
    """
    interface = half.interface
    mu = np.asarray(half.friction.mu if half.friction is not None else 0.0, dtype=float)
    varies = np.ptp(mu) != 0
    if not varies and not mu.any():
        mu = np.ones_like(mu)
    field = np.broadcast_to(mu, len(interface.points))[interface.rows]
    return field, 1.0 if varies else float(mu.flat[0])
