"""A pencil on a basis, in small matrices alone: what is solved at any parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.left_vectors import POWERS
from cea.eigen.parameters import Dependence
from cea.eigen.pencil import Role
from cea.reduced.certificate import Residuals, Rounding
from cea.reduced.following import Sample, Window
from cea.reduced.pieces import Values
from cea.reduced.products import real_times
from cea.reduced.saddle import Saddle, SmallContact, padded
from cea.reduced.spectrum import ReducedSpectrum, Settings, reduced_spectrum


@dataclass(frozen=True)
class SmallPiece:
    """One piece of a pencil on a basis V, with X^-1-coordinates Q of its images.

    V^T A V; Q^T A V and Q^T A^T V, the same object where A is symmetric; norm of what Q does not
    hold of either.
    """

    role: Role
    coefficient: Dependence
    square: Floats
    right: Floats
    left: Floats
    lost: float

    @property
    def symmetric(self) -> bool:
        """Whether A is symmetric."""
        return self.left is self.right

    def padded(self, rows: int) -> "SmallPiece":
        """With zeros for vectors of Q that came later."""
        right = padded(self.right, rows)
        return replace(self, right=right, left=right if self.symmetric else padded(self.left, rows))


@dataclass(frozen=True)
class SmallPencil:
    """All pieces on one basis, with contacts whose forces are unknowns.

    Bounds are made with ``settings``; full solves have errors of ``rounding``, for eigenvalues of
    condition one (1/s^2).
    """

    pieces: tuple[SmallPiece, ...]
    contacts: tuple[SmallContact, ...]
    settings: Settings
    rounding: float = 0.0

    @property
    def size(self) -> int:
        """Vectors of the basis."""
        return len(self.pieces[0].square)

    def at(self, values: Values) -> ReducedSpectrum:
        """Eigenvalues of the window and its margin at values of all parameters."""
        if not self.size:
            return ReducedSpectrum.empty(self.settings)
        K, M = (self._sum(role, values) for role in ("stiffness", "mass"))
        D = self._sum("damping", values) if self.settings.damped else None
        saddle = Saddle.at(self.contacts, values) if self.contacts else None
        return reduced_spectrum(K, D, M, self.settings, self._rounding(values, saddle), saddle)

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
        x, y = found.right, found.left.conj()
        eigenvalues, damped = found.eigenvalues, self.settings.damped
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
            projected = np.einsum("ij,ij->j", y, real_times(piece.square, x))
            if damped or piece.role == "stiffness":
                change += slope * eigenvalues ** POWERS[piece.role] * projected
            else:
                change -= slope * found.z * projected
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

    def _rounding(self, values: Values, saddle: Saddle | None) -> Rounding:
        """What rounding does to eigenvalues."""
        entries: dict[Role, Floats] = {}
        for role in POWERS:
            parts = [
                (abs(piece.coefficient.at(values)), np.abs(piece.square))
                for piece in self.pieces
                if piece.role == role
            ]
            entries[role] = _weighted(parts, (self.size, self.size))
        if saddle is not None:
            entries = {
                role: saddle.rounded(each) if role == "stiffness" else saddle.padded(each)
                for role, each in entries.items()
            }
        return Rounding(self.rounding, entries)

    def _sum(self, role: Role, values: Values) -> Residuals:
        parts = [
            (factor, piece)
            for piece in self.pieces
            if piece.role == role and (factor := piece.coefficient.at(values))
        ]
        shape = self.pieces[0].right.shape
        square = _weighted([(c, piece.square) for c, piece in parts], (self.size, self.size))
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
        vectors = found.right / np.linalg.norm(found.right, axis=0)
        bounds = found.errors, found.means, found.clusters
        sample = Sample(value, found.z, slopes, *bounds, vectors)
        return sample.with_mirror_image() if self.small.settings.damped else sample
