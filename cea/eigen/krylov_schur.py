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
"""Times that OP is applied to the start block: it costs less than a further block, and takes
infinite eigenvalues and those far away out of all that follow."""
_TINY = 1e-20
"""Square of a direction of start vectors, relative to the largest, from which on it is rounding."""
_CLEAR = 3.0
"""Residuals by which an eigenvalue outside a disc must lie outside."""
_NEAR_SHIFT = 1e-6
"""Distance of an eigenvalue from the shift, relative to it, at which all others lose digits."""
_PAIR = 1e-9
"""Relative distance of moduli up to which eigenvalues stay together, as conjugate ones must."""


@dataclass(frozen=True)
class KrylovOptions:
    """Options of the block Krylov-Schur method and of the search of a window."""

    block: int = 8  # columns of a block
    tolerance: float = 1e-13  # residual relative to theta below which what is wanted has converged
    # the same of eigenvalues in a disc that are not wanted, and where random vectors are appended
    loose: float = 1e-6
    # random vectors appended to verify that nothing is missing, and least block steps with them
    random_columns: int = 4
    random_steps: int = 4
    first_check: int = 6  # blocks of a Krylov space before its Ritz values are looked at
    growth: float = 1.1  # growth of the space between two Ritz checks
    restart: float = 3.5  # size of the space at a restart, relative to the Ritz values in the disc
    max_restarts: int = 200  # restarts before a search is given up
    max_discs: int = 3  # most discs beyond the first
    dense_limit: int = 1000  # most rows of an operator whose eigenvalues LAPACK computes


class CrowdedError(ConvergenceError):
    """More eigenvalues in a disc than are worth their price."""


def krylov_schur(
    op: ShiftInvert,
    radius: float | Radius,
    options: KrylovOptions,
    locked: InvariantSubspace | None = None,
    *,
    seed: int = 0,
    most: int = sys.maxsize,
) -> InvariantSubspace:
    """What is locked together with the eigenvalues of a disc about the shift; collective.

    Of small systems LAPACK computes all of them, and the result holds all of the window. The radius
    is a number, or follows from the Ritz values; what is locked was found before, at any shift, of
    the same pencil. With ``most`` eigenvalues in the disc it is crowded. Of a given radius it is
    verified that none is missing.

    Raises
    ------
    ConvergenceError
        When eigenvalues of the disc do not converge, with the invariant subspace so far;
        CrowdedError when there are too many, SingularError when one is next to the shift.
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
        counted, last_random = 0, 0  # random vectors take part up to that size

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
            if not space.next:  # invariant: it holds all directions, or all that its vectors see
                counted, check = number, space.size + options.random_steps * block
                if verified or not append_random():
                    finite = sizes * abs(op.shift) > op.negligible
                    return _locked(op, space, locked, theta, inside & finite)
                last_random = check
                continue
            if number > most:
                raise CrowdedError(f"a disc holds {number} eigenvalues or more")
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
    """So many random vectors in Fortran order."""
    return np.asfortranarray(random.standard_normal((op.local, columns)))


def _started(
    op: ShiftInvert, locked: InvariantSubspace, columns: int, random: np.random.Generator
) -> KrylovSpace:
    """A space that begins with powers of OP on random vectors: infinite eigenvalues are gone."""
    space = KrylovSpace(op, locked.basis, op.rows - locked.size)
    start = _random_block(op, random, columns)
    for _ in range(_POWERS):
        image = op.image(start)  # the vectors are made orthonormal: none hides the others
        squares, axes = np.linalg.eigh(op.inner(start, image))
        turn = axes / np.sqrt(np.maximum(squares, _TINY * squares.max()))
        start = op.apply(combined(start, turn), combined(image, turn))
    space.start(start)
    return space


def _wanted(op: ShiftInvert, theta: Complexes, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Eigenvalues of the disc that are to converge: those of the window, and all nearer."""
    window = inside & ~op.outside(theta, np.zeros(len(theta)))
    farthest = np.abs(theta[window]).min(initial=np.inf)
    return inside & (np.abs(theta) >= (1 - _PAIR) * farthest)


def _outside(
    op: ShiftInvert, theta: Complexes, residuals: Floats, nearly: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which of those that have nearly converged are outside of the window, whatever their error."""
    outside = nearly.copy()
    errors = _CLEAR * residuals[nearly] / np.abs(theta[nearly]) ** 2
    outside[nearly] = op.outside(theta[nearly], errors)
    return outside


def _clear(sizes: Floats, residuals: Floats, inside: NDArray[np.bool_], least: float) -> bool:
    """Whether the first eigenvalue outside has converged enough to be outside."""
    if inside.all():
        return False
    outer = np.where(inside, 0.0, sizes)
    first = int(np.argmax(outer))
    return bool(_CLEAR * residuals[first] <= least - outer[first])


def _leading(square: Floats, theta: Complexes, number: int) -> tuple[Floats, Floats]:
    """Schur form of OP on so many eigenvalues of largest modulus; no pair is split."""
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
    """The locked subspace with the leading eigenvalues, as far as they have converged."""
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
