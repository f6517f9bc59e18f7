"""Systems of known eigenvalues written to files, and runs that read them again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np
from scipy.io import mmwrite, savemat
from scipy.linalg import block_diag
from scipy.sparse import csr_array, save_npz

from cea.arrays import Complexes, Floats
from cea.petsc import PETSc
from comparisons.stability.parts.problems import Answer, answer_of
from scenes.running.matrices import run_matrices
from scenes.spec.matrices import read_matrix_scene

Format = Literal["mat", "mtx", "npz", "petsc"]


@dataclass(frozen=True)
class Block:
    """Two unknowns: (lambda^2 + (c -+ i g) lambda + k -+ i f) = 0.

    Parameters
    ----------
    k, c, g, f
        Stiffness (1/s^2), damping, gyroscopic coupling (1/s), circulatory coupling (1/s^2).
    """

    k: float
    c: float = 0.0
    g: float = 0.0
    f: float = 0.0

    def eigenvalues(self) -> Complexes:
        """Its four eigenvalues."""
        signs = np.array([1j, -1j])
        half, rest = 0.5 * (self.c - signs * self.g), self.k - signs * self.f
        root = np.sqrt(half**2 - rest + 0j)
        larger = -half - np.where((half.conj() * root).real >= 0, root, -root)
        return np.concatenate([larger, rest / larger])  # no difference of what is nearly equal


def matrices_of(blocks: Sequence[Block]) -> dict[str, Floats]:
    """M, C and K of blocks, shape (2 n, 2 n)."""
    one, turn = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
    return {
        "M": np.eye(2 * len(blocks)),
        "C": block_diag(*(b.c * one + b.g * turn for b in blocks)),
        "K": block_diag(*(b.k * one + b.f * turn for b in blocks)),
    }


def transformed(matrices: Mapping[str, Floats], change: Floats) -> dict[str, Floats]:
    """The same system in other unknowns: T^T A T, what is symmetric so to the last bit."""
    changed = {}
    for name, matrix in matrices.items():
        product = change.T @ matrix @ change
        symmetric = (matrix == matrix.T).all()
        changed[name] = 0.5 * (product + product.T) if symmetric else product
    return changed


def upper(blocks: Sequence[Block]) -> list[complex]:
    """Eigenvalues of blocks with Im lambda >= 0."""
    values = np.concatenate([block.eigenvalues() for block in blocks])
    return values[values.imag >= 0].tolist()


@dataclass(frozen=True)
class OfFiles:
    """Matrices that are written to files and read again.

    Parameters
    ----------
    matrices
        M, K and perhaps C, shape (n, n).
    format
        Format of the files.
    analysis
        Fields of the analysis beside the window's end.
    """

    matrices: Mapping[str, Floats]
    format: Format = "npz"
    analysis: Mapping[str, Any] = field(default_factory=dict)

    def solve(self, max_frequency: float | None) -> Answer:
        """Write, read, and solve for the modes up to a frequency."""
        used = {name: matrix for name, matrix in self.matrices.items() if matrix.any()}
        with TemporaryDirectory() as folder:
            for name, matrix in used.items():
                _write(csr_array(matrix), Path(folder) / f"{name}.{self.format}")
            window = {"kind": "cea", "max_frequency": max_frequency or 1.0, **self.analysis}
            scene = read_matrix_scene(
                {
                    "name": "files",
                    "data": folder,
                    "files": {name: f"{name}.{self.format}" for name in used},
                    "mass": {"M": 1.0},
                    "damping": {"C": 1.0} if "C" in used else {},
                    "stiffness": {"K": 1.0},
                    "analysis": window,
                }
            )
            result = run_matrices(scene)
        threshold = result.analysis.growth_threshold
        return answer_of(result.modes, result.warnings, threshold, result.dofs)


def _write(matrix: csr_array, file: Path) -> None:
    match file.suffix:
        case ".mat":
            savemat(file, {"A": matrix})
        case ".mtx":
            mmwrite(file, matrix, precision=17)
        case ".npz":
            save_npz(file, matrix)
        case _:
            viewer = PETSc.Viewer().createBinary(str(file), "w", comm=PETSc.COMM_SELF)
            parts: Any = (matrix.indptr, matrix.indices, matrix.data)
            PETSc.Mat().createAIJ(matrix.shape, csr=parts, comm=PETSc.COMM_SELF).view(viewer)
            viewer.destroy()
