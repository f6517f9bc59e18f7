"""The reduced model: every piece of a pencil projected on a basis, and what its residuals need.

With a real X-orthonormal basis V of right and left eigenvectors at some parameters (Galerkin: both
are tested with the same space, so that errors of eigenvalues are products of residuals),

    K_r(t) = sum_j c_j(t) V^T K_j V,    M_r(t) = sum_j c_j(t) V^T M_j V,

and D of damping and rotation alike.

A residual (K(t) - kappa M(t)) V y is a sum of the same kind of A_j V y. With an X-orthonormal basis
Q of X^-1 A_j V for all pieces its norm in X^-1 is the length of sum_j c_j(t) (Q^T A_j V) y: nothing
of the size of the pencil is touched, and no squares are subtracted, which would halve the digits
(A. Buhr, C. Engwer, M. Ohlberger, S. Rave, A numerically stable a posteriori error estimator for
reduced basis approximations of elliptic equations, 2014).

Where a stiffness varies over decades, as that of a contact, its forces on each eigenvector add the
static displacements they cause, X^-1 c_j(t) A_j v: with them the basis can close a gap without
bending (supremizers; G. Rozza, K. Veroy, Comput. Methods Appl. Mech. Engrg. 196 (2007)).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from cea.arrays import Floats
from cea.eigen.left_vectors import POWERS
from cea.eigen.pencil import Pencil
from cea.reduced.norm import EnergyNorm, InnerProduct
from cea.reduced.pieces import ContactPiece, Piece, Pieces
from cea.reduced.saddle import SmallContact
from cea.reduced.small import SmallPencil, SmallPiece
from cea.reduced.snapshots import Snapshot
from cea.reduced.span import Span
from cea.reduced.spectrum import MARGIN, Settings

BASIS = 1e-6
"""Part of an eigenvector, in the energy norm, that a basis leaves out; errors go by its square."""
RESIDUAL = 1e-14
"""Part of the images of the basis that is rounding: the basis of residuals leaves it out."""
FORCES = 1e-8
"""Part of the forces of a contact that the basis of forces leaves out; errors go by its square."""
_LOST = 1e-9
"""What that basis may leave out of a residual, relative to its vector in the energy norm, wherever
on the map: errors go by residuals of 1e-5 and less. A contact that is stiffer by decades than the
norm allows nothing then, or bounds end at what is left out of its forces."""
_DECAY = 0.1
"""Decay down to which a window of a damped pencil reaches by default, relative to its end."""
_STIFFER = 2.0
"""Ratio of coefficients over the map from which on a stiffness adds static displacements."""


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

    Raises
    ------
    InputError
        When the pencil has no reduced model (:class:`cea.reduced.pieces.Pieces`).
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
        least = pencil.values({name: ends[0] for name, ends in box.items()})
        self.norm = EnergyNorm(pencil, least, self._pieces.tied, max_frequency)
        self._basis, self._residuals = Span(self.norm, BASIS), Span(self.norm, RESIDUAL)
        self._contacts = self._pieces.contacts
        self._widest: dict[ContactPiece, float] = {}
        self._forces = [
            Span(InnerProduct(self.norm.comm, each.closes.rows, each.compliance), FORCES)
            for each in self._contacts
        ]
        corners = [
            pencil.values(dict(zip(box, corner, strict=True))) for corner in product(*box.values())
        ]
        self._stiff = [piece for piece in self._pieces.all if _varies_widely(piece, corners)]
        speed = 2 * np.pi * MARGIN * max_frequency
        self._allowed = [
            _LOST / (_largest(piece, corners) * speed ** POWERS[piece.role])
            for piece in self._pieces.all
        ]
        nothing = np.empty((0, 0))
        none = (nothing, nothing, nothing, nothing)
        settings = Settings(max_frequency, self.norm.shift)
        if any(piece.role == "damping" for piece in self._pieces.all):
            decay = _DECAY * settings.end if min_growth is None else -min_growth
            settings = replace(settings, decay=decay)
        self.small = SmallPencil(
            tuple(
                SmallPiece(piece.role, piece.coefficient, nothing, nothing, nothing, 0.0)
                for piece in self._pieces.all
            ),
            tuple(
                SmallContact(each.inverse_stiffness, each.friction, *none, 0.0)
                for each in self._contacts
            ),
            settings,
        )

    @property
    def size(self) -> int:
        """Vectors of the basis."""
        return self._basis.size

    def take(self, taken: Snapshot) -> None:
        """Take the right and left vectors of a full solve, up to the margin of the window, in."""
        values = self.pencil.values(taken.point)
        vectors = taken.real_vectors(self.norm, damped=self.small.settings.damped)
        blocks, images = [vectors], [self.norm.image(vectors)]
        for piece in self._stiff:
            forces = piece.coefficient.at(values) * piece.times(vectors)
            moved = self.norm.solve(forces)
            lengths = np.maximum(self.norm.lengths(moved, forces), 1.0)
            blocks.append(moved / lengths)
            images.append(forces / lengths)
        before, forces_before = self._basis.size, [each.size for each in self._forces]
        for contact, span, size in zip(self._contacts, self._forces, forces_before, strict=True):
            span.add(_unit(span.norm, taken.real_forces(contact.rows)))
            self._add_static(contact, span.vectors[:, size:], blocks, images)
        self._basis.add(np.hstack(blocks), np.hstack(images))
        blocks, images = [], []
        for contact, span in zip(self._contacts, self._forces, strict=True):
            size = span.size
            self._add_gaps(contact, span, before)
            self._add_static(contact, span.vectors[:, size:], blocks, images)
        if blocks:
            self._basis.add(np.hstack(blocks), np.hstack(images))
        self._project(before, forces_before)
        rounding = max(self.small.rounding, taken.rounding)
        self.small = replace(self.small, rounding=rounding)

    def raise_safety(self, safety: float) -> None:
        """Make all bounds with another factor on the inverse outside of the basis."""
        settings = replace(self.small.settings, safety=safety)
        self.small = replace(self.small, settings=settings)

    def _project(self, before: int, forces_before: Sequence[int]) -> None:
        """Project all pieces and contacts on what bases have grown by."""
        pieces = list(self.small.pieces)
        if before < self._basis.size:
            parts = zip(self._pieces.all, pieces, self._allowed, strict=True)
            pieces = [self._grown(piece, small, before, left) for piece, small, left in parts]
        both = zip(self._contacts, self._forces, self.small.contacts, forces_before, strict=True)
        contacts = [self._grown_contact(*each) for each in both]
        rows = self._residuals.size
        self.small = replace(
            self.small,
            pieces=tuple(piece.padded(rows) for piece in pieces),
            contacts=tuple(contact.padded(rows) for contact in contacts),
        )

    def _grown(self, piece: Piece, small: SmallPiece, before: int, allowed: float) -> SmallPiece:
        vectors = self._basis.vectors
        old, new = vectors[:, :before], vectors[:, before:]
        image = piece.times(new)
        whole = self.norm.inner(vectors, image)
        right, lost = self._with_images(small.right, image, allowed)
        if piece.symmetric:
            rows, left = whole[:before].T, right
        else:
            image = piece.transposed(new)
            rows = self.norm.inner(old, image).T
            left, other = self._with_images(small.left, image, allowed)
            lost = max(lost, other)
        square = np.block([[small.square, whole[:before]], [rows, whole[before:]]])
        if piece.symmetric:
            square = 0.5 * (square + square.T)
        lost = float(np.hypot(small.lost, lost))
        return replace(small, square=square, right=right, left=left, lost=lost)

    def _add_gaps(self, contact: ContactPiece, span: Span, before: int) -> None:
        """Take the forces of the gaps of new vectors in."""
        gaps = contact.closes.times(self._basis.vectors[:, before:])
        caused = contact.inverse.solve_block(gaps)
        # Gaps that vectors close but for rounding tell of no forces.
        longest = float(span.norm.lengths(caused, gaps).max(initial=0.0))
        self._widest[contact] = max(longest, self._widest.get(contact, 0.0))
        span.add(caused, gaps, FORCES * self._widest[contact])

    def _add_static(
        self, contact: ContactPiece, forces: Floats, blocks: list[Floats], images: list[Floats]
    ) -> None:
        """The static displacements of length one that forces cause, and X times these."""
        for rectangle in (contact.closes, contact.slides):
            if rectangle is not None:
                image = rectangle.transposed(forces)
                moved = self.norm.solve(image)
                lengths = self.norm.lengths(moved, image)
                lengths[lengths == 0] = 1.0
                blocks.append(moved / lengths)
                images.append(image / lengths)

    def _grown_contact(
        self, contact: ContactPiece, span: Span, small: SmallContact, before: int
    ) -> SmallContact:
        comm, vectors, new = self.norm.comm, self._basis.vectors, span.vectors[:, before:]
        gaps = comm.bcast(comm.allreduce(span.vectors.T @ contact.closes.times(vectors)))
        normal, lost = self._with_images(small.normal_forces, contact.closes.transposed(new), 0.0)
        slid, friction = np.zeros_like(gaps), np.zeros_like(normal)
        if contact.slides is not None:
            slid = comm.bcast(comm.allreduce(span.vectors.T @ contact.slides.times(vectors)))
            image = contact.slides.transposed(new)
            friction, other = self._with_images(small.friction_forces, image, 0.0)
            lost = max(lost, other)
        lost = float(np.hypot(small.lost, lost))
        return replace(
            small,
            closes=gaps,
            slides=slid,
            normal_forces=normal,
            friction_forces=friction,
            lost=lost,
        )

    def _with_images(self, before: Floats, image: Floats, allowed: float) -> tuple[Floats, float]:
        """Coordinates of old and new images; the basis of residuals takes the new ones in."""
        fresh, lost = self._residuals.add(self.norm.solve(image), image, allowed)
        grown = np.zeros((self._residuals.size, before.shape[1] + image.shape[1]))
        grown[: before.shape[0], : before.shape[1]] = before
        grown[:, before.shape[1] :] = fresh
        return grown, lost

    def free(self) -> None:
        """Free factors and pieces."""
        self.norm.free()
        self._pieces.free()


def _unit(norm: InnerProduct, block: Floats) -> Floats:
    """Columns of length one; those of none are left out."""
    lengths = norm.lengths(block)
    return block[:, lengths > 0] / lengths[lengths > 0]


def _largest(piece: Piece, corners: list[dict[str, float]]) -> float:
    """Largest coefficient of a piece over a map."""
    sizes = [abs(piece.coefficient.at(corner)) for corner in corners]
    return max(max(sizes), np.finfo(float).tiny)


def _varies_widely(piece: Piece, corners: list[dict[str, float]]) -> bool:
    """Whether a symmetric stiffness varies by decades over a map."""
    if not piece.symmetric or piece.role != "stiffness":
        return False
    sizes = [piece.coefficient.at(corner) for corner in corners]
    if min(sizes) < 0:  # it softens, as rotation does
        return False
    return max(sizes) > _STIFFER * min(sizes)
