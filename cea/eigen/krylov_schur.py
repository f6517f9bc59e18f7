"""The eigenvalue driver: (lambda^2 M + lambda (C + Y) + K) x = 0 by shift-and-invert and MUMPS.

Undamped sliding is linear in kappa = -lambda^2: K x = kappa M x, with K unsymmetric by friction.
Without friction it is solved as a symmetric problem. With damping or rotation the problem is
quadratic in lambda, and its companion form is solved about real shifts. The driver takes a
parametric pencil, not bodies, and keeps inertia counts for the solves that follow.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Self

import numpy as np

from cea.eigen.coverage import upper_end
from cea.eigen.estimates import EigenProblem, modes_found
from cea.eigen.modes import Modes
from cea.eigen.nearest import nearest, nearest_damped
from cea.eigen.options import KrylovOptions
from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.shifted import count_below
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.window import DampedSearch, Found, UndampedSearch, WindowSearch
from cea.errors import ConvergenceError, InputError
from cea.heap import give_back
from cea.timing import StageTimer


class KrylovSchur:
    """Shift-and-invert Krylov-Schur on a parametric pencil.

    Inertia counts are kept for as long as the symmetric parts stay as they are.

    Parameters
    ----------
    pencil
        What is solved.
    options
        Options of the method.

    Attributes
    ----------
    solves, factorisations
        Eigenvalue problems solved and matrices factorised so far, inertia counts included.
    """

    def __init__(self, pencil: Pencil, options: KrylovOptions | None = None) -> None:
        if not any(term.role == "mass" for term in pencil.terms):
            raise InputError("mass", None, "a mass: modes have none without")
        self.pencil, self.options = pencil, options or KrylovOptions()
        self.solves = self.factorisations = 0
        self._counts: dict[tuple[float, ...], int] = {}
        self._summed: tuple[dict[str, float], Matrices] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()

    def free(self) -> None:
        """Free the sums and give their memory back; what was counted is kept."""
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
        timer: StageTimer | None = None,
    ) -> Modes:
        """All modes up to a frequency, of any growth.

        Parameters
        ----------
        max_frequency
            Upper end of the modes asked for (Hz).
        changes
            Parameters of the pencil that differ from their own values.
        min_growth
            With damping or rotation, growth rate (1/s), zero or less, down to which modes are
            asked for; None takes a tenth of the angular frequency of the end, or less where
            overdamped modes crowd. Without, modes that decay mirror those that grow.
        left
            Whether left vectors are wanted too, for sensitivities and true condition numbers.
        timer
            Counts assembly, factorisation, krylov and post-processing.

        Raises
        ------
        InputError
            When a parameter is unknown or refused.
        ConvergenceError
            When the window cannot be searched; the modes found so far are attached.
        """
        if not 0 < max_frequency < np.inf:
            raise InputError("max_frequency", max_frequency, "a positive number (Hz)")
        if min_growth is not None and not -np.inf < min_growth <= 0:
            raise InputError("min_growth", min_growth, "zero or a negative number (1/s), or none")
        timer, values = timer or StageTimer(), self.pencil.values(changes)
        with timer("assembly"):
            matrices = self._matrices(values)
        end = 2 * np.pi * max_frequency
        problem = EigenProblem(self.pencil, values, matrices, end, timer)
        try:
            search = self._search(problem, min_growth)
        except np.linalg.LinAlgError as error:
            raise _too_far_apart(error) from error
        try:
            modes = modes_found(problem, search.run(), search, left=left)
        except np.linalg.LinAlgError as error:
            raise _too_far_apart(error) from error
        except ConvergenceError as error:
            if isinstance(error.best, InvariantSubspace) and error.best.size:
                error.best = modes_found(problem, Found(error.best), search, left=None)
            raise
        finally:
            self.solves += 1
            self.factorisations += search.factorisations
            search.free()
        window = modes.window
        if window.symmetric_count is not None and not window.complete:
            raise ConvergenceError(
                f"{window.found_below} eigenvalues found below kappa = {window.upper:.6g}, the "
                f"inertia of S - kappa M counts {window.symmetric_count}",
                best=modes,
            )
        return modes

    def _search(self, problem: "EigenProblem", min_growth: float | None) -> WindowSearch:
        matrices, end, timer = problem.matrices, problem.end, problem.timer
        if matrices.quadratic:
            decay = None if min_growth is None else -min_growth
            return DampedSearch(matrices, end, self.options, timer, decay)
        counted, near = None, None
        if matrices.symmetric:
            with timer("factorisation"):
                counted = self._count(matrices, problem.values, upper_end(end**2))
        elif self.pencil.near_contact is not None:
            with timer("assembly"):
                near = self.pencil.near_contact.at(problem.values)
        return UndampedSearch(matrices, end, self.options, timer, counted, near)

    def nearest(
        self,
        kappa: complex,
        wanted: int,
        changes: Mapping[str, float] | None = None,
        *,
        timer: StageTimer | None = None,
    ) -> Modes:
        """The few modes nearest to kappa = -lambda^2.

        With damping or rotation they are nearest in lambda, to the root with Im lambda > 0, or the
        positive one.

        Parameters
        ----------
        kappa
            Where (1/s^2). Without damping and rotation a real number, with them any but zero.
        wanted
            Number of eigenvalues; a few more may come.
        changes
            Parameters of the pencil that differ from their own values.
        timer
            Counts assembly, factorisation, krylov and post-processing.

        Raises
        ------
        InputError
            When there is no such place, or too few are wanted.
        ConvergenceError
            When fewer converge.
        """
        if wanted < 1:
            raise InputError("wanted", wanted, "1 or more")
        timer, values = timer or StageTimer(), self.pencil.values(changes)
        with timer("assembly"):
            matrices = self._matrices(values)
        self.solves += 1
        self.factorisations += 1
        if not matrices.quadratic:
            if isinstance(kappa, complex):
                raise InputError("kappa", kappa, "a real number where nothing damps or rotates")
            with timer("krylov"):
                found, op = nearest(matrices, kappa, wanted, self.options)
            problem = EigenProblem(self.pencil, values, matrices, np.inf, timer)
            modes = problem.nearest_modes(found, op)
        else:
            if not (kappa and np.isfinite(kappa)):
                raise InputError("kappa", kappa, "a finite number that is not zero")
            place = complex(np.sqrt(-complex(kappa)))
            place = place if place.imag >= 0 else -place
            with timer("krylov"):
                found, op = nearest_damped(matrices, place, wanted, self.options)
            problem = EigenProblem(self.pencil, values, matrices, abs(place), timer)
            modes = problem.nearest_modes(found, op)
            order = np.argsort(np.abs(modes.eigenvalues - place), kind="stable")[:wanted]
            modes = modes[np.sort(order)]
            radius = float(np.abs(modes.eigenvalues - place).max(initial=0.0))
            window = replace(modes.window, found=len(modes), radius=radius)
            modes = replace(modes, window=window)
        op.free()
        return modes

    def _matrices(self, values: dict[str, float]) -> Matrices:
        """The pencil at given values of all parameters."""
        if self._summed is None:
            self._summed = (values, self.pencil.at(values))
        elif self._summed[0] != values:
            before, matrices = self._summed
            self._summed = None  # an interruption leaves nothing that was freed
            self._summed = (values, self.pencil.moved(matrices, before, values))
        return self._summed[1]

    def _count(self, matrices: Matrices, values: Mapping[str, float], upper: float) -> int:
        """Eigenvalues of the symmetric part below a kappa."""
        key = (*self.pencil.symmetric_values(values), upper)
        if key not in self._counts:
            self._counts[key] = count_below(matrices, upper)
            self.factorisations += 1
        return self._counts[key]

    def quadratic(self, changes: Mapping[str, float] | None = None) -> bool:
        """Whether the pencil is damped or rotates at given parameters."""
        return self._matrices(self.pencil.values(changes)).quadratic

    def conservative(self, changes: Mapping[str, float] | None = None) -> bool:
        """Whether there is neither friction nor damping at given parameters."""
        return self._matrices(self.pencil.values(changes)).conservative

    def mass(self, values: Mapping[str, float]) -> Any:
        """M at given parameters, PETSc AIJ (kg): it is freed when other parameters are solved."""
        return self._matrices(self.pencil.values(values)).mass


def _too_far_apart(error: Exception) -> ConvergenceError:
    return ConvergenceError(
        f"numbers of this system are too far apart to be computed with ({error})"
    )


def solve_modes(
    pencil: Pencil,
    max_frequency: float,
    changes: Mapping[str, float] | None = None,
    *,
    min_growth: float | None = None,
    left: bool = False,
    options: KrylovOptions | None = None,
    timer: StageTimer | None = None,
) -> Modes:
    """All modes of a pencil up to a frequency: one solve of a :class:`KrylovSchur` driver.

    Parameters and errors are those of the driver and of :meth:`KrylovSchur.solve`.
    """
    with KrylovSchur(pencil, options) as driver:
        return driver.solve(max_frequency, changes, min_growth=min_growth, left=left, timer=timer)
