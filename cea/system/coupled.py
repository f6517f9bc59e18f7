"""Coupled matrices of bodies in frictional contact, as separate terms of a pencil.

    (lambda^2 M + lambda (C + Y) + K + K_n - K_f) x = 0

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.

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

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact, assembled, by_pair, jump_operator, powers_of
from cea.contact.formulations import Form
from cea.contact.saddle import forces_of_contacts
from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.pencil import Matrices, Pencil, Term
from cea.errors import InputError, ResultWarning
from cea.matrices import applied, destroy, diagonal_of, of_entries, product, symmetrised
from cea.motion import Motion
from cea.petsc import MPI, PETSc
from cea.system.body_terms import BodyTerms

if TYPE_CHECKING:
    from cea.system.steady_state import SteadySliding

_LARGE = 50_000
"""Unknowns from which on a bound by what lies near contacts is cheaper."""
MOST_DIGITS = 6.0
"""Number of lost digits above which the saddle form is chosen."""
_KINDS: dict[str, tuple[str, float, dict[str, Any]]] = {
    "speed": ("m/s", -1.0, {"positive": True}),
    "mu_slope": ("s/m", 1.0, {"signed": True}),
    "pressure": ("N/m^2", 1.0, {}),
}
"""Unit of each sliding parameter, its exponent in the damping, and its allowed values."""


@dataclass(frozen=True)
class CoupledSystem:
    """Matrices of all bodies and contacts."""

    bodies: Mapping[str, Body]  # bodies by name, in the order of the unknowns
    # contacts with their operators, the half passes one after another
    contacts: tuple[Contact, ...]
    template: Any  # PETSc vector of the layout of the unknowns
    load: Any | None  # forces (N), PETSc vector, or None if not requested
    # terms of the pencil from each body, with its damping and rotation
    pieces: Mapping[str, BodyTerms]
    with_mass: bool  # whether the pencil has mass and damping
    # steady sliding state of the linearisation, or None
    steady: "SteadySliding | None" = None
    # geometric stiffness of the stresses of that state, and stiffness of pressures that turn with
    # their surfaces; empty if not requested
    prestress: tuple[Term, ...] = ()

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.template.getSize())

    @property
    def softens(self) -> bool:
        """Whether any body has convective stiffness, which reduces its stiffness."""
        rotations = (each.motion.rotation for each in self.pieces.values())
        return any(each is not None and each.convective_stiffness for each in rotations)

    def warnings_at(self, values: Mapping[str, float]) -> tuple[ResultWarning, ...]:
        """Return a warning for each contact whose penalty form loses too many digits."""
        digits = penalty_digits(self.bodies, self.contacts, values)
        costly = {c.pair: digits[c.pair] for c in self.contacts if not c.has_multipliers}
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

    def keeps_form(self, contact: str, values: Mapping[str, float]) -> bool:
        """Return whether a contact would have the same form for other parameter values."""
        halves = by_pair(self.contacts)[contact]
        form = form_for(penalty_digits(self.bodies, halves, values)[contact])
        return all(half.lumped is not None or half.form == form for half in halves)

    def vector(self) -> Any:
        """Return a new zero PETSc vector of unknowns."""
        vector = self.template.duplicate()
        vector.set(0.0)
        return vector

    def pencil(self, *, eliminate: bool = False) -> Pencil:
        """Return the parametric pencil of the system.

        Its parameters are ``bodies.<name>.material.E`` and ``.rho``, and for each contact
        ``contacts.<name>.P``, the integral of p (N/m), and ``contacts.<name>.mu``, a factor if mu
        varies. There is no mu if friction was left out, and no P if p is the slope of a law in a
        steady sliding state, which stays fixed. Damping, rotation and sliding add further
        parameters.

        Parameters
        ----------
        eliminate
            Whether to eliminate all contact forces; requires that no contact is tied.
        """
        pieces = [piece for each in self.pieces.values() for piece in each.pieces]
        terms = [piece for piece in pieces if isinstance(piece, Term)]
        terms += self.prestress
        terms += self._contact_terms(eliminate=eliminate)
        parameters = [one for each in self.pieces.values() for one in each.parameters()]
        parameters += self._contact_parameters()
        stiffness = stiffness_diagonal(self.bodies, {})
        return Pencil(
            terms,
            parameters,
            list(forces_of_contacts(() if eliminate else self.contacts, stiffness)),
            [term for each in self.pieces.values() for term in each.modal],
            [piece for piece in pieces if not isinstance(piece, Term)],
            None if self.size < _LARGE or self.prestress or self.softens else self._near_contacts,
        )

    def _contact_terms(self, *, eliminate: bool) -> Iterator[Term]:
        """Yield K_n and K_f of half passes in penalty form, or of all, and damping of sliding."""
        for name, halves in by_pair(self.contacts).items():
            P, mu = powers_of(halves)
            for half in halves:
                if half.has_multipliers and not eliminate:
                    continue
                yield Term("stiffness", half.K_n, Coefficient(P), contact=True)
                if half.K_f is not None:
                    both = Coefficient(P | mu, factor=-1.0)
                    yield Term("stiffness", half.K_f, both, symmetric=False, contact=True)
            references = _references(halves) if self.with_mass else {}
            for half in halves if references else ():
                for kind, matrix in _damping(self.bodies, half, 1 / len(halves)):
                    powers = {
                        f"contacts.{name}.sliding.{each}": (references[each], _KINDS[each][1])
                        for each in ("pressure", kind)
                        if references.get(each)
                    }
                    powers |= mu if kind == "speed" else {}
                    yield Term("damping", matrix, Coefficient(powers))

    def _contact_parameters(self) -> Iterator[Parameter]:
        """Yield the parameters P and mu of each contact, and those of sliding that are not zero."""
        pairs, of_friction = by_pair(self.contacts), []
        for halves in pairs.values():
            finite = all(half.form != "saddle" for half in halves)
            acts = any(half.has_friction for half in halves)
            stiffness, friction = powers_of(halves)
            for name, (P, _) in stiffness.items():
                yield Parameter(name, P, "N/m", positive=True, finite=finite)
            for name, (mu, _) in friction.items() if halves[0].slip is not None else ():
                of_friction.append(Parameter(name, mu if acts else 0.0))
        yield from of_friction
        for contact, halves in pairs.items() if self.with_mass else ():
            for kind, reference in _references(halves).items():
                unit, _, may = _KINDS[kind]
                if reference:
                    yield Parameter(f"contacts.{contact}.sliding.{kind}", reference, unit, **may)

    def _near_contacts(self, values: Mapping[str, float], whole: Matrices) -> Matrices | None:
        from cea.system.near_contacts import near_contacts  # imported only for large systems

        return near_contacts(self.pieces, self.contacts, values, whole)

    def linearised(
        self, steady: "SteadySliding", *, geometric_stiffness: bool = False
    ) -> "CoupledSystem":
        """Return the system of small motions about a steady sliding state."""
        contacts = []
        for contact in self.contacts:
            state = steady.contacts.get(contact.name)
            contacts.append(contact if state is None else replace(contact, closure=state.closure))
        prestress = []
        for name, body in self.bodies.items() if geometric_stiffness else ():
            stresses = body.geometric_stiffness(self.displacement(steady.displacement, name))
            for matrix, symmetric in [(stresses, True), *body.load_stiffness()]:
                placed = self.pieces[name].placed(matrix)
                prestress.append(Term("stiffness", placed, symmetric=symmetric))
                if placed is not matrix:
                    destroy(matrix)
        formed = with_forms(self.bodies, contacts)
        return replace(self, contacts=formed, steady=steady, prestress=tuple(prestress))

    def displacement(self, x: Any, body: str) -> Floats:
        """Return the full displacement (m) of a body, prescribed parts included, (dim * dofs,)."""
        own = self.bodies[body]
        full = applied(own.expansion, x.array_r[self.pieces[body].rows])
        if own.prescribed is not None:
            full += own.prescribed
        return np.concatenate(own.comm.allgather(full))


def couple(
    bodies: Mapping[str, Body],
    contacts: Sequence[Contact],
    *,
    with_mass: bool = True,
    with_load: bool = False,
    leave_out: bool = True,
    motions: Mapping[str, Motion] | None = None,
) -> CoupledSystem:
    """Assemble the coupled matrices of bodies and contacts, given as half passes.

    ``leave_out`` omits slip operators and K_f where mu = 0. ``motions`` are damping and rotation by
    body; without mass only their terms for displacements at rest in space remain.
    """
    PETSc.garbage_cleanup()  # frees objects of earlier systems, which is collective
    sizes = tuple(body.expansion.getSizes()[1] for body in bodies.values())
    template = PETSc.Vec().create(next(iter(bodies.values())).expansion.comm)
    template.setSizes((sum(local for local, _ in sizes), PETSc.DETERMINE))
    template.setUp()
    frictional = {contact.pair for contact in contacts if contact.has_friction}
    made = [
        assembled(bodies, contact, frictional=contact.pair in frictional, leave_out=leave_out)
        for contact in contacts
    ]
    pieces = {}
    for number, (name, body) in enumerate(bodies.items()):
        motion = (motions or {}).get(name, Motion())
        pieces[name] = BodyTerms(name, body, motion, with_mass, sizes, number)
    return CoupledSystem(
        bodies=bodies,
        contacts=with_forms(bodies, made),
        template=template,
        load=_load(bodies, made, template) if with_load else None,
        pieces=pieces,
        with_mass=with_mass,
    )


def _load(bodies: Mapping[str, Body], contacts: Iterable[Contact], template: Any) -> Any:
    """Return the forces (N) of loads and prescribed displacements, PETSc vector."""
    load = template.duplicate()
    load.array[:] = np.concatenate([body.load().array_r for body in bodies.values()])
    for contact in contacts:
        if contact.prescribed is None or not contact.law.linear:
            continue
        if contact.coupling != "pointwise" or not contact.has_pressure:
            allowed = (
                "pointwise and of finite stiffness if a support prescribes a displacement of a "
                "side; or a law with c_n"
            )
            raise InputError(f"contacts.{contact.pair}.formulation", contact.coupling, allowed)
        load.array[:] -= contact.force(contact.slope * contact.prescribed)
    return load


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
