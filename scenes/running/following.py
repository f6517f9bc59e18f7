"""Thresholds along which the state of steady sliding is sought anew at every value."""

from collections.abc import Callable

import numpy as np

from cea.arrays import Complexes
from cea.eigen.blocks import all_inner, times
from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.residuals import internal_forces
from cea.errors import ConvergenceError
from cea.system.coupled import CoupledSystem

_STEP = 1e-5
"""Step of difference quotients of matrices, relative to the value."""


class FollowedState:
    """Full solves of a system linearised about its state of steady sliding at each value.

    Parameters
    ----------
    scale
        Size of the values.
    system_at
        The system at a value.

    Attributes
    ----------
    solves, factorisations
        Eigenvalue problems solved, and matrices factorised for them.
    """

    def __init__(self, scale: float, system_at: Callable[[float], CoupledSystem]) -> None:
        self._step, self._system_at = _STEP * scale, system_at
        self.solves = self.factorisations = 0

    def modes(self, value: float, max_frequency: float) -> Modes:
        """All modes up to a frequency (Hz), with left vectors."""
        with EigenSolver(self._system_at(value).pencil()) as driver:
            modes = driver.solve(max_frequency, left=True)
            self.solves += driver.solves
            self.factorisations += driver.factorisations
        return modes

    def derivatives(self, value: float, modes: Modes) -> Complexes:
        """Derivatives of their lambda by difference quotients of the matrices, shape (n,).

        Raises
        ------
        ConvergenceError
            When the forms of contacts change there.
        """
        low, high = (self._system_at(value + way * self._step).pencil() for way in (-1.0, 1.0))
        change = _works(high, modes) - _works(low, modes)
        with np.errstate(divide="ignore", invalid="ignore"):
            return -change / (2 * self._step) / (2 * modes.eigenvalues)


def _works(pencil: Pencil, modes: Modes) -> Complexes:
    """y^H P(lambda) x of another pencil at modes and their contact forces, shape (n,)."""
    assert modes.left is not None
    matrices, x, f = pencil.at(), modes.vectors, modes.forces
    y, g, roots = modes.left.vectors, modes.left.forces, modes.eigenvalues
    forces = 0 if matrices.multipliers is None else matrices.multipliers.closure.getLocalSize()[0]
    if forces != len(f):
        raise ConvergenceError("the form of a contact changes with the parameter: fix it")
    force = internal_forces(matrices, x, f) + times(matrices.mass, x) * roots**2
    force += _drag(matrices, x) * roots
    works = np.diag(all_inner(y, force, pencil.comm)).copy()
    if matrices.multipliers is not None:
        gap = times(matrices.multipliers.closure, x) - times(matrices.multipliers.compliance, f)
        works += np.diag(all_inner(g, gap, pencil.comm))
    release(matrices)
    return works


def _drag(matrices: Matrices, x: Complexes) -> Complexes:
    """D x of damping and rotation."""
    drag = np.zeros_like(x)
    for part in (matrices.damping, matrices.gyroscopic):
        if part is not None:
            drag += times(part, x)
    if matrices.low_rank is not None:
        drag += matrices.low_rank.times(x)
    return drag
