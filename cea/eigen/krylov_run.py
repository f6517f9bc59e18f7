"""One search of a block Krylov-Schur method: when it looks at its space, restarts it, and locks."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur

from cea.arrays import Complexes, Floats
from cea.eigen.dense_products import combined
from cea.eigen.krylov_space import InnerProduct, KrylovSpace
from cea.eigen.slices import Plan
from cea.eigen.subspace import InvariantSubspace, small_eigenpairs, symmetric_part
from cea.eigen.surroundings import PAIR, leading, with_more
from cea.errors import ConvergenceError

_BLOCK = 8
"""Columns of a block."""
_CLEANSED = 3
"""Times that OP is applied to start vectors where nothing is known: without a projection it costs
less than a further block, and takes what is far away out of all that follow."""
_TINY = 1e-20
"""Square of a direction of start vectors, relative to the largest, from which on it is rounding."""
_LEAST, _LEAST_AROUND = 6, 4
"""Blocks of a space before it is looked at: an eigenvalue must have had time to show. It has so
sooner where those around the disc are taken out."""
_GROWTH = 1.3
"""Most growth of the Krylov space between two looks at its eigenvalues."""
_RESTART = 3.5
"""Size of the space, relative to the eigenvalues wanted of it, at which it is restarted."""
_CROWDED = 0.6
"""Eigenvalues in a disc relative to the columns of the space from which on they are far more."""
_AROUND = 0.1
"""Part of 1 / radius to which eigenvalues around a disc are kept: those farther lose digits."""
_CLEAR = 3.0
"""Residuals by which an eigenvalue outside a disc must lie outside."""
_FRESH = 4
"""Fresh columns beside the last blocks: the whole space is taken out of them, so that few see as
much as a block that starts beside eigenvalues alone."""
_LAST = 6
"""Most steps to the end of a search, as foreseen, from which on fresh vectors take part."""
_NEARLY = 1e-6
"""Residual relative to theta up to which an eigenvalue around a disc need not be seen again."""

type Outside = Callable[[Complexes, Floats], NDArray[np.bool_]]
"""Which kappa lie outside of what is wanted, by so much as they may be in error, shape (n,)."""


class CrowdedError(ConvergenceError):
    """More eigenvalues in a disc than are worth their price.

    Parameters
    ----------
    number
        How many its space knows of.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"a disc holds {number} eigenvalues or more")


class ShiftInvert(InnerProduct, Protocol):
    """An operator OP with eigenvalues theta = 1 / (kappa - sigma), and its inner product.

    Attributes
    ----------
    size, finite
        Rows of its vectors on all ranks, and number of its eigenvalues that are not zero.
    shift
        sigma.
    comm
        Communicator (mpi4py).
    unknown
        What the eigenvalues kappa are called.
    cleansing
        Times that it is applied to take what is infinite out of a vector.
    tolerance
        Residual relative to theta below which an eigenvalue has converged.
    max_restarts
        Restarts before a search is given up.
    most
        Eigenvalues beside the known in a disc at which it is called crowded.
    plan
        When a search ends with the eigenvalues nearest to the shift, for its disc holds far more.
    """

    size: int
    finite: int
    shift: complex
    comm: Any
    unknown: str
    cleansing: int
    tolerance: float
    max_restarts: int
    most: int
    plan: Plan


