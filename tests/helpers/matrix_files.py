"""Small systems as files: a damped gyroscopic circulatory one that depends on a speed."""

import sys
from pathlib import Path
from runpy import run_path
from tempfile import TemporaryDirectory
from unittest.mock import patch
from warnings import catch_warnings

import numpy as np
from petsc_matrices import quadratic_eigenvalues as companion
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, save_npz

from cea.errors import InputError

N = 24


def read_here(program, file):
    """What a program of :mod:`meshes.files.reading` reads, without starting another python.

    Programs that read meshes leave gmsh initialised.
    """
    with TemporaryDirectory() as folder:
        arrays = Path(folder) / "arrays.npz"
        try:
            argv = ["", str(file), str(arrays)]
            with catch_warnings(action="ignore"), patch.object(sys, "argv", argv):
                run_path(str(program), run_name="__main__")
        except SystemExit as end:
            raise InputError("file", str(file), f"a whole {file.suffix} file ({end})") from None
        finally:
            if "gmsh" in sys.modules and sys.modules["gmsh"].isInitialized():
                sys.modules["gmsh"].finalize()
        with np.load(arrays) as read:
            return dict(read)


def pieces(seed=1):
    """Matrices by name: M, D symmetric, G skew, K symmetric, F of friction, Q of rotation."""
    rng = np.random.default_rng(seed)
    half = rng.standard_normal((N, N)) / np.sqrt(N)
    basis = np.eye(N) + 0.3 * half
    M = basis @ basis.T
    D = 0.02 * half @ half.T
    G = 0.02 * (half - half.T)
    K = basis @ np.diag(np.linspace(1.0, 40.0, N)) @ basis.T
    F = np.zeros((N, N))
    F[:6, :6] = 8.0 * half[:6, :6]
    Q = np.diag(np.linspace(0.0, 0.2, N))
    made = {"M": M, "D": D, "G": G, "K": K, "F": F, "Q": Q}
    return {
        name: matrix if name in "GF" else 0.5 * (matrix + matrix.T) for name, matrix in made.items()
    }


def write(folder, matrices):
    """Write them, each in another format."""
    mmwrite(folder / "M.mtx", csr_array(matrices["M"]), precision=17)
    savemat(folder / "both.mat", {"D": csr_array(matrices["D"]), "G": csr_array(matrices["G"])})
    for name in "KFQ":
        save_npz(folder / f"{name}.npz", csr_array(matrices[name]))
    return folder


def scene(folder="", speed=2.0, **analysis):
    """A scene of them as plain data."""
    files = {"M": "M.mtx", "D": "both.mat:D", "G": "both.mat:G"}
    return {
        "name": "speed",
        "data": str(folder),
        "files": files | {name: f"{name}.npz" for name in "KFQ"},
        "parameters": {"v": speed, "v0": 1.0, "mu": 0.7},
        "mass": {"M": 1.0},
        "damping": {"D": "1 + v0/v", "G": "v/v0"},
        "stiffness": {"K": 1, "F": "mu", "Q": "(v/v0)**2 - 1"},
        "analysis": {"kind": "cea", "max_frequency": 0.6, "min_growth": -1.0, **analysis},
    }


def undamped(mass, stiffness, top, **fields):
    """A scene of M and K from two files, up to a frequency (Hz)."""
    return {
        "name": "chain",
        "files": {"M": str(mass), "K": str(stiffness)},
        "mass": {"M": 1.0},
        "stiffness": {"K": 1.0},
        "analysis": {"kind": "cea", "max_frequency": top},
        **fields,
    }


def dense(matrices, speed=2.0, mu=0.7):
    """All eigenvalues at a speed, by the companion form."""
    M = matrices["M"]
    C = (1 + 1 / speed) * matrices["D"] + speed * matrices["G"]
    K = matrices["K"] + mu * matrices["F"] + (speed**2 - 1) * matrices["Q"]
    return companion(M, C, K)


def inside(values, max_frequency=0.6, min_growth=-1.0):
    """Those of a window, by rising frequency."""
    top = 2 * np.pi * max_frequency
    chosen = values[(values.imag >= 0) & (values.imag <= top) & (values.real >= min_growth)]
    return chosen[np.argsort(chosen.imag)]
