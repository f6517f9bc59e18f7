"""What friction at a sliding speed makes of small velocities: damping, of either sign.

The traction of friction on side a is mu(v) sigma k, with the contact pressure sigma, the speed v of
steady sliding and k against the velocity of a relative to b. A small velocity changes speed and
direction of sliding, and with T_k and T_t, which take dofs to slips along k and along the tangent
t = n x k across it (in space only), the force - C dx/dt on the bodies has

    C = T_t^T diag(w mu sigma / v) T_t  +  T_k^T diag(w sigma mu'(v)) T_k

The first part, of the turning direction, always damps; the second one feeds energy in where
friction falls with the speed, mu' < 0 (Herve, Sinou, Mahe and Jezequel, European Journal of
Mechanics A/Solids 27, 2008, 141-160).

By the path of the contact in a scene, ``contacts.<name>``, the parameters of these pieces are
``.sliding.speed``, ``.sliding.mu_slope`` and ``.sliding.pressure``, factors where they vary.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact, jump_operator
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import Term
from cea.errors import InputError
from cea.matrices import destroy, product, symmetric_product, symmetrised
from cea.petsc import PETSc

_KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "speed": ("m/s", {"positive": True}),
    "mu_slope": ("s/m", {"signed": True}),
    "pressure": ("N/m^2", {}),
}
"""Unit of each parameter, and what it may be."""


def sliding_terms(
    bodies: Mapping[str, Body], contacts: Sequence[Contact], friction: Mapping[str, float]
) -> Iterator[Term]:
    """Damping of the half passes that slide; the halves of a full pass share the pressure."""
    sizes, pairs = _sizes(contacts), [contact.pair for contact in contacts]
    for contact in contacts:
        if contact.sliding is None:
            continue
        path = f"contacts.{contact.pair}"
        powers = {
            name: {f"{path}.sliding.{name}": (sizes[f"{path}.sliding.{name}"], exponent)}
            for name, exponent in (("speed", -1.0), ("mu_slope", 1.0), ("pressure", 1.0))
            if sizes.get(f"{path}.sliding.{name}")
        }
        pressed = powers.get("pressure", {})
        for kind, matrix in _damping(bodies, contact, 1 / pairs.count(contact.pair)):
            if kind == "speed":
                mu = {f"{path}.mu": (friction[contact.pair], 1.0)}
                coefficient = Coefficient.of(pressed | mu | powers["speed"])
            else:
                coefficient = Coefficient.of(pressed | powers.get("mu_slope", {}))
            yield Term("damping", matrix, coefficient)


def sliding_parameters(contacts: Sequence[Contact]) -> Iterator[Parameter]:
    """Parameters of contacts that slide; what is zero everywhere is none."""
    for path, size in _sizes(contacts).items():
        unit, may = _KINDS[path.split(".")[-1]]
        if size:
            yield Parameter(path, size, unit, **may)


def _sizes(contacts: Sequence[Contact]) -> dict[str, float]:
    """What each parameter is relative to; 1 where it varies or the halves of a contact differ."""
    found: dict[str, set[float]] = {}
    for contact in contacts:
        for name in _KINDS:
            values = getattr(contact.sliding, name, None)
            if values is None or (name == "speed" and contact.slip is None):
                continue
            size = float(values[0]) if len(values) and np.ptp(values) == 0 else 1.0
            found.setdefault(f"contacts.{contact.pair}.sliding.{name}", set()).add(size)
    return {path: each.pop() if len(each) == 1 else 1.0 for path, each in found.items()}


def _damping(
    bodies: Mapping[str, Body], contact: Contact, share: float
) -> Iterator[tuple[str, Any]]:
    """C of the turning direction, kind "speed", and of the slope of friction, PETSc AIJ (N s/m)."""
    sliding, interface = contact.sliding, contact.interface
    assert sliding is not None
    if contact.coupling == "bonded" or contact.friction is None:
        raise InputError("sliding", contact.coupling, "left out where nothing slides")
    if sliding.speed is not None and interface.a.dim < 3:
        allowed = "left out in the plane, where the direction of sliding cannot turn"
        raise InputError("sliding.speed", float(sliding.speed.flat[0]), allowed)
    points, rows = interface.local_points, interface.rows
    load = points.weight * _pressure(contact, share)[rows]
    k = contact.friction_direction()

    def damping(direction: Floats, values: Floats) -> Any:
        slip = jump_operator(bodies, contact, direction)
        weight = slip.createVecLeft()
        weight.array[:] = values
        matrix = _weighted(slip, weight)
        destroy(slip, weight)
        return matrix

    if sliding.speed is not None and contact.slip is not None:
        across = np.cross(points.normal, k)
        yield "speed", damping(across, load * contact.mu_at_points / sliding.speed[rows])
    if sliding.mu_slope is not None:
        yield "mu_slope", damping(k, load * sliding.mu_slope[rows])


def _pressure(contact: Contact, share: float) -> Floats:
    """Contact pressure at all points (N/m^2): a share of one that is given."""
    sliding = contact.sliding
    if sliding is not None and sliding.pressure is not None:
        return share * sliding.pressure
    if contact.closure is None:
        allowed = "needed where no state of steady sliding tells it (N/m^2)"
        raise InputError("sliding.pressure", None, allowed)
    return np.maximum(contact.law.pressure(contact.closure), 0.0)


def _weighted(slip: Any, weight: Any) -> Any:
    """T^T diag(w) T, symmetric to the last bit, for weights of any sign."""
    smallest = weight.min()[1]
    if smallest >= 0:
        return symmetric_product(slip, weight)
    matrix = symmetrised(product(slip, slip, weight))
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix
