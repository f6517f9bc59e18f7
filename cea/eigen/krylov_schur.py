"""Block Krylov-Schur method: eigenvalues near a shift from a block of start vectors.

With an operator OP whose eigenvalues theta are largest near a shift, and locked vectors Q,

    OP [Q V] = [Q V] [ T  C ]
                     [ 0  H ] + residual,

so that Q and V together span an invariant subspace, with friction or without (Stewart, A
Krylov-Schur algorithm for large eigenproblems, SIAM J. Matrix Anal. Appl. 23 (2002)). Before the
search ends it verifies that no eigenvalue is missing: random vectors, orthogonalised against the
whole basis, are appended to the last block, and the iteration continues for some steps. They reveal
eigenvalues that the start block missed, above all those of higher multiplicity. If the disc then
holds more Ritz values, new random vectors are appended.
"""

import sys
from contextlib import closing
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import combined
from cea.eigen.krylov_space import KrylovSpace
from cea.eigen.mumps import SingularError
from cea.eigen.shift_invert import ShiftInvert
from cea.eigen.subspace import (
    InvariantSubspace,
    Radius,
    dense_subspace,
    leading_schur_form,
    small_eigenpairs,
)
from cea.errors import ConvergenceError

_POWERS = 3
"""Number of times that OP is applied to the start block. It costs less than a further block, and
removes the components of infinite and distant eigenvalues."""
_TINY = 1e-20
"""Lower bound of squared norms of start vectors, relative to the largest; smaller ones are
rounding."""
_CLEAR = 3.0
"""Least distance of a Ritz value outside from the boundary, in multiples of its residual."""
_NEAR_SHIFT = 1e-6
"""Relative distance of an eigenvalue from the shift below which all others lose digits."""
_PAIR = 1e-9
"""Relative difference of moduli up to which eigenvalues are not separated: conjugate pairs."""


@dataclass(frozen=True)
class KrylovOptions:
    """Options of the block Krylov-Schur method and of the search of a window."""

    block: int = 8  # columns of a block
    tolerance: float = 1e-13  # residual relative to theta of converged eigenvalues of the window
    # the same for guard eigenvalues of a disc, and for appending random vectors
    loose: float = 1e-6
    # random vectors appended to verify that nothing is missing, and least block steps with them
    random_columns: int = 4
    random_steps: int = 4
    first_check: int = 6  # blocks of a Krylov space at the first convergence test
    growth: float = 1.1  # factor on the size of the space between two convergence tests
    restart: float = 3.5  # size of the space at a restart, relative to the Ritz values in the disc
    max_restarts: int = 200  # largest number of restarts
    max_discs: int = 3  # largest number of discs beyond the first
    dense_limit: int = 1000  # largest number of rows of an operator that LAPACK solves


class CrowdedError(ConvergenceError):
    """A disc holds more eigenvalues than allowed."""


def krylov_schur(
    op: ShiftInvert,
    radius: float | Radius,
    options: KrylovOptions,
    locked: InvariantSubspace | None = None,
    *,
    seed: int = 0,
    most: int = sys.maxsize,
) -> InvariantSubspace:
    """Return the locked subspace extended by the eigenvalues of a disc about the shift; collective.

    For small systems LAPACK computes all eigenvalues, and the result holds the whole window. The
    radius is a number, or a function of the Ritz values. The locked subspace of the same pencil
    may have been computed at any shift. For a radius given as a number the search verifies that
    no eigenvalue is missing.

    Raises
    ------
    ConvergenceError
        When eigenvalues of the disc do not converge; the invariant subspace so far is attached.
        CrowdedError when the disc holds more than ``most`` eigenvalues, SingularError when one is
        next to the shift.
    """
    verified = callable(radius)
    radius_of = partial(radius, op.shift) if callable(radius) else lambda _: radius
    locked = locked or InvariantSubspace.empty(op.local, symmetric=op.symmetric)
    near = f"{op.shift:.6g} is next to an eigenvalue"
    if op.rows <= options.dense_limit:
        if locked.size:
            return locked
        found = dense_subspace(op, radius_of, disc_only=verified or np.isinf(op.reach))
        distances = np.abs(found.eigenvalues - op.shift)
        if distances.min(initial=np.inf) < _NEAR_SHIFT * abs(op.shift):
            raise SingularError(near)
        return found
    if locked.size >= op.finite:
        return locked
    random, block = np.random.default_rng([seed, op.rank]), options.block
    with closing(_started(op, locked, block, random)) as space:
        check, restarts = options.first_check * block, 0
        counted, last_random = 0, 0  # last_random: size of the space that ends the verification

        def append_random() -> bool:
            room = op.rows - locked.size - space.size - space.next
            if (columns := min(options.random_columns, room)) > 0:
                space.append_random(_random_block(op, random, columns))
            return bool(space.next)

        while True:
            if space.size < check and space.next:
                space.extend()
                continue
            theta, vectors = small_eigenpairs(space.square, symmetric=op.symmetric)
            residuals = np.linalg.norm(space.operator[space.size :] @ vectors, axis=0)
            sizes, least = np.abs(theta), 1 / radius_of(theta)
            inside, converged = sizes >= least, residuals <= options.tolerance * sizes
            nearly = residuals <= options.loose * sizes
            if (nearly & (_NEAR_SHIFT * abs(op.shift) * sizes > 1)).any():
                raise SingularError(near)
            number = int(inside.sum())
            if last_random and (space.size >= last_random or not space.next):
                verified, last_random = verified or number <= counted, 0
            if not space.next:  # the space is invariant: the start vectors yield nothing more
                counted, check = number, space.size + options.random_steps * block
                if verified or not append_random():
                    finite = sizes * abs(op.shift) > op.negligible
                    return _locked(op, space, locked, theta, inside & finite)
                last_random = check
                continue
            if number > most:
                raise CrowdedError(f"a disc holds at least {number} eigenvalues")
            wanted = _wanted(op, theta, inside)
            seen = converged | ~wanted & _outside(op, theta, residuals, nearly)
            if verified and seen[inside].all() and _clear(sizes, residuals, inside, least):
                return _locked(op, space, locked, theta, converged)
            if space.size >= max(12 * block, options.restart * number + 6 * block):
                if restarts == options.max_restarts:
                    raise ConvergenceError(
                        f"{int((inside & ~converged).sum())} eigenvalues in the disc of radius "
                        f"{1 / least:.4g} about {op.shift:.4g} did not converge",
                        best=_locked(op, space, locked, theta, converged),
                    )
                restarts, full = restarts + 1, space.size
                space.restart(*_leading(space.square, theta, number + 3 * block))
                last_random -= (full - space.size) if last_random else 0
            check = max(space.size + space.next, int(options.growth * space.size))
            if nearly[wanted].all() and not (verified or last_random):
                counted = number
                append_random()
                last_random = check = space.size + options.random_steps * space.next
            elif last_random:
                check = min(check, last_random)


