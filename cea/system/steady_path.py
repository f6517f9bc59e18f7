"""Steady sliding: the equilibrium of bodies in sliding contact, by load steps.

Contacts obey -sigma_n = c_n (u_n - g_n)_+^m_n with Coulomb friction along a known direction
(Mohanasundaram et al., 2023, eqs. 5, 8 and 16). The contact stiffness of small motions about the
state is p = m_n c_n (u_n - g_n)_+^(m_n - 1).

Newton's method has the consistent unsymmetric tangent.

A full step is accepted if it halves the residual. Otherwise it is damped until the simplified
Newton step at the new state is shorter than the step (Deuflhard, Newton Methods for Nonlinear
Problems, natural monotonicity): unlike the residual this does not depend on the scaling of the
equations. If no step with the tangent is accepted, for instance because open points leave rigid
body modes, a multiple of the slopes of a closed contact is added to it. The active set follows the
closures of each state.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cea.arrays import Floats
from cea.eigen.pencil import release
from cea.eigen.shifted import Shifted
from cea.eigen.static import rounding_uncertainty
from cea.errors import ConvergenceError, require
from cea.system.coupled import CoupledSystem
from cea.system.steady_equations import (
    LOST,
    OPENS,
    State,
    SteadyEquations,
    free_tangent,
    solved,
    solved_regularly,
)
from cea.system.steady_state import (
    ContactState,
    LoadStep,
    SteadySliding,
    contact_state,
    parity_of,
    uniqueness_at,
)
from cea.timing import StageTimer

_SHORTEST_PART = 1 / 64  # smallest substep, relative to the given load step
_FIRST = 1 / 2  # the same before the first equilibrium
_GROWS = 2.0  # growth factor of substeps
_SOFTNESSES = tuple(10.0**power for power in range(12, -1, -2))
"""Factors by which laws are divided in turn if the law itself does not converge."""
_TOGETHER = 1e-9  # remaining load, relative to a step, that is added to the last substep
_FREE = (
    "a rigid body mode is free: supports, and contacts with all points closed, do not constrain "
    "the bodies"
)
_LEAVE_FREE = "the closed points leave a rigid body mode free: the tangent is singular"
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


def steady_sliding(
    system: CoupledSystem,
    timer: StageTimer | None = None,
    *,
    steps: int | Sequence[float] = 1,
    history: bool = False,
) -> SteadySliding:
    """Return the steady sliding state of a system with loads and a nonlinear contact law.

    The load is applied in ``steps`` equal steps, or up to increasing fractions of it, the last of
    them 1; steps without equilibrium are divided. ``history`` stores the equilibrium of every step.
    Raise ConvergenceError, with the last state, if the load opens the contact or no equilibrium is
    found; without it, if a rigid body mode is free.
    """
    require(system.load is not None, "load", None, "loads: the system was coupled without any")
    linear = all(contact.law.linear for contact in system.contacts)
    require(not linear, "contacts", list(system.bodies), "at least one with a nonlinear law")
    if isinstance(steps, int):
        steps = tuple(number / steps for number in range(1, steps + 1))
    equations = SteadyEquations(system)
    try:
        return _Path(equations, timer or StageTimer(), history).solve((0.0, *steps))
    finally:
        release(equations.matrices)


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


class _Path:
    """Load path from zero to the full load."""

    def __init__(self, equations: SteadyEquations, timer: StageTimer, history: bool) -> None:
        self._equations, self._timer, self._history = equations, timer, history
        self._newton = SteadyNewton(equations, timer)
        self._starts: dict[float, tuple[Floats, Floats]] = {}

    def solve(self, targets: Sequence[float]) -> SteadySliding:
        """Apply the load in steps between targets, divided where necessary."""
        first = targets[1]
        self._equations.take_springs(first)
        if self._pulls(first) and not self._equations.are_held:
            start = self._equations.state(*self._start(first), first)
            raise ConvergenceError(OPENS, best=start)
        path: list[LoadStep] = []
        state: State | None = None
        for begin, end in pairwise(targets):
            if begin:
                self._equations.take_springs(end)
                self._starts.clear()
            state = self._step(state, begin, end, path)
        assert state is not None
        return self._result(state, path)

    def _step(self, state: State | None, begin: float, end: float, path: list[LoadStep]) -> State:
        """Solve one given load step, divided if no equilibrium is found."""
        whole = part = end - begin
        done = begin
        while state is None or done < end:
            factor = done + part if done + part < end - _TOGETHER * whole else end
            run = self._at(state, factor)
            if run.converged and run.state.closed_points:
                done, state = factor, run.state
                part = min(_GROWS * part, whole)
                if self._history:
                    run.step.displacement = self._equations.vector(state.x)
                    run.step.contacts = self._contact_states(state)
                path.append(run.step)
                continue
            part *= 0.5
            least = (_SHORTEST_PART if state is not None else _FIRST) * whole
            if part < least or (state is None and self._pulls(factor)):
                raise ConvergenceError(self._reason(run, factor), best=run.state)
        return state

    def _at(self, state: State | None, factor: float) -> Iteration:
        """Solve at a load factor from the previous equilibrium, or else from the springs."""
        if state is not None:
            run = self._newton.solve(state.x, state.f, factor)
            if run.converged:
                return run
        run = self._newton.solve(*self._start(factor), factor)
        if run.converged or self._pulls(factor):
            return run
        return self._stiffened(factor)

    def _stiffened(self, factor: float) -> Iteration:
        """Solve at a load factor by continuation from softer laws."""
        x, f = self._start(factor)
        found = False
        for softness in _SOFTNESSES:
            self._equations.softness = softness
            run = self._newton.solve(x, f, factor)
            if run.converged:
                x, f, found = run.state.x, run.state.f, True
            elif found:
                break
        self._equations.softness = 1.0
        return run

    def _start(self, factor: float) -> tuple[Floats, Floats]:
        """Return the initial displacements and forces, with springs at all points.

        Springs act in tension too: the contact is closed everywhere.
        """
        if factor not in self._starts:
            equations = self._equations
            tangent = equations.tangent(equations.springs, friction=False)
            with self._timer("factorisation"):
                found = solved_regularly(tangent, equations.forces_at_rest(factor))
            free_tangent(tangent)
            if found is None:
                raise ConvergenceError(_FREE)
            self._starts[factor] = found
        return self._starts[factor]

    def _result(self, state: State, path: Sequence[LoadStep]) -> SteadySliding:
        equations = self._equations
        tangent = equations.tangent(equations.slopes(state.closures))
        x, f = state.x[:, None], state.f[:, None]
        try:
            with self._timer("factorisation"):
                try:
                    factors = Shifted(tangent)
                except ConvergenceError:
                    raise ConvergenceError(_LEAVE_FREE, best=state) from None
                uncertainty = rounding_uncertainty(tangent, factors, x, f)
                parities = {step.factor: step.parity for step in path}
                unstable = equations.unstable
                uniqueness = uniqueness_at(tangent, factors, parities, unstable=unstable)
                factors.free()
            if not uncertainty < LOST:
                raise ConvergenceError(_LEAVE_FREE, best=state)
            residual = equations.checked_residual(state, tangent)
        finally:
            free_tangent(tangent)
        return SteadySliding(
            displacement=equations.vector(state.x),
            forces=state.f,
            uncertainty=uncertainty,
            residual=residual,
            contacts=self._contact_states(state),
            path=tuple(path),
            uniqueness=uniqueness,
        )

    def _contact_states(self, state: State) -> dict[str, ContactState]:
        return {
            contact.name: contact_state(contact, closure)
            for contact, closure in zip(self._equations.contacts, state.closures, strict=True)
        }

    def _reason(self, run: Iteration, factor: float) -> str:
        """Return the reason why no equilibrium was found."""
        if self._equations.unstable:
            return (
                f"no state of steady sliding was found at {factor:.3g} of the load: bodies rotate "
                "beyond a critical rate, at which their convective stiffness exceeds their own; "
                "it may not exist"
            )
        if not run.state.closed_points or self._pulls(factor):
            return OPENS
        return (
            f"no state of steady sliding was found at {factor:.3g} of the load: residual "
            f"{run.state.relative:.1e} of the forces; friction or stiffness may be too large"
        )

    def _pulls(self, factor: float) -> bool:
        """Return whether the resultant of the springs is tension.

        This is inconclusive, and False, if bodies are unstable without contacts.
        """
        if self._equations.unstable:
            return False
        x = self._start(factor)[0]
        return self._equations.spring_resultant(x, factor) <= 0
