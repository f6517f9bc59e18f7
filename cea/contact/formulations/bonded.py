"""Bonded joints."""

from dataclasses import dataclass
from typing import Literal

from cea.contact.formulations.mortar import Mortar


@dataclass(frozen=True)
class Bonded(Mortar):
    """Both sides tied in every direction, without friction: parts of one body that do not match.

    The jump is projected on the trace space of side a, as in :class:`Mortar`.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    method: Literal["bonded"] = "bonded"  # type: ignore[assignment]