def _random_block(op: ShiftInvert, random: np.random.Generator, columns: int) -> Floats:
    """Return a block of random vectors in Fortran order."""
    return np.asfortranarray(random.standard_normal((op.local, columns)))


def _started(
    op: ShiftInvert, locked: InvariantSubspace, columns: int, random: np.random.Generator
) -> KrylovSpace:
    """Return a Krylov space started from powers of OP on random vectors.

    The powers remove the components of infinite eigenvalues.
    """
    space = KrylovSpace(op, locked.basis, op.rows - locked.size)
    start = _random_block(op, random, columns)
    for _ in range(_POWERS):
        image = op.image(start)  # for orthonormal vectors, so that none dominates
        squares, axes = np.linalg.eigh(op.inner(start, image))
        turn = axes / np.sqrt(np.maximum(squares, _TINY * squares.max()))
        start = op.apply(combined(start, turn), combined(image, turn))
    space.start(start)
    return space


def _wanted(op: ShiftInvert, theta: Complexes, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which Ritz values must converge: those of the window, and all nearer to the shift."""
    window = inside & ~op.outside(theta, np.zeros(len(theta)))
    farthest = np.abs(theta[window]).min(initial=np.inf)
    return inside & (np.abs(theta) >= (1 - _PAIR) * farthest)


def _outside(
    op: ShiftInvert, theta: Complexes, residuals: Floats, nearly: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which nearly converged Ritz values lie outside the window by more than their error."""
    outside = nearly.copy()
    errors = _CLEAR * residuals[nearly] / np.abs(theta[nearly]) ** 2
    outside[nearly] = op.outside(theta[nearly], errors)
    return outside


def _clear(sizes: Floats, residuals: Floats, inside: NDArray[np.bool_], least: float) -> bool:
    """Whether the largest Ritz value outside the disc is outside by more than its error."""
    if inside.all():
        return False
    outer = np.where(inside, 0.0, sizes)
    first = int(np.argmax(outer))
    return bool(_CLEAR * residuals[first] <= least - outer[first])


def _leading(square: Floats, theta: Complexes, number: int) -> tuple[Floats, Floats]:
    """Return the Schur form and vectors of the eigenvalues of largest modulus; no pair is split."""
    sizes = np.sort(np.abs(theta))[::-1]
    while 0 < number < len(sizes) and sizes[number] > (1 - _PAIR) * sizes[number - 1]:
        number += 1
    cut = 0.5 * (sizes[number - 1] + sizes[number]) if number < len(sizes) else 0.0
    return leading_schur_form(square, lambda theta: np.abs(theta) >= cut)


def _locked(
    op: ShiftInvert,
    space: KrylovSpace,
    locked: InvariantSubspace,
    theta: Complexes,
    converged: NDArray[np.bool_],
) -> InvariantSubspace:
    """Return the locked subspace extended by the leading converged eigenvalues."""
    order = np.argsort(-np.abs(theta))
    number = len(order) if converged.all() else int(np.argmin(converged[order]))
    if 0 < number < len(order):
        last, beyond = theta[order[number - 1]], theta[order[number]]
        split = last.imag != 0 and np.isclose(last.conj(), beyond, rtol=_PAIR, atol=0.0)
        number -= int(split)
    if not number:
        return locked
    form, vectors = _leading(space.square, theta, number)
    return locked.extended(space.combined(vectors), space.coupling @ vectors, form, op.shift)
