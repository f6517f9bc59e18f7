"""Block Krylov-Schur method: eigenvalues around a shift, from many start vectors at once.

With an operator OP whose eigenvalues theta are largest near a shift, and vectors Q locked before,

    OP [Q V] = [Q V] [ T  C ]
                     [ 0  H ] + residual,

so that Q and V together remain an invariant subspace, friction or not (Stewart, A Krylov-Schur
algorithm for large eigenproblems, SIAM J. Matrix Anal. Appl. 23 (2002)). That none is missing is
verified before the search ends: random vectors are appended to the last block, orthogonalised
against the whole basis, and take part for some steps more. They see what the start block did not,
further copies of multiple eigenvalues above all. Where more Ritz values lie in the disc then, other
random vectors are appended.
"""

import sys

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import combined
from cea.eigen.dense import Radius, dense_subspace
from cea.eigen.krylov_space import KrylovSpace, ShiftInvert
from cea.eigen.options import KrylovOptions
from cea.eigen.subspace import InvariantSubspace, small_eigenpairs, symmetric_part
from cea.errors import ConvergenceError

_POWERS = 3
"""Times that OP is applied to the start block where nothing is locked: it costs less than a further
block, and takes infinite eigenvalues and those far away out of all that follow."""
_TINY = 1e-20
"""Square of a direction of start vectors, relative to the largest, from which on it is rounding."""
_CLEAR = 3.0
"""Residuals by which an eigenvalue outside a disc must lie outside."""
NEAR_SHIFT = 1e-6
"""Distance of an eigenvalue from the shift, relative to it, at which all others lose digits."""
_PAIR = 1e-9
"""Relative distance of moduli up to which eigenvalues stay together, as conjugate ones must."""


