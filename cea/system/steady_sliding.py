"""Steady sliding: the equilibrium of bodies pressed together whose contacts slide.

Contacts whose pressure obeys a law of their closure, -sigma_n = c_n (u_n - g_n)_+^m_n, with Coulomb
friction along a known direction (Mohanasundaram et al., 2023, eqs. 5, 8 and 16). Small motions
about the state meet the contact stiffness p = m_n c_n (u_n - g_n)_+^(m_n - 1).
"""

from collections.abc import Sequence

import numpy as np

from cea.body import Floats
from cea.contact.operators import Contact
from cea.errors import ConvergenceError, InputError
from cea.matrices import destroy
from cea.system.coupled import CoupledSystem
from cea.system.sliding_newton import (
    Iteration,
    SlidingNewton,
    closed_points,
    solved_regularly,
)
from cea.system.sliding_problem import SlidingProblem, State, free_tangent
from cea.system.sliding_state import ContactState, LoadStep, SteadySliding
from cea.system.uniqueness import uniqueness_at
from cea.timing import StageTimer

_SHORTEST = 1 / 64
"""Least part of the load of a step."""
_FIRST = 1 / 2
"""The same before any equilibrium was found."""
_GROWS = 2.0
"""By how much a step is longer than the one before."""
_SOFTNESSES = tuple(10.0**power for power in range(12, -1, -2))
"""By what laws are divided in turn where the law itself does not converge."""
_OVERLAP = 1e-9
"""Overlap of the sides, relative to the mesh size, that rounding and facets may make."""
FREE = (
    "a rigid motion is free: supports, and contacts with all their points closed, do not hold the "
    "bodies"
)
LEAVE_FREE = "the points that are closed leave a rigid motion free: the tangent is singular"
OPENS = "the load opens the contact: no point is closed"


def steady_sliding(
    system: CoupledSystem, timer: StageTimer | None = None, *, steps: int = 1
) -> SteadySliding:
    """Equilibrium of steady sliding.

    Parameters
    ----------
    system
        Bodies with their loads, and contacts of which some have a law that is not linear; those of
        a linear law are closed, and their gaps none.
    timer
        Counts assembly and factorisation.
    steps
        Parts in which the load is put on at first; they are cut where no equilibrium is found.

    Raises
    ------
    InputError
        When the system has no load, no such contact, or steps are not positive.
    ConvergenceError
        When the load opens the contact, a rigid motion is free, or no equilibrium is found; the
        last :class:`cea.system.sliding_problem.State` is attached.
    """
    if system.load is None:
        raise InputError("load", None, "forces: the system was coupled without")
    if all(contact.half.law.linear for contact in system.contacts):
        raise InputError("contacts", list(system.bodies), "one with a law of its closure")
    if steps < 1:
        raise InputError("steps", steps, "1 or more")
    timer = timer or StageTimer()
    problem = SlidingProblem(system)
    try:
        return _Path(problem, timer).solve(steps)
    finally:
        problem.free()


