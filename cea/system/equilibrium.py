"""Whether a state of steady sliding is an equilibrium of the pencil that is linearised about it.

What is left of the forces is measured with the pieces of that pencil, the stiffness of bodies as
they rotate and of contacts where it is known, and with the forces of contacts that have a law.
"""

from dataclasses import replace

import numpy as np

from cea.arrays import Floats
from cea.eigen.pencil import Matrices, release
from cea.eigen.residuals import Sizes, internal_forces
from cea.errors import ConvergenceError
from cea.system.sliding_problem import SlidingProblem, State

LEFT_OVER = 1e-8
"""Part of the load up to which forces may be left over, whatever the reason."""


def checked_residual(problem: SlidingProblem, state: State, tangent: Matrices) -> float:
    """Forces left over in a state under the whole load, relative to the load; collective.

    Parameters
    ----------
    problem, state
        The equations and the state.
    tangent
        Their tangent there, by which rounding is measured.

    Raises
    ------
    ConvergenceError
        When they are more than 1e-8 of the load and more than rounding the entries of the tangent
        explains; the state is attached.
    """
    linear = tuple(contact for contact in problem.system.contacts if contact.half.law.linear)
    own = replace(problem.system, contacts=linear, sliding={}).pencil().at_rest().at()
    contact, load = problem.contact_forces(state.closures), problem.load_at(1.0)
    x, f = state.x[:, None], state.f[:, None]
    left = internal_forces(own, x, f)[:, 0] + contact - load
    norm, of_load, of_contact = problem.norms(left, load, contact)
    size = of_load or of_contact or 1.0
    if norm > LEFT_OVER * size:
        rounding = _rounding(problem, tangent, x, f)
        if norm > rounding:
            release(own)
            raise ConvergenceError(
                f"the state of steady sliding is no equilibrium: {norm / size:.1e} of the load is "
                f"left over, where rounding comes to {rounding / size:.1e}",
                best=state,
            )
    release(own)
    return float(norm / size)


def _rounding(problem: SlidingProblem, tangent: Matrices, x: Floats, f: Floats) -> float:
    """What rounding the entries of a tangent makes of the forces (N)."""
    sizes = Sizes(tangent)
    forces = sizes.forces(x, f)
    sizes.free()
    (norm,) = problem.norms(np.finfo(float).eps * forces[:, 0])
    return float(norm)
