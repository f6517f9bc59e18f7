"""Newton's method for steady sliding, with the consistent unsymmetric tangent.

A step is taken in full where it halves the residual. Otherwise it is shortened until the next
correction by the same tangent is shorter than it (Deuflhard, Newton Methods for Nonlinear Problems,
natural monotonicity): unlike the residual that does not care how stiff each part is. Where no step
of the tangent helps, as where open points leave the bodies free, slopes of a part of those of a
closed contact are added to it. The active set is that of the closures at each state.
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
_PATIENCE = 16  # steps in which the residual is halved at least
_SOLVED = 1e-14  # residual, relative to the forces, at which there is nothing left to gain
_ROUNDING = 1e-7
"""Residual, relative to the forces, from which what does not get smaller may be rounding."""
_NOISE = 10.0  # the same in parts of what rounding of the closures makes of it
_STALLS = 0.3  # ratio of residuals that is no convergence of Newton's method
_SHORTEST = 2.0**-12  # shortest part of a step
_HELP = (0.0, 1e-3, 1e-1, 1.0, 10.0)
"""Parts of the slopes of a closed contact that are added, in turn, where no step helps."""


@dataclass
class Iteration:
    """How Newton's method went."""

    step: LoadStep  # the states and steps it took
    state: State  # the last state
    converged: bool = False  # whether the residual is as small as rounding lets it be

    def note(self, state: State) -> None:
        """Go on to the next state."""
        self.state = state
        self.step.residuals.append(state.relative)
        self.step.closed.append(state.closed_points)

    @property
    def stagnates(self) -> bool:
        """Whether the residual has not been halved for many steps."""
        early, late = self.step.residuals[:-_PATIENCE], self.step.residuals[-_PATIENCE:]
        return bool(early) and min(late) > 0.5 * min(early)


class SteadyNewton:
    """Newton's method on the equations, with the help of their springs."""

    def __init__(self, equations: SteadyEquations, timer: StageTimer) -> None:
        self._equations, self._timer = equations, timer

    def solve(self, x: Floats, f: Floats, factor: float) -> Iteration:
        """Solve from displacements and contact forces under a part of the load."""
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
        """The next state and the part of the step that was taken; None where none helps."""
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
        """The longest part of a step that makes things better."""
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
    """Whether what is left may be rounding."""
    return state.norm <= max(_ROUNDING * state.scale, _NOISE * state.noise)
