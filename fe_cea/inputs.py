"""Refusal of what no Lagrange body can be made of."""

from collections.abc import Mapping
from typing import Any

from cea.errors import InputError


def check_degrees(degree: int, mass_quadrature: int | None, field: str) -> None:
    """Refuse a degree of the space that is not 1 to 4, and a negative one of a quadrature.

    Raises
    ------
    InputError
        Naming degree or mass_quadrature below the name of the field.
    """
    if type(degree) is not int or not 1 <= degree <= 4:
        raise InputError(f"{field}.degree", degree, "1 to 4")
    if mass_quadrature is not None and mass_quadrature < 0:
        raise InputError(f"{field}.mass_quadrature", mass_quadrature, "0 or more")


def check_tags(facet_tags: Any, surface_tags: Mapping[str, int], comm: Any, field: str) -> None:
    """Refuse a surface without facets on any rank; collective.

    Raises
    ------
    InputError
        Naming the surface.
    """
    for surface, tag in surface_tags.items():
        if comm.allreduce(len(facet_tags.find(tag))) == 0:
            raise InputError(f"{field}.surfaces.{surface}", tag, "the tag of some facets")
