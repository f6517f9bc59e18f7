"""What the matrices of a free body must do, whatever program made them."""

from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, kron
from scipy.sparse.linalg import eigsh

from cea.arrays import Floats

_RIGID = 6
"""Rigid motions in space."""
_BELOW = 1e-3
"""Shift below zero, as part of the smallest ratio of diagonals: K of a free body is singular."""


def checked(K: csr_array, M: csr_array, motions: Floats) -> dict[str, Any]:
    """Numbers that are the same for every program.

    Parameters
    ----------
    K, M
        Stiffness and mass of the free body.
    motions
        Coefficients of its rigid motions, shape (n, 6).

    Returns
    -------
    dict
        ``asymmetry`` of K and ``rigid``, the largest force of a rigid motion, both relative to the
        largest entry of K; ``inertia``, the mass of each rigid motion (three times the mass of the
        body, three moments of inertia).
    """
    largest = float(np.abs(K.data).max())
    apart = K - K.T
    forces = np.abs(K @ motions).max(axis=0) / np.abs(motions).max(axis=0)
    return {
        "asymmetry": float(np.abs(apart.data).max(initial=0.0)) / largest,
        "rigid": float(forces.max()) / largest,
        "inertia": np.einsum("im,im->m", motions, M @ motions).tolist(),
    }


def of_every_component(M: csr_array, size: int) -> csr_array:
    """Mass of a vector field of a size, given that of it or of one component of it."""
    return M if M.shape[0] == size else csr_array(kron(M, eye_array(size // M.shape[0])))


def lowest_eigenvalues(K: csr_array, M: csr_array, count: int) -> list[float]:
    """The lowest eigenvalues of the free body beyond the six zeros."""
    shift = -_BELOW * float((K.diagonal() / M.diagonal()).min())
    values = eigsh(
        csc_array(K), count + _RIGID, csc_array(M), sigma=shift, return_eigenvectors=False, v0=None
    )
    return np.sort(values)[_RIGID:].tolist()
