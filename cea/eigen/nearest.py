"""The few eigenvalues nearest to a place.

About a real shift they are those of a disc whose radius follows from the Ritz values. With damping
or rotation the disc is about a real shift beside the place, and large enough to hold the disc about
the place: what it costs is a window up to there.
"""

import numpy as np

from cea.arrays import Complexes
from cea.eigen.block_krylov import krylov_schur
from cea.eigen.dense import Radius
from cea.eigen.options import KrylovOptions
from cea.eigen.pencil import Matrices
from cea.eigen.shift_invert import Companion, Undamped
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError

_SHIFT = 0.25
"""Real shift relative to the modulus of a place."""
_ASIDE = 1e-3
"""Step of the shift aside, relative to itself, where it is an eigenvalue."""
_STEPS = 4
"""Most such steps."""
_EDGE = 1 + 1e-9
"""Radius of a disc relative to the farthest eigenvalue in it: conjugates are equally far."""


def nearest(
    matrices: Matrices, kappa: float, wanted: int, options: KrylovOptions
) -> tuple[InvariantSubspace, Undamped]:
    """Invariant subspace of the eigenvalues nearest to kappa (1/s^2), and the operator there.

    Parameters
    ----------
    matrices
        The pencil at given parameters, without damping and rotation.
    kappa
        A real number; next to it where it is an eigenvalue.
    wanted
        Number of eigenvalues; a conjugate more may come.
    options
        Options of the method.

    Raises
    ------
    ConvergenceError
        When fewer converge.
    """
    wanted = min(wanted, matrices.size - matrices.tied)

    def radius(theta: Complexes) -> float:
        if len(theta) < wanted:
            return np.inf
        return _EDGE / float(np.sort(np.abs(theta))[-wanted])

    for step in range(_STEPS):
        try:
            op = Undamped(matrices, kappa * (1 + step * _ASIDE), np.inf)
            return _searched(op, radius, options), op
        except ConvergenceError:
            if step + 1 == _STEPS or not kappa:
                raise
    raise AssertionError


def nearest_damped(
    matrices: Matrices, place: complex, wanted: int, options: KrylovOptions
) -> tuple[InvariantSubspace, Undamped]:
    """The same of the eigenvalues with Im lambda >= 0 nearest to a place (1/s), and some more.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    place
        lambda, Im lambda >= 0; not zero.
    wanted, options
        As of :func:`nearest`.

    Raises
    ------
    ConvergenceError
        When fewer converge.
    """
    shift = _SHIFT * abs(place)

    def radius(theta: Complexes) -> float:
        values = shift + 1 / theta
        distances = np.sort(np.abs(values - place)[values.imag >= 0])
        if len(distances) < min(wanted, matrices.size - matrices.tied):
            return np.inf
        return _EDGE * float(abs(place - shift) + distances[:wanted][-1])

    op = Companion(matrices, shift, abs(place))
    op.reach = np.inf
    return _searched(op, radius, options), op


def _searched(op: Undamped, radius: Radius, options: KrylovOptions) -> InvariantSubspace:
    try:
        return krylov_schur(op, radius, options, verify=False)
    except ConvergenceError:
        op.free()
        raise
