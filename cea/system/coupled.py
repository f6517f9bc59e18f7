"""Coupled matrices of bodies in frictional contact, kept apart until a solver sums them.

    (lambda^2 M + lambda (C + Y) + K + K_n - K_f) x = 0

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import inf, log10
from typing import TYPE_CHECKING, Any

from cea.arrays import Floats
from cea.body import Body
from cea.contact.forms import form_for, penalty_digits, penalty_warnings, with_forms
from cea.contact.operators import Contact
from cea.contact.sliding import Sliding, SlidingDamping, damping_of
from cea.eigen.parameters import Coefficient, Parameter
from cea.eigen.pencil import Pencil, Term
from cea.matrices import block_diagonal, destroy, gather, local_part
from cea.nodes import Nodes, joined, places
from cea.petsc import MPI
from cea.system.body_pieces import BodyPieces
from cea.system.contact_terms import ContactPairs
from cea.system.near_contact import PARTED_FROM, ContactPieces, near_contact
from cea.system.sliding_terms import sliding_parameters, sliding_terms
from cea.warned import ResultWarning

if TYPE_CHECKING:
    from cea.system.sliding_state import SteadySliding


@dataclass(frozen=True)
class CoupledSystem:
    """Matrices of all bodies and contacts.

    Parameters
    ----------
    bodies
        Bodies by name, in the order of the unknowns.
    contacts
        Contact matrices.
    template
        PETSc vector of the layout of the unknowns.
    index_sets
        Unknowns of each body, PETSc index sets by name.
    load
        Forces (N), PETSc vector, None where none were asked for.
    stiffness_diagonal
        Diagonal of K of all bodies (N/m), PETSc vector.
    penalty_digits
        Digits that the penalty form costs, or would cost, by contact.
    pieces
        Pieces of a pencil that bodies bring, with their damping and rotation.
    sliding
        How half passes slide, by name, where that damps; none in static scenes.
    steady
        The state of steady sliding that contacts were linearised about; None where none was sought.
    prestress
        Geometric stiffness of the stresses of that state by body, PETSc AIJ (N/m); empty where it
        was not asked for.
    """

    bodies: Mapping[str, Body]
    contacts: tuple[Contact, ...]
    template: Any
    index_sets: Mapping[str, Any]
    load: Any | None
    stiffness_diagonal: Any
    penalty_digits: Mapping[str, float]
    pieces: BodyPieces
    sliding: Mapping[str, Sliding]
    steady: "SteadySliding | None" = None
    prestress: Mapping[str, Any] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.template.getSize())

    @cached_property
    def stiffness(self) -> Any:
        """K of all bodies, PETSc AIJ (N/m)."""
        return self._diagonal(lambda body: body.stiffness())

    @cached_property
    def mass(self) -> Any | None:
        """M of all bodies, PETSc AIJ (kg), None in static scenes."""
        return self._diagonal(lambda body: body.mass()) if self.pieces.with_mass else None

    def _diagonal(self, matrix_of: Callable[[Body], Any]) -> Any:
        return block_diagonal([matrix_of(body) for body in self.bodies.values()]).convert("aij")

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """What the forms of its contacts cost: kind ``penalty-rounding``."""
        return self.warnings_at({})

    def warnings_at(self, values: Mapping[str, float]) -> tuple[ResultWarning, ...]:
        """The same where some parameters of the pencil have other values."""
        digits = {name: self._digits_at(name, values) for name in self.penalty_digits}
        return penalty_warnings(self.contacts, digits)

    def keeps_forms(self, contacts: Iterable[str], values: Mapping[str, float]) -> bool:
        """Whether contacts would take the forms they have if some parameters had other values."""
        return all(
            half.lumped is not None or form_for(self._digits_at(name, values)) == half.half.form
            for name in contacts
            for half in self._pairs.halves(name)
        )

    def _digits_at(self, contact: str, values: Mapping[str, float]) -> float:
        """Digits that the penalty form costs at other P and E; infinite where it is not known."""
        before, halves = self._pairs.stiffnesses()[contact], self._pairs.halves(contact)
        P = values.get(f"contacts.{contact}.P", before)
        if inf in (P, before):
            return inf
        if halves[0].projection is not None and halves[0].half.law.linear:
            return 0.0
        digits = self.penalty_digits
        if any(_modulus(body) in values for body in (halves[0].half.a, halves[0].half.b)):
            diagonal = self._stiffness_diagonal_at(values)
            digits = penalty_digits(halves, diagonal)
            destroy(diagonal)
        return digits[contact] + log10(P / before)

    def _stiffness_diagonal_at(self, values: Mapping[str, float]) -> Any:
        """Diagonal of K of all bodies at other E (N/m), PETSc vector; springs stay as they are."""
        diagonal = self.stiffness_diagonal.copy()
        for name, body in self.bodies.items():
            factor = values.get(_modulus(name), body.material.E) / body.material.E
            part = diagonal.getSubVector(self.index_sets[name])
            part.scale(factor)
            if (springs := body.spring_stiffness()) is not None:
                own = springs.getDiagonal()
                part.axpy(1.0 - factor, own)
                destroy(own)
            diagonal.restoreSubVector(self.index_sets[name], part)
        return diagonal

    @cached_property
    def _pairs(self) -> ContactPairs:
        """Its contacts, both halves of a full pass together."""
        return ContactPairs(self.contacts)

    def vector(self) -> Any:
        """A new PETSc vector of unknowns, all zero."""
        vector = self.template.duplicate()
        vector.set(0.0)
        return vector

    def pencil(
        self, *, leave_out: bool = True, eliminate: bool = False, parted_from: int = PARTED_FROM
    ) -> Pencil:
        """The parametric pencil of the system, whose matrices are its pieces.

        Its parameters are ``bodies.<name>.material.E`` and ``.rho``, and of each contact
        ``contacts.<name>.P``, the integral of p (N/m), and ``contacts.<name>.mu``, a factor on it
        where it varies. Without friction, if that was left out, there is no mu. Where p is the
        slope of a law in a state of steady sliding there is no P, and the state stays what it is
        whatever the parameters. Damping, rotation and sliding add theirs
        (:mod:`cea.system.body_terms`, :mod:`cea.system.sliding_terms`).

        Parameters
        ----------
        leave_out
            Whether friction that is zero is left out of what is solved.
        eliminate
            Whether all contact forces are eliminated, where gaps are projected into matrices that
            are full on the interface; no contact is tied.
        parted_from
            Unknowns from which on what lies near the contacts is told apart.
        """
        keeping = [c for c in self.contacts if c.keeps_forces and not eliminate]
        contacts = ContactPieces(
            tuple(self._pairs.terms(keeping)),
            tuple(self._pairs.forces(keeping, self.stiffness_diagonal)),
        )
        stressed = [
            Term("stiffness", self.pieces.square(name, matrix), Coefficient.of({}))
            for name, matrix in self.prestress.items()
        ]
        return Pencil(
            [*self.pieces.terms, *stressed, *contacts.terms, *self._sliding_terms()],
            self._parameters(),
            contacts.forces,
            self.pieces.modal_terms,
            self.pieces.circulatory,
            leave_out=leave_out,
            nodes=self._nodes,
            near_contact=partial(
                self._near_contact, contacts, leave_out=leave_out, parted_from=parted_from
            ),
        )

    def _near_contact(
        self, contacts: ContactPieces, *, leave_out: bool, parted_from: int
    ) -> Pencil | None:
        """Pencil of what lies near the contacts, where bodies have mass and are but elastic."""
        if not self.pieces.with_mass or self.prestress or self.pieces.rotates:
            return None
        return near_contact(
            self.bodies,
            contacts,
            self._parameters(),
            self.template,
            self.pieces.square,
            leave_out=leave_out,
            parted_from=parted_from,
        )

    def linearised(
        self, steady: "SteadySliding", *, geometric_stiffness: bool = False
    ) -> "CoupledSystem":
        """The system of small motions about a state of steady sliding.

        Parameters
        ----------
        steady
            The state.
        geometric_stiffness
            Whether its stresses stiffen, or soften, the bodies; the forces of contacts and loads
            keep their directions.
        """
        contacts = [
            replace(
                contact,
                half=replace(contact.half, penetration=steady.contacts[contact.name].closure),
            )
            if contact.name in steady.contacts
            else contact
            for contact in self.contacts
        ]
        digits = penalty_digits(contacts, self.stiffness_diagonal)
        prestress = {}
        if geometric_stiffness:
            prestress = {
                name: body.geometric_stiffness(self.displacement(steady.displacement, name))
                for name, body in self.bodies.items()
            }
        return replace(
            self,
            contacts=with_forms(contacts, digits),
            penalty_digits=digits,
            steady=steady,
            prestress=prestress,
        )

    @cached_property
    def _nodes(self) -> Nodes | None:
        """Unknowns by basis function; None where supports leave that open on any rank."""
        found, functions = [], []
        dim = next(iter(self.bodies.values())).dim
        for body in self.bodies.values():
            rows = local_part(body.expansion)
            found.append(places(rows, range(*body.expansion.getOwnershipRangeColumn())))
            functions.append(rows.shape[0] // dim)
        known = [each for each in found if each is not None]
        every = self.template.comm.tompi4py().allreduce(len(known) == len(found), MPI.LAND)
        return joined(known, functions, dim) if every else None

    def _sliding_terms(self) -> Iterator[Term]:
        """Damping of contacts that slide."""
        halves = [
            half if self._pairs.rubs(half.contact) else replace(half, turning=None)
            for half in self._sliding_damping
        ]
        return sliding_terms(halves, self._pairs.references())

    @cached_property
    def _sliding_damping(self) -> tuple[SlidingDamping, ...]:
        """Damping of the half passes that slide, at their pressures in the state of sliding."""
        return damping_of(self.bodies, self.contacts, self.sliding)

    def _parameters(self) -> Iterator[Parameter]:
        yield from self.pieces.parameters()
        yield from self._pairs.parameters()
        yield from sliding_parameters(self._sliding_damping)

    def displacement(self, x: Any, body: str, *, everywhere: bool = True) -> Floats:
        """Full displacement (m) of one body under loads, shape (dim * num_scalar_dofs,).

        With what its supports prescribe.

        Parameters
        ----------
        x
            Unknowns, PETSc vector.
        body
            Name of the body.
        everywhere
            Whether every rank gets it; otherwise rank 0 does, and others get an empty array.
        """
        part = x.getSubVector(self.index_sets[body])
        full = self.bodies[body].expansion.createVecLeft()
        self.bodies[body].expansion.mult(part, full)
        x.restoreSubVector(self.index_sets[body], part)
        if (prescribed := self.bodies[body].prescribed) is not None:
            full.axpy(1.0, prescribed)
        displacement = gather(full, everywhere=everywhere)
        destroy(full)
        return displacement


def _modulus(body: str) -> str:
    """Parameter that is E of a body."""
    return f"bodies.{body}.material.E"