class KrylovRun:
    """One search: its Krylov space V beside what is known, with OP on it.

    Parameters
    ----------
    owner
        OP, and what is asked of a search.
    known
        Q.
    radius
        Radius of the disc about the shift.
    seed
        Of the random start vectors.
    both_ends
        Whether the far end of the spectrum is to be seen too.
    surrounded
        Whether what is known holds the eigenvalues around the disc too, as ``around`` does.
    outside
        What of the disc is not wanted: it has to be seen there, but not to converge. None where
        all of the disc is wanted.
    fresh
        Whether other random vectors take part in the last steps, beside all that was found before.

    Attributes
    ----------
    confirmed
        Whether they did, for as many steps as would have shown that something is missing.
    farthest
        Largest modulus of an eigenvalue that the space knows of; infinite where it does not see the
        far end of the spectrum.
    reached
        Radius of the disc that the search ended with; None where it is that asked for.
    around
        What was found with eigenvalues around the disc that have nearly converged; None where
        there are none. It is no result, but a further search beside it sees sooner what is missing.
    """

    def __init__(
        self,
        owner: ShiftInvert,
        known: InvariantSubspace,
        radius: float,
        seed: int,
        *,
        both_ends: bool,
        surrounded: bool = False,
        outside: Outside | None = None,
        fresh: bool = False,
    ) -> None:
        self._owner, self._known, self._outside = owner, known, outside
        self._fresh, self._steps_beside = fresh, -1
        self._least = 1.0 / radius
        self._both_ends = both_ends
        self._first_look = (_LEAST_AROUND if surrounded else _LEAST) * _BLOCK
        self.farthest = np.inf
        self.reached: float | None = None
        self.around: InvariantSubspace | None = None
        self._shift = owner.shift
        self._room = owner.size - known.size
        self._finite = owner.finite - known.size
        self._worst: tuple[int, int, float] | None = None
        self._space = KrylovSpace(owner, known.basis, self._room)
        if self._finite > 0:
            columns = min(_BLOCK, self._room)
            self._random = np.random.default_rng([seed, owner.comm.rank])
            start = self._random_block(columns)
            # OP takes what is far away out of a vector, ties above all.
            far = both_ends and owner.finite == owner.size
            once = known.size or both_ends or columns == self._room
            times = owner.cleansing if once else _CLEANSED
            for _ in range(0 if far else times):
                start = self._applied(start)
            self._space.start(start)

    def _random_block(self, columns: int) -> NDArray[Any]:
        """So many random vectors, others each time, in Fortran order."""
        size = (len(self._known.basis), columns)
        block: NDArray[Any] = self._random.standard_normal(size).astype(self._owner.dtype)
        if self._owner.dtype is complex:
            block += 1j * self._random.standard_normal(size)
        return np.asfortranarray(block)

    @property
    def confirmed(self) -> bool:
        """Whether fresh vectors took part for long enough in the search of all of the disc."""
        return self._steps_beside >= _LEAST_AROUND and self.reached is None

    def _applied(self, block: NDArray[Any]) -> NDArray[Any]:
        """OP on a block of the same span, its vectors orthonormal: none hides the others."""
        owner = self._owner
        image = owner.image(block)
        squares, axes = np.linalg.eigh(owner.inner(block, image))
        turn = axes / np.sqrt(np.maximum(squares, _TINY * squares.max()))
        return owner.apply(combined(block, turn), combined(image, turn))

    def complete(self) -> InvariantSubspace:
        """The known with all that is in the disc."""
        restarts, look = 0, self._first_look
        while self._finite > 0:
            size = self._space.size
            exhausted = not self._space.next or size >= self._room
            if size < look and not exhausted:
                self._space.extend()
                self._steps_beside += self._steps_beside >= 0
                continue
            theta, residuals = self._ritz()
            inside = np.abs(theta) >= self._least
            near = inside if self._both_ends else np.abs(theta) >= _AROUND * self._least
            converged = residuals <= self._owner.tolerance * np.abs(theta)
            if exhausted:  # ties have infinite eigenvalues, theta = 0 but for rounding
                converged = self._largest(theta)
                self.farthest = self._far_end(theta[converged], 0 * residuals[converged])
                return self._locked(theta, converged & near)
            wanted = self._sought(theta, inside)
            seen = converged | ~wanted & self._surely_outside(theta, residuals)
            ends = seen[inside].all() and self._clear(theta, residuals, inside)
            if ends and self.confirmed:
                return self._locked(theta, converged & near)
            if ends and self._steps_beside < 0:
                self.farthest = self._far_end(theta, residuals)
                return self._locked_with_more(theta, converged & near, residuals)
            number = int(inside.sum())
            if number > self._owner.most:
                raise CrowdedError(number)
            plan = self._owner.plan
            if size >= plan.columns and number > _CROWDED * size:
                known = self._nearest_ones(theta, residuals, converged)
                if known is not None:
                    return known
            if size >= max(12 * _BLOCK, _RESTART * number + 6 * _BLOCK):
                if restarts == self._owner.max_restarts:
                    where = f"{self._owner.unknown} = {self._shift:.4g}"
                    raise ConvergenceError(
                        f"{int((inside & ~converged).sum())} eigenvalues in the disc of radius "
                        f"{1 / self._least:.4g} about {where} did not converge",
                        best=self._locked(theta, converged),
                    )
                restarts += 1
                self._space.restart(*self._leading(theta, number + 3 * _BLOCK))
                self._worst = None
            look = self._next_look(theta, residuals, wanted)
            if ends:
                look = size + self._space.next * (_LEAST_AROUND - self._steps_beside)
            elif self._fresh and self._steps_beside < 0 and self._soon(look):
                look = self._with_fresh_ones(look)
                continue
            if size < plan.columns < look:
                look = plan.columns
        return self._known

    def _sought(self, theta: Complexes, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Eigenvalues of the disc that are to converge: none lies farther than all not outside."""
        if self._outside is None or not inside.any():
            return inside
        within = inside & ~self._outside(self._shift + 1 / theta, np.zeros(len(theta)))
        farthest = np.abs(theta[within]).min(initial=np.inf)
        return inside & (np.abs(theta) >= (1 - PAIR) * farthest)

    def _surely_outside(self, theta: Complexes, residuals: Floats) -> NDArray[np.bool_]:
        """Which have nearly converged where nothing is wanted."""
        sizes = np.maximum(np.abs(theta), np.finfo(float).tiny)
        nearly = residuals <= _NEARLY * sizes
        if self._outside is None or not nearly.any():
            return np.zeros(len(theta), dtype=bool)
        errors = _CLEAR * residuals[nearly] / sizes[nearly] ** 2
        nearly[nearly] = self._outside(self._shift + 1 / theta[nearly], errors)
        return nearly

    def _nearest_ones(
        self, theta: Complexes, residuals: Floats, converged: NDArray[np.bool_]
    ) -> InvariantSubspace | None:
        """The known with what has converged about the shift; None where slices are not worth it."""
        order = np.argsort(-np.abs(theta))
        number = int(np.argmin(converged[order]))
        first = order[number]
        reached = float(1 / (np.abs(theta[first]) + _CLEAR * residuals[first]))
        inside = converged & (np.abs(theta) * reached > 1)
        if inside.sum() <= self._owner.plan.many * self._least * reached:
            return None
        self.reached = reached
        return self._locked(theta, inside)

    def _square(self) -> NDArray[Any]:
        square = self._space.square
        return symmetric_part(square) if self._known.symmetric else square

    def _ritz(self) -> tuple[Complexes, Floats]:
        """Eigenvalues of OP on the space and the residuals of their vectors."""
        theta, vectors = small_eigenpairs(self._square(), symmetric=self._known.symmetric)
        rest = self._space.operator[self._space.size :]
        return theta, np.linalg.norm(rest @ vectors, axis=0)

    def _next_look(self, theta: Complexes, residuals: Floats, inside: NDArray[np.bool_]) -> int:
        """Size of the space at which it is worth looking again.

        The worst residual of what is wanted falls the faster the larger the space: where it fell
        since the last look, its rate says when it will have converged, or a little earlier.
        """
        size, wanted = self._space.size, int(inside.sum())
        relative = residuals[inside] / (self._owner.tolerance * np.abs(theta[inside]))
        worst = float(np.log(max(relative.max(initial=0.0), 1.0)))
        before, self._worst = self._worst, (size, wanted, worst)
        most = int(_GROWTH * size)
        if before is not None and before[1] == wanted and worst < before[2]:
            rate = (before[2] - worst) / (size - before[0])
            most = min(most, size + int(worst / rate) // self._space.next * self._space.next)
        return max(size + self._space.next, most)

    def _soon(self, look: int) -> bool:
        """Whether a next look is foreseen to be the last, and near."""
        size = self._space.size
        return look < int(_GROWTH * size) and look - size <= _LAST * self._space.next

    def _with_fresh_ones(self, look: int) -> int:
        """Let fresh random vectors take part in the last steps; the size of the space then."""
        while look - self._space.size > _LEAST_AROUND * self._space.next > 0:
            self._space.extend()
        columns = min(_FRESH, self._room - self._space.size - self._space.next)
        if not self._space.next or columns <= 0:  # hardly any directions are left
            return look
        self._space.join(self._random_block(columns))
        self._steps_beside, self._worst = 0, None
        return self._space.size + _LEAST_AROUND * self._space.next

    def _clear(self, theta: Complexes, residuals: Floats, inside: NDArray[np.bool_]) -> bool:
        """Whether the first eigenvalue outside has converged enough to be outside."""
        if inside.all():
            return False
        sizes = np.where(inside, 0.0, np.abs(theta))
        first = int(np.argmax(sizes))
        return bool(_CLEAR * residuals[first] <= self._least - sizes[first])

    def _far_end(self, theta: Complexes, residuals: Floats) -> float:
        """Largest abs(kappa), by kappa / (kappa - sigma) = 1 + sigma theta.

        As theta itself for eigenvalues near the shift, this is largest for those far from it, and
        the same space finds both ends.
        """
        parts = np.abs(1 + self._shift * theta) + _CLEAR * np.abs(self._shift) * residuals
        part = float(parts.max(initial=0.0))
        return part / (1 - part) * abs(self._shift) if part < 1 else np.inf

    def _leading(self, theta: Complexes, number: int) -> tuple[NDArray[Any], NDArray[Any]]:
        """Schur form of OP on so many eigenvalues of largest modulus; no pair is split."""
        sizes = np.sort(np.abs(theta))[::-1]
        while 0 < number < len(sizes) and sizes[number] > (1 - PAIR) * sizes[number - 1]:
            number += 1
        output: Any = "complex" if self._owner.dtype is complex else "real"
        if number >= len(sizes):
            form, vectors = schur(self._square(), output=output)
            return form, vectors
        cut = 0.5 * (sizes[number - 1] + sizes[number])
        form, vectors, kept = schur(
            self._square(),
            output=output,
            sort=lambda value, im=0.0: bool(np.abs(value + 1j * im) >= cut),
        )
        return form[:kept, :kept], vectors[:, :kept]

    def _largest(self, theta: Complexes) -> NDArray[np.bool_]:
        """So many eigenvalues as are finite."""
        chosen = np.zeros(len(theta), dtype=bool)
        chosen[np.argsort(-np.abs(theta))[: self._finite]] = True
        return chosen

    def _locked(self, theta: Complexes, converged: NDArray[np.bool_]) -> InvariantSubspace:
        """The known with the leading eigenvalues, as far as they have converged."""
        number = leading(theta, converged)
        if not number:
            return self._known
        form, vectors = self._leading(theta, number)
        coupling = self._space.coupling @ vectors
        return self._known.extended(self._space.combined(vectors), coupling, form, self._shift)

    def _locked_with_more(
        self, theta: Complexes, converged: NDArray[np.bool_], residuals: Floats
    ) -> InvariantSubspace:
        """The same, and what nearly converged around it where nothing was known."""
        sizes, first = np.abs(theta), leading(theta, converged)
        nearly = (residuals <= _NEARLY * sizes) & (_CLEAR * residuals <= self._least - sizes)
        number = leading(theta, nearly | (sizes >= self._least))
        if self._known.size or not 0 < first < number:
            return self._locked(theta, converged)
        form, own = self._leading(theta, first)
        both = self._leading(theta, number)[1]
        found, self.around = with_more(self._known, self._space, form, own, both, self._shift)
        return found
