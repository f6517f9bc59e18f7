"""Sizes of elements that cannot end or cannot fit, refused before anything is meshed."""

from collections.abc import Iterator
from math import prod

from cea.errors import InputError
from scenes.limits import MAX_ELEMENTS
from scenes.node_grids import box_lengths, node_grids
from scenes.spec.body import BodySpec


def size_checks(place: str, body: BodySpec) -> Iterator[InputError]:
    """Faults of the size of elements, against the length of their body.

    Sizes between are refused by the memory that their mesh would take (:mod:`scenes.memory`).

    Parameters
    ----------
    place
        Path of the body.
    body
        The body, whose mesh suits its shape.
    """
    fe = body.mesh.fe
    if body.backend != "fe" or fe is None or fe.size is None:
        return
    length = max(box_lengths(body.geometry))
    if not length / MAX_ELEMENTS <= fe.size <= length:
        allowed = (
            f"{length / MAX_ELEMENTS:.3g} to {length:.3g} (m), the length of the body; such a mesh "
            f"has about {dofs_of(body):.2g} unknowns"
        )
        yield InputError(f"{place}.mesh.fe.size", fe.size, allowed)


def dofs_of(body: BodySpec) -> float:
    """Estimate of the unknowns of a body, supports not taken out."""
    dim = len(body.geometry.directions)
    return dim * sum(prod(grid.counts) for grid in node_grids(body, 1.0))
