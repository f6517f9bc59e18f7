"""Full solves as blocks of real vectors that a basis takes in."""

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.modes import Modes
from cea.reduced.norm import EnergyNorm

_ALONE = 10.0
"""Condition number up to which an eigenvalue is by itself."""


def real_vectors(norm: EnergyNorm, modes: Modes) -> Floats:
    """Real and imaginary parts of right and left vectors, each complex vector of X-norm one.

    Of conjugate pairs of kappa one is enough; damped pencils have none. Phases are such that real
    parts are as long as can be.

    Parameters
    ----------
    norm
        X.
    modes
        Modes with left vectors.

    Returns
    -------
    ndarray
        The rows of this rank, shape (n_local, columns).
    """
    assert modes.left is not None
    one = (-(modes.eigenvalues**2)).imag >= 0
    if modes.pencil.damped:
        one[:] = True
    parts = [_parts(norm, modes.vectors[:, one])]
    if modes.left.vectors is not modes.vectors:
        parts.append(_parts(norm, modes.left.vectors[:, one]))
    return np.hstack(parts)


def forces_of(modes: Modes, rows: slice) -> Floats:
    """Real and imaginary parts of contact forces of modes and of their left vectors.

    Parameters
    ----------
    modes
        Modes with left vectors.
    rows
        The forces, among all of this rank.
    """
    assert modes.left is not None
    both = [modes.forces[rows], modes.left.forces[rows]]
    return np.hstack([part for each in both for part in (each.real, each.imag)])


def _parts(norm: EnergyNorm, vectors: Complexes) -> Floats:
    square = norm.comm.allreduce(np.einsum("ij,ij->j", vectors, vectors))
    vectors = vectors * np.exp(-0.5j * np.angle(square))
    real, imaginary = np.asfortranarray(vectors.real), np.asfortranarray(vectors.imag)
    of_imaginary = norm.lengths(imaginary)
    lengths = np.hypot(norm.lengths(real), of_imaginary)
    turning = of_imaginary > np.finfo(float).eps * lengths
    return np.hstack([real / lengths, (imaginary / lengths)[:, turning]])


def rounding_of(modes: Modes) -> float:
    """What errors of a full solve come to for kappa of condition one (1/s^2), at most.

    Modes near a coalescence, whose uncertainty is that of a cluster, tell nothing of it.
    """
    alone = modes.conditions < _ALONE
    sizes = 2 * modes.speeds * modes.growth_uncertainties / modes.conditions
    return float(sizes[alone].max(initial=0.0))
