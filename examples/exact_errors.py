"""Compare computed eigenvalues of two layers in frictional contact with exact ones."""

import numpy as np

from exact_cea.reference import whole_spectrum
from scenes import load_scene, run_modes

MU = 0.3
HIGHEST = 2.9
"""Highest angular frequency compared."""


def worst_error(backend: str) -> float:
    """Return the largest relative distance of an exact eigenvalue to the nearest computed one."""
    result = run_modes(load_scene("blocks", backend=backend))
    exact = whole_spectrum("blocks", mu=str(MU), p=1, max_frequency=HIGHEST).values
    distances = np.abs(result.eigenvalues[:, None] - exact).min(axis=0)
    return float((distances / np.abs(exact)).max())


if __name__ == "__main__":
    for backend in ("fe", "iga"):
        print(backend, worst_error(backend))
