"""Mortar contact."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.coupling import Coupling
from cea.contact.formulations.base import register
from cea.contact.formulations.segments import OnSegments


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

    method: Literal["mortar"] = "mortar"

    @property
    def coupling(self) -> Coupling:
        """The gap projected."""
        return "mortar"
