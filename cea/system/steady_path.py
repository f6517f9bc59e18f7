"""Steady sliding: the equilibrium of bodies in sliding contact, by load steps.

Contacts obey -sigma_n = c_n (u_n - g_n)_+^m_n with Coulomb friction along a known direction
(Mohanasundaram et al., 2023, eqs. 5, 8 and 16). The contact stiffness of small motions about the
state is p = m_n c_n (u_n - g_n)_+^(m_n - 1).
"""

from collections.abc import Sequence
from itertools import pairwise

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
    solved_regularly,
)
from cea.system.steady_newton import Iteration, SteadyNewton
from cea.system.steady_state import (
    ContactState,
    LoadStep,
    SteadySliding,
    contact_state,
    uniqueness_at,
)
from cea.timing import StageTimer

_SHORTEST = 1 / 64  # smallest substep, relative to the given load step
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
            least = (_SHORTEST if state is not None else _FIRST) * whole
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
