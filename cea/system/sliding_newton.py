"""Newton's method for steady sliding, with the consistent unsymmetric tangent.

A step is taken in full where it halves the residual. Otherwise it is shortened until the next
correction by the same tangent is shorter than it (Deuflhard, Newton Methods for Nonlinear Problems,
natural monotonicity): unlike the residual that does not care how stiff each part is. Where no step
of the tangent helps, as where open points leave the bodies free, slopes of a part of those of a
closed contact are added to it. The active set is that of the closures at each state.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cea.arrays import Floats
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.eigen.static import rounding_uncertainty
from cea.errors import ConvergenceError
from cea.system.sliding_problem import SlidingProblem, State, free_tangent
from cea.system.uniqueness import parity_beside
from cea.timing import StageTimer

_MOST = 60
"""Steps."""
_PATIENCE = 16
"""Steps in which the residual is halved at least."""
_SOLVED = 1e-14
"""Residual, relative to the forces, at which there is nothing left to gain."""
_ROUNDING = 1e-7
"""Residual, relative to the forces, from which what does not get smaller may be rounding."""
_NOISE = 10.0
"""The same in parts of what rounding of the closures makes of it."""
_STALLS = 0.3
"""Ratio of residuals that is no convergence of Newton's method."""
_SHORTEST = 2.0**-12
"""Shortest part of a step."""
_HELP = (0.0, 1e-3, 1e-1, 1.0, 10.0)
"""Parts of the slopes of a closed contact that are added, in turn, where no step helps."""
_LOST = 0.1
"""Rounding, relative to the largest displacement, at which a tangent counts as singular."""


@dataclass
class Iteration:
    """How Newton's method went.

    Parameters
    ----------
    state
        The last state.
    residuals
        Residual of each state, relative to the forces it is the sum of.
    lengths
        Part of each step that was taken.
    closed
        Points that were closed in each state.
    parity
        Whether the number of negative real eigenvalues of the last tangent is odd (1) or even (0);
        None where that is not known.
    converged
        Whether the residual is as small as rounding lets it be.
    """

    state: State
    residuals: list[float] = field(default_factory=list)
    lengths: list[float] = field(default_factory=list)
    closed: list[int] = field(default_factory=list)
    parity: int | None = None
    converged: bool = False


class SlidingNewton:
    """Newton's method on the equations of steady sliding.

    Parameters
    ----------
    problem
        The equations.
    help_
        Slopes of a closed contact at all points (N/m^3), by contact.
    timer
        Counts assembly and factorisation.
    """

    def __init__(self, problem: SlidingProblem, help_: Sequence[Floats], timer: StageTimer) -> None:
        self._problem = problem
        self._help = tuple(help_)
        self._timer = timer
        self._held: bool | None = None

    def solve(self, x: Floats, f: Floats, factor: float) -> Iteration:
        """Solve from a state under a part of the load.

        Parameters
        ----------
        x, f
            Displacements and contact forces that are unknowns to begin with.
        factor
            The part of the load.
        """
        state = self._problem.state(x, f, factor)
        run = Iteration(state)
        self._note(run, state)
        for _ in range(_MOST):
            if state.relative <= _SOLVED:
                run.converged = True
                break
            step = self._step(state, factor, run)
            if step is None:
                run.converged = _is_small(state)
                break
            new, length = step
            if _is_small(state) and new.norm > _STALLS * state.norm:
                run.state = state if state.norm < new.norm else new
                run.converged = True
                break
            state = new
            self._note(run, state, length)
            if len(run.residuals) > _PATIENCE and _stagnates(run.residuals):
                break
        return run

    def _note(self, run: Iteration, state: State, length: float | None = None) -> None:
        run.state = state
        run.residuals.append(state.relative)
        run.closed.append(closed_points(state))
        if length is not None:
            run.lengths.append(length)

    def _step(self, state: State, factor: float, run: Iteration) -> tuple[State, float] | None:
        """The next state and the part of the step that was taken; None where none helps."""
        run.parity = None
        for part in _HELP:
            slopes = [
                slope + part * closed
                for slope, closed in zip(
                    self._problem.slopes(state.closures), self._help, strict=True
                )
            ]
            with self._timer("assembly"):
                tangent = self._problem.tangent(slopes)
            try:
                with self._timer("factorisation"):
                    factors = Shifted(tangent)
            except ConvergenceError:
                free_tangent(tangent)
                continue
            if part == 0:
                unstable = self._problem.unstable
                run.parity = parity_beside(tangent, factors, unstable=unstable)
            with self._timer("factorisation"):
                found = self._searched(factors, state, factor)
            factors.free()
            free_tangent(tangent)
            if found is not None:
                return found
        return None

    def _searched(
        self, factors: Shifted, state: State, factor: float
    ) -> tuple[State, float] | None:
        """The longest part of a step that makes things better."""
        dx, df = _solved(factors, -state.residual)
        (size,) = self._problem.norms(dx)
        if not np.isfinite(size):
            return None
        length = 1.0
        while length >= _SHORTEST:
            new = self._problem.state(state.x + length * dx, state.f + length * df, factor)
            if self._is_better(factors, state, new, float(size), length):
                return new, length
            length *= 0.5
        return None

    def _is_better(
        self, factors: Shifted, state: State, new: State, size: float, length: float
    ) -> bool:
        if not np.isfinite(new.norm):
            return False
        if closed_points(state) and not closed_points(new) and not self.is_held():
            return False
        if new.norm <= 0.5 * state.norm:
            return True
        (next_,) = self._problem.norms(_solved(factors, -new.residual)[0])
        return bool(next_ <= (1 - 0.25 * length) * size)

    def is_held(self) -> bool:
        """Whether the bodies are held without the contacts that have a law."""
        if self._held is None:
            load = np.random.default_rng(self._problem.comm.rank).standard_normal(
                self._problem.rows
            )
            self._held = solved_regularly(self._problem.matrices, load) is not None
        return self._held


def solved_regularly(matrices: Matrices, b: Floats) -> tuple[Floats, Floats, float] | None:
    """Displacements and contact forces for forces b, and what rounding makes of them.

    Parameters
    ----------
    matrices
        A tangent.
    b
        Forces (N), the rows of this rank.

    Returns
    -------
    tuple or None
        None where the tangent is singular, or so nearly that nothing but rounding is left.
    """
    try:
        factors = Shifted(matrices)
    except ConvergenceError:
        return None
    x, f = factors.solve_with_forces(b[:, None])
    uncertainty = rounding_uncertainty(matrices, factors, x, f)
    factors.free()
    return (x[:, 0], f[:, 0], uncertainty) if uncertainty < _LOST else None


def closed_points(state: State) -> int:
    """Number of points that are closed."""
    return sum(int(np.count_nonzero(closure > 0)) for closure in state.closures)


def _stagnates(residuals: Sequence[float]) -> bool:
    """Whether the residual has not been halved for many steps."""
    return min(residuals[-_PATIENCE:]) > 0.5 * min(residuals[:-_PATIENCE])


def _is_small(state: State) -> bool:
    """Whether what is left may be rounding."""
    return state.norm <= max(_ROUNDING * state.scale, _NOISE * state.noise)


def _solved(factors: Shifted, b: Floats) -> tuple[Floats, Floats]:
    dx, df = factors.solve_with_forces(b[:, None])
    return dx[:, 0], df[:, 0]
