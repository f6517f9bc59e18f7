"""The eigenvalue driver: (lambda^2 M + lambda (C + Y) + K) x = 0 by shift-and-invert and MUMPS.

Undamped sliding is linear in kappa = -lambda^2: K x = kappa M x, with K unsymmetric by friction.
Without friction it is solved as a symmetric problem. The driver takes a parametric pencil, not
bodies, and keeps inertia counts and factors for the solves that follow. Windows are searched by
blocks (:mod:`cea.eigen.search`), the few modes nearest to a place by SLEPc. With damping or
rotation the problem is quadratic in lambda, and another driver takes it
(:mod:`cea.eigen.quadratic`).
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Self, get_args

import numpy as np

from cea.eigen.balanced import Asked, modes_with_balance
from cea.eigen.disc_searches import Solver
from cea.eigen.eigenpairs import checked
from cea.eigen.found import Found, nearest_window, upper_end
from cea.eigen.judged import Question, judged
from cea.eigen.kept import Kept
from cea.eigen.modes import Modes, modes_of
from cea.eigen.nearest import NearestSearch
from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.quadratic import QuadraticDriver
from cea.eigen.search import WindowSearch, first_field
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError, InputError
from cea.heap import give_back
from cea.timing import StageTimer


class KrylovSchur:
    """Shift-and-invert Krylov-Schur on a parametric pencil.

    Inertia counts are kept for as long as the symmetric parts stay as they are, factors until the
    next are needed: a solve at a nearby parameter refines solutions made with them.

    Parameters
    ----------
    pencil
        What is solved.
    tolerance
        Relative tolerance of the Krylov iteration on 1 / (kappa - shift).
    max_restarts
        Restarts of the Krylov iteration before it is given up.
    solver
        What searches a window: ``"block"``, or ``"krylov-schur"``, that of SLEPc, as a reference;
        it is slower, and takes neither damping nor rotation.

    Attributes
    ----------
    solves
        Eigenvalue problems solved so far.
    """

    def __init__(
        self,
        pencil: Pencil,
        *,
        tolerance: float = 1e-13,
        max_restarts: int = 200,
        solver: Solver = "block",
    ) -> None:
        if solver not in get_args(Solver):
            raise InputError("solver", solver, " or ".join(map(repr, get_args(Solver))))
        if not any(term.role == "mass" for term in pencil.terms):
            raise InputError("mass", None, "a mass: modes have none without")
        self.pencil = pencil
        self.solver: Solver = solver
        self.solves = 0
        self._searched = 0
        self._tolerance, self._max_restarts = tolerance, max_restarts
        self._kept = Kept(pencil)

    @property
    def factorisations(self) -> int:
        """Factorisations made so far, inertia counts included."""
        return self._kept.factorisations + self._searched

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()

    def free(self) -> None:
        """Free factors and sums, and give their memory back; what was counted is kept."""
        self._kept.free()
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
            When the window cannot be filled; the modes found so far are attached.
        """
        if not 0 < max_frequency < np.inf:
            raise InputError("max_frequency", max_frequency, "a positive number (Hz)")
        if min_growth is not None and not -np.inf < min_growth <= 0:
            raise InputError("min_growth", min_growth, "zero or a negative number (1/s), or none")
        timer, values = timer or StageTimer(), self.pencil.values(changes)
        with timer("assembly"):
            matrices = self._kept.matrices(values)
        if matrices.quadratic and self.solver != "block":
            raise InputError("solver", self.solver, "'block' with damping or rotation")
        asked = Asked(self.pencil, values, matrices, max_frequency, min_growth, left)
        return modes_with_balance(
            asked,
            lambda: self._as_it_stands(asked, timer),
            lambda pencil: self._balanced(replace(asked, pencil=pencil, left=True), timer),
        )

    def _balanced(self, asked: Asked, timer: StageTimer) -> Modes:
        """All modes of another pencil, one without parameters."""
        with KrylovSchur(
            asked.pencil,
            tolerance=self._tolerance,
            max_restarts=self._max_restarts,
            solver=self.solver,
        ) as driver:
            matrices = driver._kept.matrices({})
            try:
                return driver._as_it_stands(replace(asked, values={}, matrices=matrices), timer)
            finally:
                self.solves += driver.solves
                self._searched += driver.factorisations

    def _as_it_stands(self, asked: Asked, timer: StageTimer) -> Modes:
        """All modes of a pencil that is not balanced."""
        try:
            return (self._quadratic if asked.matrices.quadratic else self._linear)(asked, timer)
        except np.linalg.LinAlgError as error:
            raise ConvergenceError(
                f"numbers of this system are too far apart to be computed with ({error})"
            ) from error

    def _linear(self, asked: Asked, timer: StageTimer) -> Modes:
        """All modes of a pencil without damping and rotation."""
        values, matrices = dict(asked.values), asked.matrices
        top = (2 * np.pi * asked.max_frequency) ** 2
        counted, field, near = None, None, None
        if not matrices.symmetric and self.pencil.near_contact is not None:
            with timer("assembly"):
                near = self.pencil.near_contact.at(values)
        with timer("factorisation"):  # what shows completeness first: its memory serves the factors
            if matrices.symmetric:
                counted = self._kept.count(matrices, values, upper_end(top))
            else:
                field = first_field(matrices, top, near)
                if near is not None:
                    release(near)
            factors = self._kept.in_the_middle(matrices, values, 0.5 * top)
        search = WindowSearch(
            matrices,
            factors,
            field,
            tolerance=self._tolerance,
            max_restarts=self._max_restarts,
            timer=timer,
            solver=self.solver,
        )
        question = Question(self.pencil, values, matrices, factors, timer)
        self._kept.lost()  # the search moves the factors; where it fails they are no more
        try:
            found = search.complex(top) if counted is None else search.real(top, counted)
        except ConvergenceError as error:
            if isinstance(error.best, InvariantSubspace):
                error.best = judged(Found(error.best), top, question)
            raise
        finally:
            self.solves += 1
            self._searched += search.factorisations
        modes = judged(found, top, question, search, left=asked.left)
        self._kept.moved(values, factors.kappa)
        if counted is not None and not modes.window.complete:
            raise ConvergenceError(
                f"{modes.window.found_below} eigenvalues found below kappa = "
                f"{modes.window.upper:.6g}, the inertia of S - kappa M counts {counted}",
                best=modes,
            )
        return modes

    def _quadratic(self, asked: Asked, timer: StageTimer) -> Modes:
        """All modes of a pencil with damping or rotation."""
        driver = self._of_quadratic(dict(asked.values), asked.matrices, timer)
        try:
            return driver.solve(asked.max_frequency, asked.min_growth, left=asked.left)
        finally:
            self.solves += 1
            self._searched += driver.factorisations

    def nearest(
        self,
        kappa: complex,
        wanted: int,
        changes: Mapping[str, float] | None = None,
        *,
        timer: StageTimer | None = None,
    ) -> Modes:
        """The few modes nearest to kappa = -lambda^2; factors made there before serve again.

        With damping or rotation they are nearest in lambda, to the root with Im lambda > 0, or the
        positive one, and factors are made anew.

        Parameters
        ----------
        kappa
            Where (1/s^2); it is best not an eigenvalue. Without damping and rotation a real
            number, with them any but zero.
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
            matrices = self._kept.matrices(values)
        if matrices.quadratic:
            return self._nearest_quadratic(matrices, values, complex(kappa), wanted, timer)
        if isinstance(kappa, complex):
            raise InputError("kappa", kappa, "a real number where nothing damps or rotates")
        with timer("factorisation"):
            factors = self._kept.nearby(matrices, values, kappa)
        search = NearestSearch(matrices, factors, self._tolerance, self._max_restarts, timer)
        found, vectors = search.nearest(wanted)
        self.solves += 1
        window = nearest_window(kappa, found)
        with timer("post-processing"):
            pairs = checked(matrices, factors, found, vectors)
        if not self._kept.is_own(factors):
            factors.free()
        return modes_of(self.pencil, values, matrices, pairs, None, window)

    def _nearest_quadratic(
        self,
        matrices: Matrices,
        values: dict[str, float],
        kappa: complex,
        wanted: int,
        timer: StageTimer,
    ) -> Modes:
        """The few modes of a pencil with damping or rotation nearest to a place."""
        if not (kappa and np.isfinite(kappa)):
            raise InputError("kappa", kappa, "a finite number that is not zero")
        place = complex(np.sqrt(-kappa))
        driver = self._of_quadratic(values, matrices, timer)
        try:
            return driver.nearest(place if place.imag >= 0 else -place, wanted)
        finally:
            self.solves += 1
            self._searched += driver.factorisations

    def _of_quadratic(
        self, values: dict[str, float], matrices: Matrices, timer: StageTimer
    ) -> QuadraticDriver:
        return QuadraticDriver(
            self.pencil, values, matrices, self._tolerance, self._max_restarts, timer
        )

    def quadratic(self, changes: Mapping[str, float] | None = None) -> bool:
        """Whether the pencil is damped or rotates at given parameters."""
        return self._kept.matrices(self.pencil.values(changes)).quadratic

    def conservative(self, changes: Mapping[str, float] | None = None) -> bool:
        """Whether there is neither friction nor damping at given parameters."""
        return self._kept.matrices(self.pencil.values(changes)).conservative

    def mass(self, values: Mapping[str, float]) -> Any:
        """M at given parameters, PETSc AIJ (kg): it is freed when other parameters are solved."""
        return self._kept.matrices(self.pencil.values(values)).mass


def solve_modes(
    pencil: Pencil,
    max_frequency: float,
    changes: Mapping[str, float] | None = None,
    *,
    min_growth: float | None = None,
    left: bool = False,
    tolerance: float = 1e-13,
    max_restarts: int = 200,
    solver: Solver = "block",
    timer: StageTimer | None = None,
) -> Modes:
    """All modes of a pencil up to a frequency: one solve of a :class:`KrylovSchur` driver.

    Parameters and errors are those of the driver and of :meth:`KrylovSchur.solve`.
    """
    with KrylovSchur(
        pencil, tolerance=tolerance, max_restarts=max_restarts, solver=solver
    ) as driver:
        return driver.solve(max_frequency, changes, min_growth=min_growth, left=left, timer=timer)