class _Path:
    """The way from no load to the whole of it."""

    def __init__(self, problem: SlidingProblem, timer: StageTimer) -> None:
        self._problem = problem
        self._timer = timer
        self._springs = _closed_slopes(problem)
        self._newton = SlidingNewton(problem, self._springs, timer)
        self._starts: dict[float, tuple[Floats, Floats]] = {}

    def solve(self, steps: int) -> SteadySliding:
        """Put the load on in so many parts, or in more where it takes them."""
        done, part = 0.0, 1.0 / steps
        if self._pulls(part) and not self._newton.is_held():
            start = self._problem.state(*self._start(part), part)
            raise ConvergenceError(OPENS, best=start)
        path: list[LoadStep] = []
        state: State | None = None
        while done < 1.0:
            factor = min(1.0, done + part)
            run = self._at(state, factor)
            if run.converged and closed_points(run.state):
                done, state = factor, run.state
                part = max(part, min(_GROWS * part, 1.0 / steps))
                path.append(_load_step(factor, run))
                continue
            part *= 0.5
            least = _SHORTEST if state is not None else _FIRST
            if part < least or (state is None and self._pulls(factor)):
                raise ConvergenceError(self._reason(run, factor), best=run.state)
        assert state is not None
        return self._result(state, path)

    def _at(self, state: State | None, factor: float) -> Iteration:
        """Equilibrium under a part of the load, from that under a smaller one or from none."""
        if state is not None:
            run = self._newton.solve(state.x, state.f, factor)
            if run.converged:
                return run
        run = self._newton.solve(*self._start(factor), factor)
        if run.converged or self._pulls(factor):
            return run
        return self._stiffened(factor)

    def _stiffened(self, factor: float) -> Iteration:
        """Equilibrium under a part of the load by way of softer laws, each from the one before."""
        problem = self._problem
        x, f = self._start(factor)
        found = False
        try:
            for softness in _SOFTNESSES:
                problem.softness = softness
                run = self._newton.solve(x, f, factor)
                if run.converged:
                    x, f, found = run.state.x, run.state.f, True
                elif found:
                    break
        finally:
            problem.softness = 1.0
        return run

    def _start(self, factor: float) -> tuple[Floats, Floats]:
        """Displacements where springs at all points hold the sides together where they are nearest.

        Springs push and pull: the state is that of a contact that is closed everywhere.
        """
        if factor not in self._starts:
            self._starts[factor] = self._held_by_springs(factor)
        return self._starts[factor]

    def _held_by_springs(self, factor: float) -> tuple[Floats, Floats]:
        problem = self._problem
        state = problem.state(*problem.zero(), factor)
        tension = problem.spring_forces(self._springs)
        tangent = problem.tangent(self._springs, friction=False)
        with self._timer("factorisation"):
            found = solved_regularly(tangent, problem.load_at(factor) + tension)
        free_tangent(tangent)
        if found is None:
            raise ConvergenceError(FREE, best=state)
        return found[0], found[1]

    def _result(self, state: State, path: Sequence[LoadStep]) -> SteadySliding:
        problem = self._problem
        tangent = problem.tangent(problem.slopes(state.closures))
        with self._timer("factorisation"):
            uniqueness, uncertainty = uniqueness_at(tangent, state.x, state.f, path_parities(path))
        free_tangent(tangent)
        if uncertainty is None:
            raise ConvergenceError(LEAVE_FREE, best=state)
        return SteadySliding(
            displacement=problem.vector(state.x),
            uncertainty=uncertainty,
            residual=state.relative,
            contacts={
                contact.name: _contact_state(contact, closure)
                for contact, closure in zip(problem.contacts, state.closures, strict=True)
            },
            path=tuple(path),
            uniqueness=uniqueness,
        )

    def _reason(self, run: Iteration, factor: float) -> str:
        """Why there is no equilibrium."""
        if not closed_points(run.state) or self._pulls(factor):
            return OPENS
        reason = (
            f"no state of steady sliding was found at {factor:.3g} of the load: the residual is "
            f"{run.state.relative:.1e} of the forces"
        )
        if any(self._problem.frictional):
            smooth = SlidingProblem(self._problem.system, friction=False)
            without = SlidingNewton(smooth, self._springs, self._timer)
            if without.solve(*self._start(factor), factor).converged:
                reason += "; without friction there is one: friction is too large"
            smooth.free()
        return reason

    def _pulls(self, factor: float) -> bool:
        """Whether springs that hold the sides together are in tension, taken together."""
        problem = self._problem
        x = problem.vector(self._start(factor)[0])
        force = sum(
            float(contact.interface.points.weight @ (slope * contact.reactions.approach(x)))
            - float(contact.interface.points.weight @ (slope * gap.min()))
            for contact, slope, gap in zip(
                problem.contacts, self._springs, problem.gaps, strict=True
            )
        )
        destroy(x)
        return force <= 0


def path_parities(path: Sequence[LoadStep]) -> dict[float, int | None]:
    """Parity of negative eigenvalues of the tangent by part of the load."""
    return {step.factor: step.parity for step in path}


def _load_step(factor: float, run: Iteration) -> LoadStep:
    return LoadStep(factor, tuple(run.residuals), tuple(run.lengths), tuple(run.closed), run.parity)


def _closed_slopes(problem: SlidingProblem) -> list[Floats]:
    """Secant slope of each contact where the whole load presses all of it evenly (N/m^3)."""
    slopes = []
    for number, (gap, area) in enumerate(zip(problem.gaps, problem.areas, strict=True)):
        law, overlap = problem.law(number), -float(gap.min())
        interface = problem.contacts[number].interface
        size = min(interface.a.mesh_size, interface.b.mesh_size)
        closure = max(law.closure(problem.load / area), overlap if overlap > _OVERLAP * size else 0)
        if not closure > 0:
            raise ConvergenceError(f"{OPENS}; nothing presses the sides together", best=None)
        pressure = float(law.pressure(np.array(closure)))
        slopes.append(np.full(len(gap), pressure / closure))
    return slopes


def _contact_state(contact: Contact, closure: Floats) -> ContactState:
    half, points = contact.half, contact.interface.points
    pressure = half.law.pressure(closure)
    weighted = points.weight * pressure
    force = -(weighted @ points.normal)
    friction = 0.0
    if half.friction is not None and half.friction.acts:
        rubbing = weighted * half.friction.mu
        friction = float(rubbing.sum())
        force = force + rubbing @ half.friction.direction.at(points.x, points.normal)
    return ContactState(
        closure=closure,
        pressure=pressure,
        stiffness=half.law.slope(closure),
        normal_force=float(weighted.sum()),
        friction_force=friction,
        force_on_a=force,
        closed_area=float(points.weight[closure > 0].sum()),
        area=float(points.weight.sum()),
    )
