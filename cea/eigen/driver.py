"""The eigenvalue driver: (lambda^2 M + lambda (C + Y) + K) x = 0 by shift-and-invert and MUMPS.

Undamped sliding is linear in kappa = -lambda^2: K x = kappa M x, with K unsymmetric by friction.
Without friction it is solved as a symmetric problem. With damping or rotation the problem is
quadratic in lambda, and its companion form is solved about real shifts. The driver works on a
parametric pencil and knows nothing of bodies.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.linalg import LinAlgError

from cea.arrays import Complexes
from cea.eigen.errors import (
    LeftVectors,
    error_estimates,
    left_vectors_of,
    needs_left_vectors,
    two_sided,
)
from cea.eigen.krylov_schur import KrylovOptions
from cea.eigen.modes import Modes, modes_of, up_to
from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.search import Search, nearest_plan
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.window import window_of, window_plan
from cea.errors import ConvergenceError, InputError
from cea.petsc import give_back
from cea.timing import StageTimer

ABOVE = 1.05
"""Upper end of the searched frequencies relative to max_frequency where hints are requested."""


class EigenSolver:
    """Shift-and-invert Krylov-Schur on a parametric pencil.

    Parameters
    ----------
    pencil
        Parametric pencil whose eigenvalues are computed.
    options
        Options of the method.

    Attributes
    ----------
    solves, factorisations
        Eigenvalue problems solved and matrices factorised so far, inertia counts included.
    """

    def __init__(self, pencil: Pencil, options: KrylovOptions | None = None) -> None:
        if not any(term.role == "mass" for term in pencil.terms):
            raise InputError("mass", None, "a mass matrix, which modal analysis requires")
        self.pencil, self.options = pencil, options or KrylovOptions()
        self.solves = self.factorisations = 0
        self._summed: tuple[dict[str, float], Matrices] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()

    def free(self) -> None:
        """Free the assembled matrices and return their memory to the system."""
        if self._summed is not None:
            release(self._summed[1])
            self._summed = None
        give_back()

    def solve(
        self,
        max_frequency: float,
        changes: Mapping[str, float] | None = None,
        *,
        min_growth: float | None = None,
        left: bool = False,
        hints: bool = False,
        timer: StageTimer | None = None,
    ) -> Modes:
        """Return all modes up to a frequency, whatever their growth rates.

        Parameters
        ----------
        max_frequency
            Upper end of the window (Hz).
        changes
            Values of parameters of the pencil that replace their defaults.
        min_growth
            Lower end of the growth rates of damped or rotating systems (1/s), zero or negative.
            None takes minus a tenth of 2 pi max_frequency, or less in modulus where many overdamped
            modes cluster. Ignored otherwise: decaying modes mirror growing ones.
        left
            Whether to compute left vectors, for sensitivities and true condition numbers.
        hints
            Whether the window reports growing modes up to 5 percent above its end, and, where it
            is empty, the lowest mode above it.
        timer
            Timer of the stages assembly, factorisation, krylov and post-processing.

        Raises
        ------
        InputError
            When a parameter is unknown or its value is not allowed.
        ConvergenceError
            When the search of the window fails; the modes found so far are attached.
        """
        if not 0 < max_frequency < np.inf:
            raise InputError("max_frequency", max_frequency, "a positive number (Hz)")
        if min_growth is not None and not -np.inf < min_growth <= 0:
            raise InputError("min_growth", min_growth, "zero or a negative number (1/s), or none")
        timer = timer or StageTimer()
        with timer("assembly"):
            matrices = self.matrices(changes)
        above = ABOVE if hints and not matrices.conservative else 1.0  # else nothing can grow there
        search = Search(matrices, 2 * np.pi * above * max_frequency, self.options, timer)

        decay = None if min_growth is None else -min_growth

        def listed(modes: Modes) -> Modes:
            return up_to(modes, max_frequency, min_growth) if hints else modes

        with self._counted(search, listed):
            search.run(window_plan(search, decay))
            modes = listed(self._modes(search, left=left))
        window = modes.window
        if window.symmetric_count is not None and not window.complete:
            raise ConvergenceError(
                f"{window.found_below} eigenvalues found below kappa = {window.upper:.6g}, the "
                f"inertia of S - kappa M counts {window.symmetric_count}",
                best=modes,
            )
        if hints and not len(modes) and not window.odd:
            window = replace(window, lowest=self._lowest(max_frequency, changes))
        return replace(modes, window=window)

    @contextmanager
    def _counted(self, search: Search, listed: Callable[[Modes], Modes]) -> Iterator[None]:
        """Count the factorisations of a search, free it, and attach its modes to its errors."""
        try:
            yield
        except LinAlgError as error:
            raise ConvergenceError(
                f"entries of this system differ too much in size for double precision ({error})"
            ) from error
        except ConvergenceError as error:
            if isinstance(error.best, InvariantSubspace) and error.best.size:
                search.found = error.best
                error.best = self._modes(search, left=None)
            if isinstance(error.best, Modes):
                error.best = listed(error.best)
            raise
        finally:
            self.solves += 1
            self.factorisations += search.factorisations
            search.free()

    def _modes(self, search: Search, *, left: bool | None) -> Modes:
        """Return the modes of the subspace found, with errors; no left vectors if left is None."""
        subspace, op, timer = search.found, search.near, search.timer
        assert subspace is not None
        assert self._summed is not None
        with timer("post-processing"):  # guard eigenvalues also show the effect of rounding
            pairs = error_estimates(op, subspace)
            unsure = left is not None and needs_left_vectors(op, subspace, pairs)
        both: tuple[Complexes, LeftVectors] | None = None
        if op.symmetric and left:
            both = pairs.values, LeftVectors(pairs.vectors, pairs.forces)
        elif left or unsure:
            try:
                left_values, vectors = search.left(len(pairs.vectors))
                with timer("post-processing"):
                    both = left_values, left_vectors_of(search.near, pairs, left_values, vectors)
            except (ConvergenceError, LinAlgError):
                if left:
                    raise
        with timer("post-processing"):
            if unsure or (left and not op.symmetric):
                pairs = two_sided(search.near, subspace, pairs, both)
            wanted = both[1] if left and both is not None else None
            window = window_of(search, pairs.values)
            return modes_of(self.pencil, *self._summed, pairs, wanted, window)

    def nearest(
        self,
        kappa: complex,
        wanted: int,
        changes: Mapping[str, float] | None = None,
        *,
        timer: StageTimer | None = None,
    ) -> Modes:
        """Return the modes nearest to a given kappa = -lambda^2.

        With damping or rotation distances are measured in lambda, from the root of -kappa with
        Im lambda > 0, or the positive one.

        ``kappa`` is any real number (1/s^2), with damping or rotation any nonzero one. A few more
        modes than ``wanted`` may be returned. Other parameters are those of :meth:`solve`.
        InputError when ``kappa`` or ``wanted`` is not allowed, ConvergenceError when fewer modes
        converge.
        """
        if wanted < 1:
            raise InputError("wanted", wanted, "1 or more")
        timer = timer or StageTimer()
        with timer("assembly"):
            matrices = self.matrices(changes)
        place: complex = kappa
        if matrices.quadratic:
            if not (kappa and np.isfinite(kappa)):
                raise InputError("kappa", kappa, "a finite number that is not zero")
            place = complex(np.sqrt(-complex(kappa)))
            place = place if place.imag >= 0 else -place
        elif isinstance(kappa, complex):
            raise InputError("kappa", kappa, "a real number without damping and rotation")
        end = abs(place) if matrices.quadratic else np.inf
        search = Search(matrices, end, self.options, timer)

        def listed(modes: Modes) -> Modes:
            values = modes.eigenvalues if matrices.quadratic else -(modes.eigenvalues**2)
            distances = np.abs(values - place)
            if matrices.quadratic:
                order = np.sort(np.argsort(distances, kind="stable")[:wanted])
                modes, distances = modes[order], distances[order]
            radius = float(distances.max(initial=0.0))
            return replace(modes, window=replace(modes.window, found=len(modes), radius=radius))

        with self._counted(search, listed):
            search.run(nearest_plan(search, place, wanted))
            return listed(self._modes(search, left=None))

    def _lowest(self, end: float, changes: Mapping[str, float] | None) -> float | None:
        """Return the frequency (Hz) of the lowest mode above the end of an empty window (Hz)."""
        try:
            found = self.nearest(0.5 * (2 * np.pi * end) ** 2, 1, changes).frequencies
        except ConvergenceError as error:
            if isinstance(error.best, Modes):  # rounding may have moved modes out of the window
                raise
            return None  # the system may have no mode at all
        return min(found[found > end].tolist(), default=None)

    def matrices(self, changes: Mapping[str, float] | None = None) -> Matrices:
        """Return the matrices at given parameters; they are freed when the parameters change."""
        values = self.pencil.values(changes)
        if self._summed is not None and self._summed[0] == values:
            return self._summed[1]
        before, self._summed = self._summed, None  # no freed matrices remain after an interruption
        if before is not None:
            release(before[1])
        self._summed = (values, self.pencil.at(values))
        return self._summed[1]


def solve_modes(
    pencil: Pencil,
    max_frequency: float,
    changes: Mapping[str, float] | None = None,
    *,
    options: KrylovOptions | None = None,
    **asked: Any,
) -> Modes:
    """Return all modes of a pencil up to a frequency by one solve of an :class:`EigenSolver`.

    Parameters and errors are those of the solver and of :meth:`EigenSolver.solve`.
    """
    with EigenSolver(pencil, options) as driver:
        return driver.solve(max_frequency, changes, **asked)
