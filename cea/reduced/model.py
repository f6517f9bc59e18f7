"""The reduced model: all terms of a pencil projected on a basis, with data for residual norms.

The real basis V holds states at some parameters: right and left eigenvectors with their contact
forces (Galerkin: test and trial spaces are equal, so that errors of eigenvalues are products of
residuals). The reduced matrices are

    K_r(t) = sum_j c_j(t) V^T K_j V,    M_r(t) = sum_j c_j(t) V^T M_j V,

and likewise D of damping and rotation. A residual (K(t) - kappa M(t)) V y is a similar sum of
A_j V y. With an orthonormal basis Q of the Riesz representatives of all A_j V its norm is that of
sum_j c_j(t) (Q^T A_j V) y, computed in small matrices and without subtracting squares, which would
halve the digits (A. Buhr, C. Engwer, M. Ohlberger, S. Rave, A numerically stable a posteriori error
estimator for reduced basis approximations of elliptic equations, 2014).

For every gap the basis contains the forces that close it. For forces of a contact stiffer than its
bodies it contains the static displacements that they cause, so that the basis can close a gap
without bending (supremizers; G. Rozza, K. Veroy, Comput. Methods Appl. Mech. Engrg. 196 (2007)).
A softer contact needs none: its gaps open in the full solves.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from cea.arrays import Complexes, Floats, real_product
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.reduced.basis import InnerProduct, Norms, Span
from cea.reduced.certificate import Term
from cea.reduced.pieces import ContactPiece, Piece, Pieces
from cea.reduced.spectrum import DECAY, ReducedSpectrum, Window, spectrum_of

BASIS = 1e-6
"""Norm of the part of an eigenvector outside the basis, relative to its energy norm, below which it
is dropped; errors of eigenvalues go with its square."""
RESIDUAL = 1e-14
"""Relative norm of an image of the basis below which the basis of residuals drops it."""
FORCES = 1e-8
"""Relative norm of contact forces below which the basis drops them; errors go with its square."""
_SAFETY = 2.0
"""Initial safety factor on the inverse of the pencil outside the basis."""
_MOTIONS, _PRESSURES, _STATIC = 1e-5, 1e-7, 1e-2
"""Relative norms of displacements, forces and static displacements that a part of a basis drops."""
_SMALLER = 0.7
"""Size of a part relative to the whole basis from which on the whole is used."""


def _real_vectors(modes: Modes, norm: InnerProduct, *, damped: bool) -> Floats:
    """Return states of real and imaginary parts of all eigenvectors, scaled to unit norm.

    Only one of two conjugate kappa is used; there are none with damping. Phases are chosen to
    maximise the real parts.
    """
    assert modes.left is not None
    one = ((-(modes.eigenvalues**2)).imag >= 0) | damped
    parts = [_parts(norm, modes.vectors[:, one])]
    if norm.comm.allreduce(not np.array_equal(modes.left.vectors, modes.vectors)):
        parts.append(_parts(norm, modes.left.vectors[:, one]))
    return np.hstack(parts)


def _real_forces(modes: Modes, norm: InnerProduct) -> Floats:
    """Return states of real and imaginary parts of all contact forces."""
    assert modes.left is not None
    first = len(modes.vectors)
    both = modes.forces[: norm.rows - first], modes.left.forces[: norm.rows - first]
    parts = np.hstack([part for each in both for part in (each.real, each.imag)])
    return np.pad(parts, ((first, 0), (0, 0)))


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
    """A pencil projected on a growing basis.

    Parameters
    ----------
    pencil
        The full pencil.
    box
        Least and greatest value of every parameter that varies.
    max_frequency
        Upper end of the window (Hz).
    min_growth
        With damping or rotation, lower end of the growth rates of the window (1/s), negative; None
        takes minus a tenth of 2 pi max_frequency.
    level
        Growth rate (1/s) above which modes count as growing.

    Attributes
    ----------
    pencil
        The full pencil.
    window
        The window of modes.
    forces
        Which vectors of the basis are contact forces, shape (size,).
    safety
        Safety factor of all bounds, on the inverse of the pencil outside the basis.
    """

    def __init__(
        self,
        pencil: Pencil,
        box: Mapping[str, tuple[float, float]],
        max_frequency: float,
        min_growth: float | None = None,
        level: float = 0.0,
    ) -> None:
        self.pencil = pencil
        self._pieces = Pieces(pencil, box)
        stiff = {name for each in pencil.forces for name in each.inverse_stiffness.names}
        softest = {name: ends[name in stiff] for name, ends in box.items()}
        values = pencil.values(softest)
        end = 2 * np.pi * max_frequency
        self.norms = Norms(pencil, self._pieces, values, end)
        self._stiff = [
            each
            for each in self._pieces.contacts
            if each.of.inverse_stiffness.at(values) * each.of.body_stiffness[0] < 1
        ]
        self._basis, self._residuals = Span(self.norms.states), Span(self.norms.residuals)
        self.forces = np.empty(0, dtype=bool)
        self._part: Floats | None = None
        self._widest: dict[ContactPiece, float] = {}
        damped = any(piece.role == "damping" for piece in self._pieces.all)
        decay = DECAY * end if min_growth is None else -min_growth
        self.window = Window(end, damped, level, decay if damped else np.inf)
        self.safety = _SAFETY
        of_mass = (1.0, 2) if damped else (-1.0, 1)
        powers = {"stiffness": (1.0, 0), "damping": (1.0, 1), "mass": of_mass}
        nothing = np.empty((0, 0))
        self._terms = [
            Term(*powers[piece.role], nothing, nothing, nothing, 0.0, nothing)
            for piece in self._pieces.all
        ]

    @property
    def size(self) -> int:
        """Number of vectors of the basis."""
        return self._basis.size

    def at(self, point: Mapping[str, float]) -> ReducedSpectrum:
        """Return the eigenvalues of the window and its margin where some parameters have values."""
        values = self.pencil.values(point)
        both = zip(self._pieces.all, self._terms, strict=True)
        parts = [(piece.coefficient.at(values), term) for piece, term in both]
        powers = sorted({term.power for term in self._terms})
        terms = [Term.summed([each for each in parts if each[1].power == p]) for p in powers]
        return spectrum_of(terms, self.forces, self.window, self.norms.shift, self.safety)

    def slopes(
        self, found: ReducedSpectrum, point: Mapping[str, float], rates: Mapping[str, float]
    ) -> Complexes:
        """Return derivatives of z at a point where parameters change at given rates.

        They are - y^H dP(z) x / y^H P'(z) x; infinite at a coalescence.
        """
        values = self.pencil.values(point)
        change: Complexes = np.zeros(len(found), dtype=complex)
        for piece, term in zip(self._pieces.all, self._terms, strict=True):
            slope = sum(c * piece.coefficient.derivative(name, values) for name, c in rates.items())
            if slope:
                image = real_product(term.square.dot, found.right)
                projected = np.einsum("ij,ij->j", found.left.conj(), image)
                change -= slope * term.factor * found.z**term.power * projected
        with np.errstate(divide="ignore", invalid="ignore"):
            moved: Complexes = change / found.overlaps
        return moved

    def shapes(self, found: ReducedSpectrum) -> Complexes:
        """Return unit displacements of right vectors in one basis for all parts of a model."""
        own = found.right[~self.forces]
        lifted = own if self._part is None else real_product(self._part.dot, own)
        return np.asarray(lifted / np.linalg.norm(lifted, axis=0), dtype=complex)

    def part(self, spectra: Sequence[ReducedSpectrum]) -> "ReducedModel":
        """Return the model on the part of its basis that holds given spectra, and theirs between.

        The part has displacements and forces of all vectors, forces that close the gaps of these
        displacements, and static displacements under these forces. Where it is not much smaller,
        the model itself is returned.
        """
        own, forces = ~self.forces, self.forces
        vectors = [block for each in spectra for block in (each.right, each.left)]
        motions, pressures = (
            np.hstack([_scaled_parts(block[rows]) for block in vectors]) for rows in (own, forces)
        )
        closing = [each.closes for each in self._pieces.contacts]
        gaps = np.zeros((int(forces.sum()), int(own.sum())))
        for piece, term in zip(self._pieces.all, self._terms, strict=True):
            if any(piece is each for each in closing):
                gaps += term.square[np.ix_(forces, own)]
        gaps /= max(float(np.linalg.norm(gaps, ord=2)), np.finfo(float).tiny) if gaps.size else 1.0
        u = _leading(motions, _MOTIONS)
        f = _leading(np.hstack([pressures, gaps @ u]), _PRESSURES)
        static = gaps.T @ f
        u = np.hstack([u, _leading(static - u @ (u.T @ static), _STATIC, 1.0)])
        if u.shape[1] + f.shape[1] > _SMALLER * self.size:
            return self
        chosen = np.zeros((self.size, u.shape[1] + f.shape[1]))
        chosen[own, : u.shape[1]], chosen[forces, u.shape[1] :] = u, f
        smaller = copy(self)
        smaller._part, smaller._terms = u, [term.on(chosen) for term in self._terms]
        smaller.forces = np.arange(chosen.shape[1]) >= u.shape[1]
        return smaller

    def take(self, modes: Modes) -> None:
        """Extend the basis by the right and left vectors and contact forces of a full solve."""
        norm, before = self.norms.states, self._basis.size
        forces = _real_forces(modes, norm)
        blocks = [_real_vectors(modes, norm, damped=self.window.damped)]
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
            # Gaps that are closed up to rounding yield no forces.
            longest = float(norm.lengths(caused, gaps).max(initial=0.0))
            self._widest[contact] = max(longest, self._widest.get(contact, 0.0))
            floor = FORCES * self._widest[contact]
            blocks.append(self._add_forces(contact, caused, gaps, floor))
        if blocks:
            self._add_displacements(blocks)
        self._project(before)

    def _add_forces(
        self, contact: ContactPiece, forces: Floats, image: Floats, floor: float
    ) -> Floats:
        """Extend the basis by contact forces; return the unit displacements of stiff contacts."""
        before = self._basis.size
        self._basis.add(forces, image, floor)
        self.forces = np.pad(self.forces, (0, self._basis.size - before), constant_values=True)
        new = self._basis.vectors[:, before:] if contact in self._stiff else forces[:, :0]
        image = contact.closes.times(new)
        moved = self.norms.solve(image)
        return _unit(moved, self.norms.states.lengths(moved, image))

    def _add_displacements(self, blocks: list[Floats]) -> int:
        """Extend the basis by displacements; return the index of the first new vector."""
        before, block = self._basis.size, np.hstack(blocks)
        self._basis.add(block, self.norms.states.image(block), BASIS)
        self.forces = np.pad(self.forces, (0, self._basis.size - before))
        return before

    def _project(self, before: int) -> None:
        """Project all terms on the new vectors of the basis."""
        both = zip(self._pieces.all, self._terms, strict=True)
        grown = [self._grown(piece, term, before) for piece, term in both]
        rows = self._residuals.size  # later terms add rows to those of earlier ones

        def padded(term: Term) -> Term:
            right, left = (
                np.pad(block, ((0, rows - len(block)), (0, 0))) for block in (term.right, term.left)
            )
            return replace(term, right=right, left=right if term.left is term.right else left)

        self._terms = [padded(each) for each in grown]

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
        # Both products contain V^T A V of the new vectors: their difference is rounding.
        twice = columns[before:], rows[before:].T
        corner = 0.5 * (twice[0] + twice[1])
        square = np.block([[term.square, columns[:before]], [rows[:before].T, corner]])
        seen = (term.rounding - eps * np.abs(term.square)).max(initial=0.0)
        seen = max(seen, np.abs(twice[0] - twice[1]).max(initial=0.0))
        rounding = eps * np.abs(square) + seen * (square != 0)
        lost = float(np.hypot(term.lost, lost))
        return Term(term.factor, term.power, square, right, left, lost, rounding)

    def _with_images(self, before: Floats, image: Floats) -> tuple[Floats, float]:
        """Extend the basis of residuals by new images; return all coordinates and the norm lost.

        Images of displacements and of forces are added separately: each consist of loads alone or
        gaps alone, and only gaps need a solve for their norm.
        """
        norm, caused, size = self.norms.residuals, self.norms.caused(image), before.shape[1]
        floor = RESIDUAL * float(norm.lengths(caused, image).max(initial=0.0))
        grown, lost = np.pad(before, ((0, 0), (0, image.shape[1]))), 0.0
        for own in (~self.forces[size:], self.forces[size:]):
            fresh, left_out = self._residuals.add(caused[:, own], image[:, own], floor)
            grown = np.pad(grown, ((0, len(fresh) - len(grown)), (0, 0)))
            grown[:, size:][:, own] = fresh
            lost = float(np.hypot(lost, left_out))
        return grown, lost

    def free(self) -> None:
        """Free factors and matrices; eigenvalues can still be computed."""
        self._pieces.free()


def _unit(block: Floats, lengths: Floats) -> Floats:
    """Return the columns scaled to unit norm, without zero columns."""
    return block[:, lengths > 0] / lengths[lengths > 0]


def _scaled_parts(block: Complexes) -> Floats:
    """Return real and imaginary parts of columns, relative to the norm of each column."""
    lengths = np.maximum(np.linalg.norm(block, axis=0), np.finfo(float).tiny)
    return np.hstack([block.real / lengths, block.imag / lengths])


def _leading(block: Floats, floor: float, largest: float | None = None) -> Floats:
    """Return the left singular vectors of a block above a fraction of the largest value."""
    squares, vectors = np.linalg.eigh(block @ block.T)
    most = squares.max(initial=0.0) if largest is None else largest**2
    return vectors[:, squares > floor**2 * max(most, np.finfo(float).tiny)]