class CrowdedError(ConvergenceError):
    """More eigenvalues in a disc than are worth their price.

    Parameters
    ----------
    number
        How many its space knows of.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"a disc holds {number} eigenvalues or more")


class NearShiftError(ConvergenceError):
    """An eigenvalue so near to the shift that others lose digits."""


def krylov_schur(
    op: ShiftInvert,
    radius: float | Radius,
    options: KrylovOptions,
    locked: InvariantSubspace | None = None,
    *,
    seed: int = 0,
    most: int = sys.maxsize,
    verify: bool = True,
) -> InvariantSubspace:
    """What is locked together with the eigenvalues of a disc about the shift; collective.

    Of small systems LAPACK computes all of them, and the result holds all of the window.

    Parameters
    ----------
    op
        OP.
    radius
        Radius of the disc, or how it follows from the Ritz values.
    options
        Options of the method.
    locked
        An invariant subspace found before, at any shift, of the same pencil.
    seed
        Of the random vectors.
    most
        Eigenvalues in the disc from which on it is crowded.
    verify
        Whether it is verified that none is missing.

    Raises
    ------
    ConvergenceError
        When eigenvalues of the disc do not converge; ``best`` is the invariant subspace so far.
    CrowdedError
        When the disc holds more than ``most`` eigenvalues.
    NearShiftError
        When an eigenvalue is next to the shift.
    """
    of_theta = radius if callable(radius) else lambda _: radius
    locked = locked or InvariantSubspace.empty(op.local, symmetric=op.symmetric)
    if op.rows <= options.dense_limit:
        if locked.size:
            return locked
        found = dense_subspace(op, of_theta, disc_only=not (verify and np.isfinite(op.reach)))
        distances = np.abs(found.eigenvalues() - op.shift)
        if distances.min(initial=np.inf) < NEAR_SHIFT * abs(op.shift):
            raise NearShiftError(f"{op.shift:.6g} is next to an eigenvalue")
        return found
    if locked.size >= op.finite:
        return locked
    return _KrylovSchur(op, of_theta, options, locked, seed, most, verify=verify).complete()


class _KrylovSchur:
    """One search; parameters are those of :func:`krylov_schur`."""

    def __init__(
        self,
        op: ShiftInvert,
        radius: Radius,
        options: KrylovOptions,
        locked: InvariantSubspace,
        seed: int,
        most: int,
        *,
        verify: bool,
    ) -> None:
        self._op, self._radius, self._options = op, radius, options
        self._locked, self._most, self._verify = locked, most, verify
        self._random = np.random.default_rng([seed, op.rank])
        self._space = KrylovSpace(op, locked.basis, op.rows - locked.size)
        self._worst: tuple[int, int, float] | None = None
        self._steps_left: int | None = None
        start = self._random_block(options.block)
        for _ in range(op.powers if locked.size else _POWERS):
            start = self._applied(start)
        self._space.start(start)

    def _random_block(self, columns: int) -> Floats:
        """So many random vectors, others each time, in Fortran order."""
        return np.asfortranarray(self._random.standard_normal((self._op.local, columns)))

    def _applied(self, block: Floats) -> Floats:
        """OP on a block of the same span, its vectors orthonormal: none hides the others."""
        image = self._op.image(block)
        squares, axes = np.linalg.eigh(self._op.inner(block, image))
        turn = axes / np.sqrt(np.maximum(squares, _TINY * squares.max()))
        return self._op.apply(combined(block, turn), combined(image, turn))

    def complete(self) -> InvariantSubspace:
        """The locked subspace with all that is wanted of the disc."""
        options, restarts = self._options, 0
        check, verified, counted = options.first_check * options.block, not self._verify, 0
        while True:
            size = self._space.size
            exhausted = not self._space.next
            if size < check and not exhausted:
                self._space.extend()
                continue
            theta, residuals = self._ritz()
            sizes, least = np.abs(theta), 1 / self._radius(theta)
            inside = sizes >= least
            converged = residuals <= options.tolerance * sizes
            nearly = residuals <= options.loose * sizes
            if (nearly & (NEAR_SHIFT * abs(self._op.shift) * sizes > 1)).any():
                raise NearShiftError(f"{self._op.shift:.6g} is next to an eigenvalue")
            if exhausted:
                return self._lock(
                    theta, inside & (sizes * abs(self._op.shift) > self._op.negligible)
                )
            number = int(inside.sum())
            if number > self._most:
                raise CrowdedError(number)
            wanted = self._wanted(theta, inside)
            loose = bool(nearly[wanted].all())
            if self._steps_left is not None and size >= self._steps_left:
                verified, self._steps_left = verified or number <= counted, None
            seen = converged | ~wanted & self._surely_outside(theta, residuals)
            ends = bool(seen[inside].all()) and self._clear(sizes, residuals, inside, least)
            if ends and verified:
                return self._lock(theta, converged)
            if size >= max(12 * options.block, options.restart * number + 6 * options.block):
                if restarts == options.max_restarts:
                    missing = int((inside & ~converged).sum())
                    raise ConvergenceError(
                        f"{missing} eigenvalues in the disc of radius {1 / least:.4g} about "
                        f"{self._op.shift:.4g} did not converge",
                        best=self._lock(theta, converged),
                    )
                restarts += 1
                before = size
                self._space.restart(*self._leading(theta, number + 3 * options.block))
                self._worst = None
                if self._steps_left is not None:
                    self._steps_left -= before - self._space.size
            check = self._next_check(theta, residuals, wanted)
            if loose and not verified and self._steps_left is None:
                counted = number
                self._append_random()
                self._steps_left = self._space.size + options.random_steps * self._space.next
                check = self._steps_left
            elif self._steps_left is not None:
                check = min(check, self._steps_left)

    def _append_random(self) -> None:
        """Append random vectors to the next block, orthogonal to the whole space."""
        room = self._op.rows - self._locked.size - self._space.size - self._space.next
        columns = min(self._options.random_columns, room)
        if columns > 0:
            self._space.append_random(self._random_block(columns))
            self._worst = None

    def _wanted(self, theta: Complexes, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Eigenvalues of the disc that are to converge: those of the window, and all nearer."""
        window = inside & ~self._op.outside(theta, np.zeros(len(theta)))
        farthest = np.abs(theta[window]).min(initial=np.inf)
        return inside & (np.abs(theta) >= (1 - _PAIR) * farthest)

    def _surely_outside(self, theta: Complexes, residuals: Floats) -> NDArray[np.bool_]:
        """Which have nearly converged where nothing is wanted."""
        sizes = np.maximum(np.abs(theta), np.finfo(float).tiny)
        nearly = residuals <= self._options.loose * sizes
        errors = _CLEAR * residuals[nearly] / sizes[nearly] ** 2
        nearly[nearly] = self._op.outside(theta[nearly], errors)
        return nearly

    def _square(self) -> Floats:
        square = self._space.square
        return symmetric_part(square) if self._op.symmetric else square

    def _ritz(self) -> tuple[Complexes, Floats]:
        """Ritz values of OP on the space and the residuals of their vectors."""
        theta, vectors = small_eigenpairs(self._square(), symmetric=self._op.symmetric)
        rest = self._space.operator[self._space.size :]
        return theta, np.linalg.norm(rest @ vectors, axis=0)

    def _clear(
        self, sizes: Floats, residuals: Floats, inside: NDArray[np.bool_], least: float
    ) -> bool:
        """Whether the first eigenvalue outside has converged enough to be outside."""
        if inside.all():
            return False
        outer = np.where(inside, 0.0, sizes)
        first = int(np.argmax(outer))
        return bool(_CLEAR * residuals[first] <= least - outer[first])

    def _next_check(self, theta: Complexes, residuals: Floats, wanted: NDArray[np.bool_]) -> int:
        """Size of the space at the next Ritz check.

        The worst residual of what is wanted falls the faster the larger the space: where it fell
        since the last check, its rate says when it will have converged, or a little earlier.
        """
        size, number = self._space.size, int(wanted.sum())
        relative = residuals[wanted] / (self._options.tolerance * np.abs(theta[wanted]))
        worst = float(np.log(max(relative.max(initial=0.0), 1.0)))
        before, self._worst = self._worst, (size, number, worst)
        most = int(self._options.growth * size)
        if before and before[1] == number and worst < before[2] and size > before[0]:
            rate = (before[2] - worst) / (size - before[0])
            most = min(most, size + int(worst / rate) // self._space.next * self._space.next)
        return max(size + self._space.next, most)

    def _leading(self, theta: Complexes, number: int) -> tuple[Floats, Floats]:
        """Schur form of OP on so many eigenvalues of largest modulus; no pair is split."""
        sizes = np.sort(np.abs(theta))[::-1]
        while 0 < number < len(sizes) and sizes[number] > (1 - _PAIR) * sizes[number - 1]:
            number += 1
        if number >= len(sizes):
            form, vectors = schur(self._square(), output="real")
            return form, vectors
        cut = 0.5 * (sizes[number - 1] + sizes[number])
        form, vectors, kept = schur(
            self._square(),
            output="real",
            sort=lambda re, im=0.0: bool(np.hypot(re, im) >= cut),
        )
        return form[:kept, :kept], vectors[:, :kept]

    def _lock(self, theta: Complexes, converged: NDArray[np.bool_]) -> InvariantSubspace:
        """The locked subspace with the leading eigenvalues, as far as they have converged."""
        order = np.argsort(-np.abs(theta))
        number = len(order) if converged.all() else int(np.argmin(converged[order]))
        if 0 < number < len(order):
            last, beyond = theta[order[number - 1]], theta[order[number]]
            split = last.imag != 0 and np.isclose(last.conj(), beyond, rtol=_PAIR, atol=0.0)
            number -= int(split)
        if not number:
            return self._locked
        form, vectors = self._leading(theta, number)
        coupling = self._space.coupling @ vectors
        basis = self._space.combined(vectors)
        return self._locked.extended(basis, coupling, form, self._op.shift)
