"""Terms of the pencil from contacts: the form of each, its matrices and parameters.

Adding K_n to K loses the digits by which K_n is larger: the rounding error is eps times the larger
matrix. The saddle form, and projected gaps, add nothing to K.

At a sliding speed friction adds damping of either sign.

The friction traction on side a is mu(v) sigma k, with the contact pressure sigma, the speed v of
steady sliding and k opposite to the velocity of a relative to b. A small velocity changes speed and
direction of sliding. With T_k and T_t, which map dofs to slips along k and along the tangent
t = n x k normal to it (in 3D only), the force - C dx/dt on the bodies has

    C = T_t^T diag(w mu sigma / v) T_t  +  T_k^T diag(w sigma mu'(v)) T_k

The first part, due to the turning direction, always damps; the second adds energy where friction
decreases with speed, mu' < 0 (Herve, Sinou, Mahe and Jezequel, European Journal of Mechanics
A/Solids 27, 2008, 141-160).

With the path of the contact in a scene, ``contacts.<name>``, the parameters are
``.sliding.speed``, ``.sliding.mu_slope`` and ``.sliding.pressure``, or factors if they vary.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, log10
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact, by_pair, jump_operator, powers_of
from cea.contact.formulations import Form
from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.pencil import Term
from cea.errors import ResultWarning
from cea.matrices import applied, destroy, diagonal_of, of_entries, product, symmetrised
from cea.petsc import MPI, PETSc

MOST_DIGITS = 6.0
"""Number of lost digits above which the saddle form is chosen."""
_KINDS: dict[str, tuple[str, float, dict[str, Any]]] = {
    "speed": ("m/s", -1.0, {"positive": True}),
    "mu_slope": ("s/m", 1.0, {"signed": True}),
    "pressure": ("N/m^2", 1.0, {}),
}
"""Unit of each sliding parameter, its exponent in the damping, and its allowed values."""


def contact_terms(
    bodies: Mapping[str, Body], contacts: Sequence[Contact], *, eliminate: bool, with_mass: bool
) -> Iterator[Term]:
    """Yield K_n and K_f of half passes in penalty form, or of all if ``eliminate``, and damping.

    The damping of sliding half passes belongs to pencils with mass.
    """
    for name, halves in by_pair(contacts).items():
        P, mu = powers_of(halves)
        for half in halves:
            if half.has_multipliers and not eliminate:
                continue
            yield Term("stiffness", half.K_n, Coefficient(P), contact=True)
            if half.K_f is not None:
                both = Coefficient(P | mu, factor=-1.0)
                yield Term("stiffness", half.K_f, both, symmetric=False, contact=True)
        references = _references(halves) if with_mass else {}
        for half in halves if references else ():
            for kind, matrix in _damping(bodies, half, 1 / len(halves)):
                powers = {
                    f"contacts.{name}.sliding.{each}": (references[each], _KINDS[each][1])
                    for each in ("pressure", kind)
                    if references.get(each)
                }
                powers |= mu if kind == "speed" else {}
                yield Term("damping", matrix, Coefficient(powers))


def contact_parameters(contacts: Sequence[Contact], *, with_mass: bool) -> Iterator[Parameter]:
    """Yield the parameters P and mu of each contact, and those of sliding that are not zero."""
    of_friction = []
    pairs = by_pair(contacts)
    for halves in pairs.values():
        finite = all(half.form != "saddle" for half in halves)
        acts = any(half.has_friction for half in halves)
        stiffness, friction = powers_of(halves)
        for name, (P, _) in stiffness.items():
            yield Parameter(name, P, "N/m", positive=True, finite=finite)
        for name, (mu, _) in friction.items() if halves[0].slip is not None else ():
            of_friction.append(Parameter(name, mu if acts else 0.0))
    yield from of_friction
    for contact, halves in pairs.items() if with_mass else ():
        for kind, reference in _references(halves).items():
            unit, _, may = _KINDS[kind]
            if reference:
                yield Parameter(f"contacts.{contact}.sliding.{kind}", reference, unit, **may)


def penalty_digits(
    bodies: Mapping[str, Body], contacts: Sequence[Contact], values: Mapping[str, float]
) -> dict[str, float]:
    """Return the digits that the penalty form loses, by contact, at given values of P and E.

    They are log10 of the largest ratio of diagonal entries of K_n and K; zero for projected gaps,
    infinite for tied sides.
    """
    stiffness, digits = stiffness_diagonal(bodies, values), {}
    for name, halves in by_pair(contacts).items():
        own = sum(half.P for half in halves)
        changed = values.get(f"contacts.{name}.P")
        factor = 1.0 if changed is None else changed / own
        if halves[0].tied or factor == inf:
            digits[name] = inf
        else:
            ratio = factor * max(_stiffness_ratio(half, stiffness) for half in halves)
            digits[name] = max(0.0, log10(ratio))
    return digits


def _stiffness_ratio(contact: Contact, stiffness: Floats) -> float:
    """Return the largest ratio of the diagonals of K_n and K; tiny if K_n is not added."""
    least = float(np.finfo(float).tiny)
    if contact.awaits_state or (contact.is_projected and contact.law.linear):
        return least
    if contact.penalty_only:
        own = diagonal_of(contact.K_n)
    else:
        squares = of_entries(np.square, contact.gap)
        own = applied(squares, contact.weight(contact.slope), transposed=True)
        destroy(squares)
    return contact.interface.comm.allreduce((own / stiffness).max(initial=least), MPI.MAX)


def stiffness_diagonal(bodies: Mapping[str, Body], values: Mapping[str, float]) -> Floats:
    """Return the diagonal of K of all bodies (N/m), this rank's rows; E does not scale springs."""
    parts = []
    for name, body in bodies.items():
        E = body.material.means[0]
        factor = values.get(f"bodies.{name}.material.E", E) / E
        parts.append(factor * diagonal_of(body.elastic_stiffness()))
        if (springs := body.spring_stiffness()) is not None:
            parts[-1] += diagonal_of(springs)
    return np.concatenate(parts)


