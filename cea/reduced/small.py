"""A pencil on a basis, in small matrices alone, and on few vectors of that basis once more."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from cea.arrays import Complexes, Floats
from cea.eigen.left_vectors import POWERS
from cea.eigen.parameters import Dependence
from cea.eigen.pencil import Role
from cea.reduced.pieces import Values
from cea.reduced.products import like_times, real_times
from cea.reduced.quadratic import quadratic_spectrum
from cea.reduced.residuals import Residuals
from cea.reduced.rounding import Rounding
from cea.reduced.saddle import Saddle, SmallContact
from cea.reduced.spectrum import ReducedSpectrum, Settings, reduced_spectrum
from cea.reduced.stiff_norm import StiffNorm, stiff_norm

LOCAL = 1e-5
"""Part of an eigenvector of the larger basis that a local one leaves out, or of its forces."""

Seen = tuple[float, tuple[float, ...]]
"""What rounding does to eigenvalues of condition one (1/s^2), and the stiff coefficients there."""


@dataclass(frozen=True)
class SmallPiece:
    """One piece of a pencil on a basis V, with X^-1-coordinates Q of its images.

    Parameters
    ----------
    role, coefficient
        Those of the piece (:class:`cea.reduced.pieces.Piece`).
    square
        V^T A V, shape (k, k).
    right, left
        Q^T A V and Q^T A^T V, shape (q, k); the same object where A is symmetric.
    lost
        Norm of what Q does not hold of X^-1 A V, either side.
    stiff
        Whether it is a stiffness that varies over decades.
    least
        Of such a one, its coefficient in the energy norm.
    whole
        On a local basis, V^T A V on the larger one that it was made of; None on that itself.
    """

    role: Role
    coefficient: Dependence
    square: Floats
    right: Floats
    left: Floats
    lost: float
    stiff: bool = False
    least: float = 0.0
    whole: Floats | None = None

    @property
    def symmetric(self) -> bool:
        """Whether A is symmetric."""
        return self.left is self.right

    def padded(self, rows: int) -> "SmallPiece":
        """With zeros for vectors of Q that came later."""
        right = _padded(self.right, rows)
        return replace(
            self, right=right, left=right if self.symmetric else _padded(self.left, rows)
        )


@dataclass(frozen=True)
class SmallPencil:
    """All pieces on one basis: what is solved at any parameters.

    Parameters
    ----------
    pieces
        The pieces.
    settings
        What bounds are made with.
    roundings
        What rounding does where it was seen.
    axes
        Of a local basis, its vectors in the larger one; None of the larger one itself.
    norm
        Measures residuals where stiff pieces are stiffer than in the energy norm; None leaves them
        in that.
    contacts
        Contacts whose forces are unknowns; local bases have none.
    """

    pieces: tuple[SmallPiece, ...]
    settings: Settings
    roundings: tuple[Seen, ...] = ()
    axes: Floats | None = None
    norm: StiffNorm | None = None
    contacts: tuple[SmallContact, ...] = ()

    @property
    def size(self) -> int:
        """Vectors of the basis."""
        return len(self.pieces[0].square)

    @property
    def damped(self) -> bool:
        """Whether anything acts on velocities at some parameters."""
        return any(piece.role == "damping" for piece in self.pieces)

    def at(self, values: Mapping[str, float]) -> ReducedSpectrum:
        """Eigenvalues of the window and its margin at values of all parameters."""
        K, M = (self._sum(role, values) for role in ("stiffness", "mass"))
        saddle = Saddle.at(self.contacts, values) if self.size else None
        rounding = self._rounding(values, saddle)
        if self.damped:
            D = self._sum("damping", values)
            found = quadratic_spectrum(K, D, M, self.settings, rounding, saddle)
        else:
            found = reduced_spectrum(K, M, self.settings, rounding, saddle)
        return found if self.axes is None else found.lifted(self.axes)

    def derivatives(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """Derivatives of eigenvalues lambda in parameters that change together, shape (n,).

        Infinite at a coalescence; parameters as of :meth:`slopes`.
        """
        slopes = self.slopes(found, values, rates)
        if self.damped:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return -slopes / (2 * found.eigenvalues)

    def slopes(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """Derivatives of kappa, with damping of lambda, shape (n,); infinite at a coalescence.

        y^H (dK - kappa dM) x / y^H M x, with damping
        - y^H (lambda^2 dM + lambda dD + dK) x / y^H (2 lambda M + D) x.

        Parameters
        ----------
        found
            Eigenvalues, their coordinates in this basis or, of a local one, in the larger one.
        values
            Values of all parameters there.
        rates
            How fast each of the parameters changes.
        """
        x, y = self.coordinates(found.right), self.coordinates(found.left).conj()
        eigenvalues = found.eigenvalues
        one: Complexes = np.ones(len(found), dtype=complex)
        speeds = {"mass": -2 * eigenvalues, "damping": -one} if self.damped else {"mass": one}
        change: Complexes = np.zeros(len(found), dtype=complex)
        turned: Complexes = np.zeros(len(found), dtype=complex)
        for piece in self.pieces:
            slope = sum(
                rate * piece.coefficient.derivative(name, values) for name, rate in rates.items()
            )
            factor = piece.coefficient.at(values) if piece.role in speeds else 0.0
            if not (slope or factor):
                continue
            projected = np.einsum("ij,ij->j", y, real_times(piece.square, x))
            if self.damped or piece.role == "stiffness":
                change += slope * eigenvalues ** POWERS[piece.role] * projected
            else:
                change -= slope * found.kappa * projected
            if factor:
                turned += factor * speeds[piece.role] * projected
        change += self._moved_contacts(found, values, rates)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved: Complexes = change / turned
        return moved

    def _moved_contacts(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """What contacts whose forces are unknowns add to y^H dK x, shape (n,)."""
        change: Complexes = np.zeros(len(found), dtype=complex)
        first, y = 0, found.left.conj()
        for each in self.contacts:
            rows = slice(first, first + len(each.closes))
            b, g, first = found.forces[rows], found.left_forces[rows].conj(), rows.stop
            friction, compliance = (
                sum(rate * of.derivative(name, values) for name, rate in rates.items())
                for of in (each.friction, each.inverse_stiffness)
            )
            if friction:
                change -= friction * np.einsum("ij,ij->j", y, real_times(each.slides.T, b))
            if compliance:
                change -= compliance * np.einsum("ij,ij->j", g, b)
        return change

    def coordinates[T: (Floats, Complexes)](self, vectors: T) -> T:
        """Of vectors in the larger basis, in this one."""
        return vectors if self.axes is None else like_times(self.axes.T, vectors)

    def where(self, stiffness: Sequence[float]) -> "SmallPencil":
        """It with residuals measured where stiff pieces are no softer than so.

        Parameters
        ----------
        stiffness
            Coefficients of the pieces that are stiff, the least where it is to serve.
        """
        stiff = [piece for piece in self.pieces if piece.stiff]
        parts = [
            (size, piece.least, piece.right, piece.square)
            for size, piece in zip(stiffness, stiff, strict=True)
        ]
        return replace(self, norm=stiff_norm(parts))

    def local(
        self, vectors: Floats, stiff: Values | None = None, tolerance: float = LOCAL
    ) -> "SmallPencil":
        """The pencil on the span of some coordinates; its residuals are as full as before.

        Parameters
        ----------
        vectors
            Coordinates in this basis, shape (k, columns).
        stiff
            Values of all parameters where the basis is to serve: what is left out is measured by
            the forces that it has there. None where these vary widely: by itself.
        tolerance
            Part of the vectors that is left out.
        """
        axes = vectors / np.linalg.norm(vectors, axis=0)
        if stiff is None:
            axes = _principal(axes, tolerance)
        else:
            norm = self._stiffened(stiff)
            axes = cho_solve(cho_factor(norm), _principal(norm @ axes, tolerance))
            axes, _ = np.linalg.qr(axes)
        images = [piece.right @ axes for piece in self.pieces]
        images += [piece.left @ axes for piece in self.pieces if not piece.symmetric]
        if self.norm is not None:
            images = [self.norm.real(image) for image in images]
        # Lengths of combinations are those of the columns of R.
        columns = np.split(np.linalg.qr(np.hstack(images), mode="r"), len(images), axis=1)
        lefts = iter(columns[len(self.pieces) :])
        return SmallPencil(
            tuple(
                replace(
                    piece,
                    square=axes.T @ piece.square @ axes,
                    right=right,
                    left=right if piece.symmetric else next(lefts),
                    whole=piece.square if piece.whole is None else piece.whole,
                )
                for piece, right in zip(self.pieces, columns, strict=False)
            ),
            self.settings,
            self.roundings,
            axes if self.axes is None else self.axes @ axes,
        )

    def spanned(self, found: ReducedSpectrum, static: Values | None = None) -> Floats:
        """Coordinates that a local basis takes from a spectrum, shape (k, columns).

        Real and imaginary parts of right and left vectors, of unit length; and, at values of all
        parameters, the static displacements under the forces that stiff pieces have on them there:
        X is one in this basis. Coordinates are in this one too, of whichever the spectrum is. Left
        vectors keep gaps open that friction closes; where a contact is
        all but rigid no others can be closed without these.
        """
        vectors = columns_of(self.coordinates(found.right), self.coordinates(found.left))
        blocks = [vectors]
        for piece in self.pieces:
            if piece.stiff and static is not None:
                moved = piece.coefficient.at(static) * piece.square @ vectors
                blocks.append(moved / np.maximum(np.linalg.norm(moved, axis=0), 1.0))
        return np.hstack(blocks)

    def _stiffened(self, values: Values) -> Floats:
        """The energy norm at some parameters: that of the basis, one, with what is stiff there."""
        norm = np.eye(self.size)
        for piece in self.pieces:
            if piece.stiff:
                norm += piece.coefficient.at(values) * piece.square
        return norm

    def stiffness(self, values: Values) -> list[float]:
        """Coefficients of the pieces that are stiff."""
        return [piece.coefficient.at(values) for piece in self.pieces if piece.stiff]

    def _rounding(self, values: Values, saddle: Saddle | None) -> Rounding:
        """What rounding does to eigenvalues.

        That of full solves is less in proportion where it was seen at greater stiffness, but no
        less than anywhere.
        """
        stiff = self.stiffness(values)
        sizes = [
            size * max((min(1.0, a / b) for a, b in zip(stiff, at, strict=True)), default=1.0)
            for size, at in self.roundings
        ]
        least = min((size for size, _ in self.roundings), default=0.0)
        entries = {role: self._entries(role, values) for role in POWERS}
        if saddle is not None:
            entries = {role: saddle.padded(each) for role, each in entries.items()}
            entries["stiffness"] = saddle.rounded(self._entries("stiffness", values))
        return Rounding(max([least, *sizes]), entries, self.axes)

    def _entries(self, role: Role, values: Values) -> Floats:
        """sum_j |c_j| |V^T A_j V| of one role on the larger basis."""
        parts = []
        for piece in self.pieces:
            if piece.role == role:
                square = piece.square if piece.whole is None else piece.whole
                parts.append((abs(piece.coefficient.at(values)), np.abs(square)))
        size = self.size if self.axes is None else len(self.axes)
        return _weighted(parts, (size, size))

    def _sum(self, role: Role, values: Values) -> Residuals:
        parts = [
            (factor, piece)
            for piece in self.pieces
            if piece.role == role and (factor := piece.coefficient.at(values))
        ]
        square = _weighted(
            [(factor, piece.square) for factor, piece in parts], (self.size, self.size)
        )
        shape = self.pieces[0].right.shape
        both = [(factor, piece.right) for factor, piece in parts if piece.symmetric]
        left = right = _weighted(both, shape)
        one_sided = [(factor, piece) for factor, piece in parts if not piece.symmetric]
        if one_sided:
            left = right + _weighted([(f, piece.left) for f, piece in one_sided], shape)
            right = right + _weighted([(f, piece.right) for f, piece in one_sided], shape)
        lost = sum(abs(factor) * piece.lost for factor, piece in parts)
        return Residuals(square, right, left, lost, self.norm)


def _weighted(parts: list[tuple[float, Floats]], shape: tuple[int, ...]) -> Floats:
    """Sum of factors times matrices of one shape."""
    if not parts:
        return np.zeros(shape)
    total = parts[0][0] * parts[0][1]
    for factor, matrix in parts[1:]:
        total += factor * matrix
    return total


def columns_of(right: Complexes, left: Complexes) -> Floats:
    """Real and imaginary parts of right and left vectors, each of unit length, those not zero."""
    units = [each / np.linalg.norm(each, axis=0) for each in (right, left)]
    vectors = np.hstack([part for each in units for part in (each.real, each.imag)])
    return vectors[:, vectors.any(axis=0)]


def _principal(vectors: Floats, least: float) -> Floats:
    """Principal directions of columns, those longer than a length."""
    axes, sizes, _ = np.linalg.svd(vectors, full_matrices=False)
    kept: Floats = axes[:, sizes > least]
    return kept


def _padded(rows_of: Floats, rows: int) -> Floats:
    return np.pad(rows_of, ((0, rows - len(rows_of)), (0, 0)))
