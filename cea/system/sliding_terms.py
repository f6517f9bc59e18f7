"""Pieces of a pencil that contacts which slide at a speed make of velocities.

By the path of the contact in a scene, ``contacts.<name>``, the parameters are ``.sliding.speed``,
``.sliding.mu_slope`` and ``.sliding.pressure``, factors where these vary.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from cea.contact.sliding import SlidingDamping
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import Term

_KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "speed": ("m/s", {"positive": True}),
    "mu_slope": ("s/m", {"signed": True}),
    "pressure": ("N/m^2", {}),
}
"""Unit of each parameter, and what it may be."""


def sliding_terms(
    halves: Iterable[SlidingDamping], friction: Mapping[str, float]
) -> Iterator[Term]:
    """Damping of contacts that slide.

    Parameters
    ----------
    halves
        Half passes that slide.
    friction
        What mu of each contact is relative to.
    """
    halves = list(halves)
    sizes = _sizes(halves)
    for half in halves:
        pair = f"contacts.{half.contact.pair}"
        path = f"{pair}.sliding"
        powers = {
            name: {f"{path}.{name}": (sizes[f"{path}.{name}"], exponent)}
            for name, exponent in (("speed", -1.0), ("mu_slope", 1.0), ("pressure", 1.0))
            if sizes.get(f"{path}.{name}")
        }
        pressed = powers.get("pressure", {})
        if half.turning is not None:
            mu = {f"{pair}.mu": (friction[half.contact.pair], 1.0)}
            yield Term("damping", half.turning, Coefficient.of(pressed | mu | powers["speed"]))
        if half.slope is not None:
            slope = powers.get("mu_slope", {})
            yield Term("damping", half.slope, Coefficient.of(pressed | slope))


def sliding_parameters(halves: Iterable[SlidingDamping]) -> Iterator[Parameter]:
    """Parameters of contacts that slide; what is zero everywhere is none."""
    for path, size in _sizes(halves).items():
        unit, may = _KINDS[path.split(".")[-1]]
        if size:
            yield Parameter(path, size, unit, **may)


def _sizes(halves: Iterable[SlidingDamping]) -> dict[str, float]:
    """What each parameter is relative to; 1 where the halves of a contact differ."""
    found: dict[str, set[float]] = {}
    for half in halves:
        for name, size in half.sizes.items():
            found.setdefault(f"contacts.{half.contact.pair}.sliding.{name}", set()).add(size)
    return {path: each.pop() if len(each) == 1 else 1.0 for path, each in found.items()}
