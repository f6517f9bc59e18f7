"""The reduced model: every piece of a pencil projected on a basis, and what its residuals need.

With a real basis V of states at some parameters, right and left eigenvectors with the contact
forces of both (Galerkin: all are tested with the same space, so that errors of eigenvalues are
products of residuals),

    K_r(t) = sum_j c_j(t) V^T K_j V,    M_r(t) = sum_j c_j(t) V^T M_j V,

and D of damping and rotation alike. A residual (K(t) - kappa M(t)) V y is a sum of the same kind of
A_j V y. With an orthonormal basis Q of what all A_j V cause its norm is the length of sum_j c_j(t)
(Q^T A_j V) y: nothing of the size of the pencil is touched, and no squares are subtracted, which
would halve the digits (A. Buhr, C. Engwer, M. Ohlberger, S. Rave, A numerically stable a posteriori
error estimator for reduced basis approximations of elliptic equations, 2014).

Gaps have the forces that close them in the basis. Forces of a contact that is stiffer than its
bodies have the static displacements that they cause: with them the basis can close a gap without
bending (supremizers; G. Rozza, K. Veroy, Comput. Methods Appl. Mech. Engrg. 196 (2007)). A softer
contact opens in the full solves themselves, and needs none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import ResultWarning
from cea.reduced.basis import InnerProduct, Norms, Span
from cea.reduced.certificate import Term
from cea.reduced.pieces import ContactPiece, Piece, Pieces
from cea.reduced.spectrum import SmallPencil
from cea.reduced.window import Window

BASIS = 1e-6
"""Part of an eigenvector, in the energy norm, that a basis leaves out; errors go by its square."""
RESIDUAL = 1e-14
"""Part of the images of the basis that is rounding: the basis of residuals leaves it out."""
FORCES = 1e-8
"""Part of the forces of a contact that the basis of forces leaves out; errors go by its square."""


@dataclass(frozen=True)
class Snapshot:
    """Modes of a full solve with left vectors, the rows of this rank.

    As plain data its "point", whether its window was shown to be "complete" and up to which
    "max_growth" (1/s), None where to any, and "warnings". lambda, what its errors are relative to,
    errors (1/s) and condition numbers, shape (n,); eigenvectors and contact forces of both sides,
    shape (rows, n).
    """

    about: Mapping[str, Any]
    eigenvalues: Complexes
    speeds: Floats
    uncertainties: Floats
    conditions: Floats
    right: Complexes
    left: Complexes
    forces: Complexes
    left_forces: Complexes

    @classmethod
    def of(
        cls, point: Mapping[str, float], modes: Modes, warnings: Sequence[ResultWarning] = ()
    ) -> "Snapshot":
        """What a basis needs of modes that have left vectors."""
        assert modes.left is not None
        growth = float(modes.window.max_growth)
        about = {
            "point": {name: float(value) for name, value in point.items()},
            "complete": bool(modes.window.complete),
            "max_growth": growth if np.isfinite(growth) else None,
            "warnings": [warning.plain() for warning in warnings],
        }
        values = modes.eigenvalues, modes.speeds, modes.growth_uncertainties, modes.conditions
        vectors = modes.vectors, modes.left.vectors, modes.forces, modes.left.forces
        return cls(about, *values, *vectors)

    def real_vectors(self, norm: InnerProduct, *, damped: bool) -> Floats:
        """States of real and imaginary parts of all vectors, each complex one of length one.

        Of conjugate pairs of kappa one is enough; damped pencils have none. Phases are such that
        real parts are as long as can be.
        """
        one = ((-(self.eigenvalues**2)).imag >= 0) | damped
        parts = [_parts(norm, self.right[:, one])]
        if norm.comm.allreduce(not np.array_equal(self.left, self.right)):
            parts.append(_parts(norm, self.left[:, one]))
        return np.hstack(parts)

    def real_forces(self) -> Floats:
        """States of real and imaginary parts of all contact forces."""
        both = self.forces, self.left_forces
        parts = np.hstack([part for each in both for part in (each.real, each.imag)])
        return np.vstack([np.zeros((len(self.right), parts.shape[1])), parts])


def _parts(norm: InnerProduct, vectors: Complexes) -> Floats:
    square = norm.comm.allreduce(np.einsum("ij,ij->j", vectors, vectors))
    vectors = vectors * np.exp(-0.5j * np.angle(square))
    vectors = np.pad(vectors, ((0, norm.rows - len(vectors)), (0, 0)))
    real, imaginary = np.asfortranarray(vectors.real), np.asfortranarray(vectors.imag)
    of_imaginary = norm.lengths(imaginary)
    lengths = np.hypot(norm.lengths(real), of_imaginary)
    turning = of_imaginary > np.finfo(float).eps * lengths
    return np.hstack([real / lengths, (imaginary / lengths)[:, turning]])


class ReducedModel:
    """A pencil on a basis that grows.

    Parameters
    ----------
    pencil
        The pencil.
    box
        Least and greatest value of every parameter that varies.
    max_frequency
        Upper end of the window (Hz).
    min_growth
        With damping or rotation, growth rate (1/s) below zero down to which eigenvalues are in the
        window; None takes a tenth of the angular frequency of its end.

    Attributes
    ----------
    pencil
        The pencil.
    small
        The pencil on the basis.
    """

    def __init__(
        self,
        pencil: Pencil,
        box: Mapping[str, tuple[float, float]],
        max_frequency: float,
        min_growth: float | None = None,
    ) -> None:
        self.pencil = pencil
        self._pieces = Pieces(pencil, box)
        stiff = {name for each in pencil.forces for name in each.inverse_stiffness.names}
        softest = {name: ends[name in stiff] for name, ends in box.items()}
        values = pencil.values(softest)
        self.norms = Norms(pencil, self._pieces, values, max_frequency)
        both = zip(self._pieces.contacts, pencil.forces, strict=True)
        self._stiff = [
            contact
            for contact, each in both
            if each.inverse_stiffness.at(values) * each.body_stiffness[0] < 1
        ]
        self._basis, self._residuals = Span(self.norms.states), Span(self.norms.residuals)
        self._forces = np.empty(0, dtype=bool)  # which vectors of the basis are forces
        self._widest: dict[ContactPiece, float] = {}
        damped = any(piece.role == "damping" for piece in self._pieces.all)
        decay = None if min_growth is None else -min_growth
        window = Window.up_to(max_frequency, damped=damped, decay=decay)
        powers = {"stiffness": (1.0, 0), "damping": (1.0, 1), "mass": (1.0, 2)}
        if not damped:
            powers["mass"] = (-1.0, 1)
        nothing = np.empty((0, 0))
        pieces = [
            (e.coefficient, Term(*powers[e.role], nothing, nothing, nothing, 0.0, nothing))
            for e in self._pieces.all
        ]
        self.small = SmallPencil(tuple(pieces), self._forces, window, self.norms.shift)

    @property
    def size(self) -> int:
        """Vectors of the basis."""
        return self._basis.size

    def take(self, taken: Snapshot) -> None:
        """Take the right and left vectors of a full solve, up to the margin of the window, in."""
        norm, before, forces = self.norms.states, self._basis.size, taken.real_forces()
        blocks = [taken.real_vectors(norm, damped=self.small.window.damped)]
        for contact in self._pieces.contacts:
            own = np.zeros_like(forces)
            own[contact.rows] = forces[contact.rows]
            own = _unit(own, norm.lengths(own))
            blocks.append(self._add_forces(contact, own, contact.compliance(own), FORCES))
        first = self._add_displacements(blocks)
        blocks = []
        for contact in self._pieces.contacts:
            gaps = contact.closes.times(self._basis.vectors[:, first:])
            caused = contact.inverse(gaps)
            # Gaps that vectors close but for rounding tell of no forces.
            longest = float(norm.lengths(caused, gaps).max(initial=0.0))
            self._widest[contact] = max(longest, self._widest.get(contact, 0.0))
            floor = FORCES * self._widest[contact]
            blocks.append(self._add_forces(contact, caused, gaps, floor))
        if blocks:
            self._add_displacements(blocks)
        self._project(before)

    def raise_safety(self, safety: float) -> None:
        """Make all bounds with another factor on the inverse outside of the basis."""
        self.small = replace(self.small, safety=safety)

    def _add_forces(
        self, contact: ContactPiece, forces: Floats, image: Floats, floor: float
    ) -> Floats:
        """Take forces of a contact in; the displacements of length one that stiff ones cause."""
        before = self._basis.size
        self._basis.add(forces, image, floor)
        self._forces = np.pad(self._forces, (0, self._basis.size - before), constant_values=True)
        new = self._basis.vectors[:, before:] if contact in self._stiff else forces[:, :0]
        image = contact.closes.times(new)
        moved = self.norms.solve(image)
        return _unit(moved, self.norms.states.lengths(moved, image))

    def _add_displacements(self, blocks: list[Floats]) -> int:
        """Take displacements in; number of the first vector that is new."""
        before, block = self._basis.size, np.hstack(blocks)
        self._basis.add(block, self.norms.states.image(block), BASIS)
        self._forces = np.pad(self._forces, (0, self._basis.size - before))
        return before

    def _project(self, before: int) -> None:
        """Project all pieces on what the basis has grown by."""
        both = zip(self._pieces.all, self.small.pieces, strict=True)
        grown = [(c, self._grown(piece, term, before)) for piece, (c, term) in both]
        rows = self._residuals.size  # vectors of it come later than some pieces

        def padded(block: Floats) -> Floats:
            return np.pad(block, ((0, rows - len(block)), (0, 0)))

        pieces = [(c, replace(e, right=padded(e.right), left=padded(e.left))) for c, e in grown]
        self.small = replace(self.small, pieces=tuple(pieces), forces=self._forces)

    def _grown(self, piece: Piece, term: Term, before: int) -> Term:
        vectors, norm, eps = self._basis.vectors, self.norms.states, np.finfo(float).eps
        new = vectors[:, before:]
        image = piece.times(new)
        columns = rows = norm.inner(vectors, image)
        right, lost = self._with_images(term.right, image)
        left = right
        if not piece.symmetric:
            image = piece.transposed(new)
            rows = norm.inner(vectors, image)
            left, other = self._with_images(term.left, image)
            lost = max(lost, other)
        # Both are A between new vectors, but for rounding.
        twice = columns[before:], rows[before:].T
        corner = 0.5 * (twice[0] + twice[1])
        square = np.block([[term.square, columns[:before]], [rows[:before].T, corner]])
        seen = (term.rounding - eps * np.abs(term.square)).max(initial=0.0)
        seen = max(seen, np.abs(twice[0] - twice[1]).max(initial=0.0))
        rounding = eps * np.abs(square) + seen * (square != 0)
        lost = float(np.hypot(term.lost, lost))
        return Term(term.factor, term.power, square, right, left, lost, rounding)

    def _with_images(self, before: Floats, image: Floats) -> tuple[Floats, float]:
        """Coordinates of old and new images; the basis of residuals takes the new ones in.

        Images of displacements and those of forces are taken in one after the other: each are loads
        alone or gaps alone, and only gaps need a solve for their norm.
        """
        norm, caused, size = self.norms.residuals, self.norms.caused(image), before.shape[1]
        floor = RESIDUAL * float(norm.lengths(caused, image).max(initial=0.0))
        grown, lost = np.pad(before, ((0, 0), (0, image.shape[1]))), 0.0
        for own in (~self._forces[size:], self._forces[size:]):
            fresh, left_out = self._residuals.add(caused[:, own], image[:, own], floor)
            grown = np.pad(grown, ((0, len(fresh) - len(grown)), (0, 0)))
            grown[:, size:][:, own] = fresh
            lost = float(np.hypot(lost, left_out))
        return grown, lost

    def free(self) -> None:
        """Free factors and pieces."""
        self.norms.free()
        self._pieces.free()


def _unit(block: Floats, lengths: Floats) -> Floats:
    """Columns of length one; those of none are left out."""
    return block[:, lengths > 0] / lengths[lengths > 0]
