"""A pencil on a basis, in small matrices alone: what is solved at any parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.parameters import Dependence
from cea.eigen.pencil import Role
from cea.reduced.certificate import Polynomial, Term, real_times
from cea.reduced.following import Sample
from cea.reduced.pieces import Values
from cea.reduced.spectrum import ReducedSpectrum, Settings, reduced_spectrum
from cea.reduced.window import Window


@dataclass(frozen=True)
class SmallPiece:
    """One piece of a pencil on a basis V of states, with coordinates Q of what its images cause.

    V^T A V; coordinates of A V and A^T V, the same object where A is symmetric; norm of what Q does
    not hold of either; largest error of an entry of V^T A V by rounding.
    """

    role: Role
    coefficient: Dependence
    square: Floats
    right: Floats
    left: Floats
    lost: float
    rounding: float = 0.0

    def ordered(self, order: Ints, rows: int) -> "SmallPiece":
        """With its vectors in another order, and zeros for vectors of Q that came later."""

        def padded(coordinates: Floats) -> Floats:
            return np.pad(coordinates, ((0, rows - len(coordinates)), (0, 0)))[:, order]

        right = padded(self.right)
        left = right if self.left is self.right else padded(self.left)
        return replace(self, square=self.square[np.ix_(order, order)], right=right, left=left)


@dataclass(frozen=True)
class SmallPencil:
    """All pieces on one basis of so many displacements, with contact forces behind them."""

    pieces: tuple[SmallPiece, ...]
    displacements: int
    settings: Settings

    def at(self, values: Values) -> ReducedSpectrum:
        """Eigenvalues of the window and its margin at values of all parameters."""
        if not self.displacements:
            return ReducedSpectrum.empty(self.settings)
        terms = tuple(self._term(role, values) for role in self._powers)
        return reduced_spectrum(Polynomial(terms), self.displacements, self.settings)

    def derivatives(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """Derivatives of eigenvalues lambda, as :meth:`slopes`; infinite at a coalescence."""
        slopes = self.slopes(found, values, rates)
        if self.settings.window.damped:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return -slopes / (2 * found.eigenvalues)

    def slopes(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """Derivatives of z where parameters change at given rates.

        - y^H dP(z) x / y^H P'(z) x; infinite at a coalescence.
        """
        change: Complexes = np.zeros(len(found), dtype=complex)
        for piece in self.pieces:
            slope = sum(
                rate * piece.coefficient.derivative(name, values) for name, rate in rates.items()
            )
            if slope:
                factor, power = self._powers[piece.role]
                image = real_times(piece.square, found.right)
                projected = np.einsum("ij,ij->j", found.left.conj(), image)
                change -= slope * factor * found.z**power * projected
        with np.errstate(divide="ignore", invalid="ignore"):
            moved: Complexes = change / found.overlaps
        return moved

    @property
    def _powers(self) -> dict[Role, tuple[float, int]]:
        """Factor and power of z of the terms of P(z)."""
        if self.settings.window.damped:
            return {"stiffness": (1.0, 0), "damping": (1.0, 1), "mass": (1.0, 2)}
        return {"stiffness": (1.0, 0), "mass": (-1.0, 1)}

    def _term(self, role: Role, values: Values) -> Term:
        """The sum of all pieces of a role.

        Its entries are off relative to their parts, and by what was seen of these.
        """
        square, rounding = np.zeros((2, *self.pieces[0].square.shape))
        right, left = np.zeros((2, *self.pieces[0].right.shape))
        lost, eps = 0.0, np.finfo(float).eps
        for piece in self.pieces:
            c = piece.coefficient.at(values) if piece.role == role else 0.0
            if not c:
                continue
            square += c * piece.square
            right += c * piece.right
            left += c * piece.left
            lost += abs(c) * piece.lost
            rounding += abs(c) * (eps * np.abs(piece.square) + piece.rounding * (piece.square != 0))
        return Term(*self._powers[role], square, right, left, lost, rounding)


@dataclass(frozen=True)
class ModelLine:
    """Spectra of a reduced model along a line, a :class:`cea.reduced.thresholds.Line`.

    ``parameters`` gives those at a value of the line, which change at ``rates``; modes that grow by
    more than ``level`` (1/s) count; spectra that are known serve again.
    """

    small: SmallPencil
    parameters: Callable[[float], Values]
    rates: Mapping[str, float]
    level: float = 0.0
    known: dict[float, ReducedSpectrum] = field(default_factory=dict)

    @property
    def window(self) -> Window:
        """What is looked at."""
        return replace(self.small.settings.window, level=self.level)

    def at(self, value: float) -> Sample:
        """The spectrum at a value."""
        at = self.parameters(value)
        found = self.known.get(value) or self.small.at(at)
        slopes = self.small.slopes(found, at, self.rates)
        vectors = found.shapes / np.linalg.norm(found.shapes, axis=0)
        bounds = found.errors, found.means, found.clusters
        sample = Sample(value, found.z, slopes, *bounds, vectors)
        return sample.with_mirror_image() if self.window.damped else sample
