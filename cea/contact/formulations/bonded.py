"""Bonded joints."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from cea.contact.coupling import Coupling
from cea.contact.formulations.base import register
from cea.contact.formulations.segments import OnSegments


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

    method: Literal["bonded"] = "bonded"

    @property
    def coupling(self) -> Coupling:
        """Every component of the jump tied."""
        return "bonded"
