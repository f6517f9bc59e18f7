"""Newton's method for steady sliding, with the consistent unsymmetric tangent.

A full step is accepted if it halves the residual. Otherwise it is damped until the simplified
Newton step at the new state is shorter than the step (Deuflhard, Newton Methods for Nonlinear
Problems, natural monotonicity): unlike the residual this does not depend on the scaling of the
equations. If no step with the tangent is accepted, for instance because open points leave rigid
body modes, a multiple of the slopes of a closed contact is added to it. The active set follows the
closures of each state.
"""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.system.steady_equations import State, SteadyEquations, free_tangent, solved
from cea.system.steady_state import LoadStep, parity_of
from cea.timing import StageTimer

_MOST = 60  # steps
_PATIENCE = 16  # number of steps in which the residual must be halved at least once
_SOLVED = 1e-14  # relative residual below which the iteration ends
_ROUNDING = 1e-7
"""Relative residual below which stagnation may be due to rounding."""
_NOISE = 10.0  # the same relative to the rounding error due to the closures
_STALLS = 0.3  # ratio of successive residuals above which Newton's method stagnates
_SHORTEST = 2.0**-12  # smallest damping factor
_HELP = (0.0, 1e-3, 1e-1, 1.0, 10.0)
"""Multiples of the slopes of a closed contact that are tried in turn if no step is accepted."""


@dataclass
class Iteration:
    """History and result of Newton's method."""

    step: LoadStep  # residuals and step lengths
    state: State  # the last state
    converged: bool = False  # whether the residual is at the level of rounding

    def note(self, state: State) -> None:
        """Record the next state."""
        self.state = state
        self.step.residuals.append(state.relative)
        self.step.closed.append(state.closed_points)

    @property
    def stagnates(self) -> bool:
        """Whether the residual has not been halved in the last steps."""
        early, late = self.step.residuals[:-_PATIENCE], self.step.residuals[-_PATIENCE:]
        return bool(early) and min(late) > 0.5 * min(early)


class SteadyNewton:
    """Newton's method for steady sliding, regularised by springs."""

    def __init__(self, equations: SteadyEquations, timer: StageTimer) -> None:
        self._equations, self._timer = equations, timer

    def solve(self, x: Floats, f: Floats, factor: float) -> Iteration:
        """Solve at a load factor from initial displacements and contact forces."""
        state = self._equations.state(x, f, factor)
        run = Iteration(LoadStep(factor), state)
        run.note(state)
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
            run.note(state)
            run.step.lengths.append(length)
            if run.stagnates:
                break
        return run

    def _step(self, state: State, factor: float, run: Iteration) -> tuple[State, float] | None:
        """Return the next state and the damping factor; None if no step is accepted."""
        run.step.parity, slopes = None, self._equations.slopes(state.closures)
        for part in _HELP:
            pairs = zip(slopes, self._equations.springs, strict=True)
            with self._timer("assembly"):
                tangent = self._equations.tangent([p + part * spring for p, spring in pairs])
            try:
                with self._timer("factorisation"):
                    factors = Shifted(tangent)
            except ConvergenceError:
                free_tangent(tangent)
                continue
            if part == 0:
                unstable = self._equations.unstable
                run.step.parity = parity_of(tangent, factors, unstable=unstable)
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
        """Return the state and damping factor of the longest accepted step, or None."""
        dx, df = solved(factors, -state.residual)
        (size,) = self._equations.norms(dx)
        if not np.isfinite(size):
            return None
        length = 1.0
        while length >= _SHORTEST:
            new = self._equations.state(state.x + length * dx, state.f + length * df, factor)
            if self._is_better(factors, state, new, float(size), length):
                return new, length
            length *= 0.5
        return None

    def _is_better(
        self, factors: Shifted, state: State, new: State, size: float, length: float
    ) -> bool:
        if not np.isfinite(new.norm):
            return False
        if state.closed_points and not new.closed_points and not self._equations.are_held:
            return False
        if new.norm <= 0.5 * state.norm:
            return True
        (next_,) = self._equations.norms(solved(factors, -new.residual)[0])
        return bool(next_ <= (1 - 0.25 * length) * size)


def _is_small(state: State) -> bool:
    """Return whether the residual may be rounding."""
    return state.norm <= max(_ROUNDING * state.scale, _NOISE * state.noise)
