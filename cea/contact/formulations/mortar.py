"""Mortar contact."""

from dataclasses import dataclass
from typing import Literal

from cea.contact.formulations.segments import Segments


@dataclass(frozen=True)
class Mortar(Segments):
    """Gap projected on the traces of side a, segments as quadrature (:mod:`cea.contact.mortar`).

    The yardstick of contact: it enforces the gap as often as side a has dofs, at any stiffness.

    Parameters
    ----------
    points
        Gauss points per direction in each segment; None takes what is exact on flat interfaces.
    """

    method: Literal["mortar"] = "mortar"  # type: ignore[assignment]
