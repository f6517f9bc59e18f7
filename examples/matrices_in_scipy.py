"""Solve for an eigenvalue with scipy, from the scipy.sparse matrices of a scene."""

import numpy as np
from scipy.sparse.linalg import eigs

from scenes import load_scene, run_modes


def eigenvalue_by_scipy() -> tuple[complex, complex]:
    """Return the eigenvalue lambda nearest to 1.5i, by scipy and by the program."""
    result = run_modes(load_scene("blocks"))
    K, M, K_n, K_f = (result.matrices()[name] for name in ("K", "M", "K_n", "K_f"))
    (kappa,) = eigs(K + K_n - K_f, 1, M, sigma=1.5**2, return_eigenvectors=False)
    found = 1j * np.sqrt(complex(kappa))
    ours = result.eigenvalues
    return found, complex(ours[np.abs(ours - found).argmin()])


if __name__ == "__main__":
    print(*eigenvalue_by_scipy())
