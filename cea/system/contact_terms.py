"""What contacts bring to a pencil: the form each takes, pieces and parameters, halves together.

K_n added to K costs the digits by which it is larger: rounding of the sum, eps times the larger,
stands beside the smaller. In the saddle form, and where gaps are projected, nothing is added.

What friction at a sliding speed makes of small velocities: damping, of either sign.

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
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact, jump_operator
from cea.contact.formulations import Form
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import Term
from cea.errors import ResultWarning
from cea.matrices import destroy, product, squared, symmetrised
from cea.petsc import PETSc

MOST_DIGITS = 6.0
"""Digits that the penalty form may cost."""
_KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "speed": ("m/s", {"positive": True}),
    "mu_slope": ("s/m", {"signed": True}),
    "pressure": ("N/m^2", {}),
}
"""Unit of each parameter, and what it may be."""


def by_pair(contacts: Sequence[Contact]) -> dict[str, list[Contact]]:
    """Half passes by the name of the contact they belong to."""
    pairs: dict[str, list[Contact]] = {}
    for contact in contacts:
        pairs.setdefault(contact.pair, []).append(contact)
    return pairs


def stiffnesses(contacts: Sequence[Contact]) -> dict[str, float]:
    """P of each contact, both halves of a full pass together."""
    return {name: sum(half.P for half in halves) for name, halves in by_pair(contacts).items()}


def friction_references(contacts: Sequence[Contact]) -> dict[str, float]:
    """What mu of each contact is relative to; 1 where its halves do not have the same."""
    references = {}
    for name, halves in by_pair(contacts).items():
        if halves[0].slip is not None:
            values = {half.mu for half in halves}
            references[name] = values.pop() if len(values) == 1 else 1.0
    return references


def contact_terms(
    contacts: Sequence[Contact], among: Sequence[Contact], friction: dict[str, float]
) -> Iterator[Term]:
    """K_n and K_f of some of the half passes, whose forces are eliminated."""
    total = stiffnesses(contacts)
    for contact in among:
        path = f"contacts.{contact.pair}"
        P = {f"{path}.P": (total[contact.pair], 1.0)} if contact.law.linear else {}
        yield Term("stiffness", contact.K_n, Coefficient.of(P), contact=True)
        if contact.K_f is not None:
            mu = {f"{path}.mu": (friction[contact.pair], 1.0)}
            coefficient = Coefficient.of(P | mu, factor=-1.0)
            yield Term("stiffness", contact.K_f, coefficient, symmetric=False, contact=True)


def contact_parameters(
    contacts: Sequence[Contact], friction: dict[str, float]
) -> Iterator[Parameter]:
    """P and mu of each contact, where they are parameters."""
    pairs = by_pair(contacts)
    for name, P in stiffnesses(contacts).items():
        if all(half.law.linear for half in pairs[name]):
            finite = all(half.form != "saddle" for half in pairs[name])
            yield Parameter(f"contacts.{name}.P", P, "N/m", positive=True, finite=finite)
    for name, reference in friction.items():
        acts = any(half.has_friction for half in pairs[name])
        yield Parameter(f"contacts.{name}.mu", reference if acts else 0.0)


def penalty_digits(contacts: Sequence[Contact], stiffness: Any) -> dict[str, float]:
    """Digits that the penalty form costs, by contact; none where gaps are projected.

    log10 of the largest diagonal entry of K_n relative to that of K; infinite where sides are tied.
    """
    digits: dict[str, float] = {}
    for contact in contacts:
        if contact.tied:
            lost = inf
        elif contact.awaits_state or (contact.is_projected and contact.law.linear):
            lost = 0.0
        else:
            lost = _lost(contact, stiffness)
        digits[contact.pair] = max(lost, digits.get(contact.pair, 0.0))
    return digits


def _lost(contact: Contact, stiffness: Any) -> float:
    if contact.penalty_only:
        own = contact.K_n.getDiagonal()
    else:
        weight, own = contact.weight(contact.slope), stiffness.duplicate()
        squares = squared(contact.gap)
        squares.multTranspose(weight, own)
        destroy(weight, squares)
    own.pointwiseDivide(own, stiffness)
    ratio = own.max()[1]
    destroy(own)
    return float(np.log10(max(ratio, np.finfo(float).tiny)))


def form_for(digits: float) -> Form:
    """The form that a contact takes where it is left open, by the digits a penalty would cost."""
    return "saddle" if digits > MOST_DIGITS else "penalty"


def with_forms(contacts: Sequence[Contact], digits: Mapping[str, float]) -> tuple[Contact, ...]:
    """Contacts whose forms are all chosen; lumped ones have no other than the penalty.

    Where the stiffness is not known before a state of steady sliding is, the form stays open.
    """

    def chosen(contact: Contact) -> Contact:
        if contact.form is not None or contact.awaits_state:
            return contact
        form = "penalty" if contact.penalty_only else form_for(digits[contact.pair])
        return replace(contact, form=form)

    return tuple(chosen(contact) for contact in contacts)


def penalty_warnings(
    contacts: Sequence[Contact], digits: Mapping[str, float]
) -> tuple[ResultWarning, ...]:
    """Where the penalty form costs too much, a warning for each contact."""
    costly = {c.pair: digits[c.pair] for c in contacts if not c.has_multipliers}
    return tuple(
        ResultWarning(
            "penalty-rounding",
            f"contact {name} is {10**lost:.1g} times as stiff as its bodies: the penalty form "
            f"loses {lost:.1f} digits to rounding",
            {"contact": name, "digits": lost},
        )
        for name, lost in costly.items()
        if lost > MOST_DIGITS
    )


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
    points, rows = interface.local_points, interface.rows
    load = points.weight * _pressure(contact, share)[rows]
    k = contact.friction_direction()

    def damping(direction: Floats, values: Floats) -> Any:
        slip = jump_operator(bodies, contact, direction)
        weight = slip.createVecLeft()
        weight.array[:] = values
        matrix = symmetrised(product(slip, slip, weight))
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
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
    assert contact.closure is not None
    return np.maximum(contact.law.pressure(contact.closure), 0.0)