def form_for(digits: float) -> Form:
    """Return the default form of a contact for the digits that a penalty would lose."""
    return "saddle" if digits > MOST_DIGITS else "penalty"


def with_forms(bodies: Mapping[str, Body], contacts: Sequence[Contact]) -> tuple[Contact, ...]:
    """Return contacts with their forms chosen.

    Lumped contact is always in penalty form. The form stays open if the stiffness depends on a
    steady sliding state that is not yet known.
    """
    digits, chosen = penalty_digits(bodies, contacts, {}), []
    for contact in contacts:
        if contact.form is None and not contact.awaits_state:
            form = "penalty" if contact.penalty_only else form_for(digits[contact.pair])
            contact = replace(contact, form=form)
        chosen.append(contact)
    return tuple(chosen)


def penalty_warnings(
    bodies: Mapping[str, Body], contacts: Sequence[Contact], values: Mapping[str, float]
) -> tuple[ResultWarning, ...]:
    """Return a warning for each contact whose penalty form loses too many digits."""
    digits = penalty_digits(bodies, contacts, values)
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


def _references(halves: Sequence[Contact]) -> dict[str, float]:
    """Return the reference value of each sliding field; 1 if it varies or the halves differ."""
    references = {}
    for name in _KINDS:
        some = [half.sliding for half in halves if name != "speed" or half.slip is not None]
        given = [each for sliding in some if (each := getattr(sliding, name, None)) is not None]
        if given:
            values = np.concatenate(given)
            references[name] = 1.0 if np.ptp(values) else float(values[0])
    return references


def _damping(
    bodies: Mapping[str, Body], contact: Contact, share: float
) -> Iterator[tuple[str, Any]]:
    """Yield C of the turning direction ("speed") and of mu' ("mu_slope"), PETSc AIJ (N s/m)."""
    sliding, interface = contact.sliding, contact.interface
    assert sliding is not None
    points, rows, k = interface.local_points, interface.rows, contact.friction_direction()
    if sliding.pressure is not None:
        pressure = share * sliding.pressure
    else:
        assert contact.closure is not None
        pressure = np.maximum(contact.law.pressure(contact.closure), 0.0)
    load = points.weight * pressure[rows]

    def damping(direction: Floats, values: Floats) -> Any:
        slip = jump_operator(bodies, contact, direction)
        matrix = symmetrised(product(slip, slip, values))
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        destroy(slip)
        return matrix

    if sliding.speed is not None and contact.slip is not None:
        across = np.cross(points.normal, k)
        yield "speed", damping(across, load * contact.mu_at_points / sliding.speed[rows])
    if sliding.mu_slope is not None:
        yield "mu_slope", damping(k, load * sliding.mu_slope[rows])
