"""Matrices from files with coefficients that depend on a speed: flutter above v = 2."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.io import mmwrite
from scipy.sparse import csr_array

from scenes import AssembledMatrices, read_matrix_scene

MATRICES = {"M": np.eye(2), "K": 4 * np.eye(2), "F": np.array([[0.0, 1.0], [-1.0, 0.0]])}
SCENE = {
    "name": "two oscillators",
    "files": {name: f"{name}.mtx" for name in MATRICES},
    "parameters": {"v": 1.0},
    "mass": {"M": 1.0},
    "damping": {"M": 0.1},
    "stiffness": {"K": 1.0, "F": "v/10"},
    "analysis": {"kind": "cea", "max_frequency": 1.0},
}


def growth_rates(speeds: tuple[float, ...]) -> list[float]:
    """Return the largest growth rate (1/s) at each speed."""
    with TemporaryDirectory() as folder:
        for name, matrix in MATRICES.items():
            mmwrite(Path(folder) / f"{name}.mtx", csr_array(matrix))
        assembled = AssembledMatrices(read_matrix_scene(SCENE | {"data": folder}))
    return [assembled.modes({"parameters.v": v}).growth_rates.max() for v in speeds]


if __name__ == "__main__":
    for growth in growth_rates((1.0, 2.0, 4.0)):
        print(f"{growth:+.4f} 1/s")
