"""Computed eigenvalues of two layers in frictional contact beside the exact ones."""

import numpy as np

from exact_cea.reference import whole_spectrum
from scenes import load_scene, run_modes

MU = 0.3
HIGHEST = 2.9
"""Upper end of the compared angular frequencies."""


def worst_error(backend: str) -> float:
    """Largest distance of an exact eigenvalue to the nearest computed one, relative to it."""
    result = run_modes(load_scene("blocks", backend=backend))
    exact = whole_spectrum("blocks", mu=str(MU), p=1, max_frequency=HIGHEST).values
    distances = np.abs(result.eigenvalues[:, None] - exact).min(axis=0)
    return float((distances / np.abs(exact)).max())


if __name__ == "__main__":
    for backend in ("fe", "iga"):
        print(backend, worst_error(backend))
