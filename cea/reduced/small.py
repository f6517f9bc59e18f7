"""A pencil on a basis, in small matrices alone: what is solved at any parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.parameters import Dependence
from cea.eigen.pencil import POWERS, Role
from cea.reduced.certificate import Residuals, Rounding, real_times
from cea.reduced.following import Sample, Window
from cea.reduced.pieces import Values
from cea.reduced.spectrum import ReducedSpectrum, Settings, reduced_spectrum


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

    @property
    def symmetric(self) -> bool:
        """Whether A is symmetric."""
        return self.left is self.right

    def ordered(self, order: Ints, rows: int) -> "SmallPiece":
        """With its vectors in another order, and zeros for vectors of Q that came later."""

        def padded(coordinates: Floats) -> Floats:
            return np.pad(coordinates, ((0, rows - len(coordinates)), (0, 0)))[:, order]

        right = padded(self.right)
        left = right if self.symmetric else padded(self.left)
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
        K, M = (self._sum(role, values) for role in ("stiffness", "mass"))
        D = self._sum("damping", values) if self.settings.damped else None
        rounding = Rounding({role: self._rounding(role, values) for role in POWERS})
        return reduced_spectrum(K, D, M, self.displacements, self.settings, rounding)

    def derivatives(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """Derivatives of eigenvalues lambda, as :meth:`slopes`; infinite at a coalescence."""
        slopes = self.slopes(found, values, rates)
        if self.settings.damped:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return -slopes / (2 * found.eigenvalues)

    def slopes(
        self, found: ReducedSpectrum, values: Values, rates: Mapping[str, float]
    ) -> Complexes:
        """Derivatives of kappa, with damping of lambda, where parameters change at given rates.

        y^H (dK - kappa dM) x / y^H M x, with damping - y^H (lambda^2 dM + lambda dD + dK) x / y^H
        (2 lambda M + D) x; infinite at a coalescence.
        """
        y, eigenvalues, damped = found.left.conj(), found.eigenvalues, self.settings.damped
        one: Complexes = np.ones(len(found), dtype=complex)
        speeds: dict[str, Complexes] = (
            {"mass": -2 * eigenvalues, "damping": -one} if damped else {"mass": one}
        )
        change: Complexes = np.zeros(len(found), dtype=complex)
        turned: Complexes = np.zeros(len(found), dtype=complex)
        for piece in self.pieces:
            slope = sum(
                rate * piece.coefficient.derivative(name, values) for name, rate in rates.items()
            )
            factor = piece.coefficient.at(values) if piece.role in speeds else 0.0
            if not (slope or factor):
                continue
            projected = np.einsum("ij,ij->j", y, real_times(piece.square, found.right))
            if damped or piece.role == "stiffness":
                change += slope * eigenvalues ** POWERS[piece.role] * projected
            else:
                change -= slope * found.z * projected
            if factor:
                turned += factor * speeds[piece.role] * projected
        with np.errstate(divide="ignore", invalid="ignore"):
            moved: Complexes = change / turned
        return moved

    def _parts(self, role: Role, values: Values) -> list[tuple[float, SmallPiece]]:
        own = [piece for piece in self.pieces if piece.role == role]
        return [(c, piece) for piece in own if (c := piece.coefficient.at(values))]

    def _rounding(self, role: Role, values: Values) -> Floats:
        """Errors of entries of the reduced matrices, relative to their parts or those of these."""
        eps = np.finfo(float).eps
        parts = [
            (abs(c), eps * np.abs(piece.square) + piece.rounding * (piece.square != 0))
            for c, piece in self._parts(role, values)
        ]
        return _weighted(parts, self.pieces[0].square.shape)

    def _sum(self, role: Role, values: Values) -> Residuals:
        parts, shape = self._parts(role, values), self.pieces[0].right.shape
        square = _weighted([(c, piece.square) for c, piece in parts], self.pieces[0].square.shape)
        left = right = _weighted([(c, piece.right) for c, piece in parts if piece.symmetric], shape)
        one_sided = [(c, piece) for c, piece in parts if not piece.symmetric]
        if one_sided:
            left = right + _weighted([(c, piece.left) for c, piece in one_sided], shape)
            right = right + _weighted([(c, piece.right) for c, piece in one_sided], shape)
        return Residuals(square, right, left, sum(abs(c) * piece.lost for c, piece in parts))


def _weighted(parts: list[tuple[float, Floats]], shape: tuple[int, ...]) -> Floats:
    """Sum of factors times matrices of one shape."""
    total = np.zeros(shape)
    for factor, matrix in parts:
        total += factor * matrix
    return total


@dataclass(frozen=True)
class ModelLine:
    """Spectra of a reduced model along a line, a :class:`cea.reduced.thresholds.Line`.

    ``parameters`` gives those at a value of the line, which change at ``rates``; modes that grow by
    more than ``level`` (1/s) count; places on the line may be logarithms of values; spectra that
    are known serve again.
    """

    small: SmallPencil
    parameters: Callable[[float], Values]
    rates: Mapping[str, float]
    level: float = 0.0
    logarithmic: bool = False
    known: dict[float, ReducedSpectrum] = field(default_factory=dict)

    @property
    def window(self) -> Window:
        """What is looked at."""
        settings = self.small.settings
        return Window(settings.end, settings.damped, self.level, settings.decay)

    def place(self, value: float) -> float:
        """Where a value is on the line."""
        return float(np.log(value)) if self.logarithmic else value

    def value(self, place: float) -> float:
        """The value at a place."""
        return float(np.exp(place)) if self.logarithmic else place

    def speed(self, place: float) -> float:
        """Derivative of the value in the place."""
        return self.value(place) if self.logarithmic else 1.0

    def at(self, value: float) -> Sample:
        """The spectrum at a place."""
        at = self.parameters(self.value(value))
        found = self.known.get(value) or self.small.at(at)
        slopes = self.small.slopes(found, at, self.rates) * self.speed(value)
        vectors = found.shapes / np.linalg.norm(found.shapes, axis=0)
        bounds = found.errors, found.means, found.clusters
        sample = Sample(value, found.z, slopes, *bounds, vectors)
        return sample.with_mirror_image() if self.small.settings.damped else sample
