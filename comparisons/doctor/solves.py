"""A solve of a second on each backend, the eigenvalues of which are known."""

from time import perf_counter

import numpy as np

from comparisons.doctor.finding import Finding
from scenes.spec.body import Backend

_SCENE = "blocks"
_COARSE = {
    "bodies.upper.mesh": {
        "fe": {"cell": "quadrilateral", "degree": 3, "elements": [8, 3]},
        "iga": {"degree": [3, 3], "elements": [8, 3]},
    },
    "bodies.lower.mesh": {
        "fe": {"cell": "quadrilateral", "degree": 3, "elements": [7, 4]},
        "iga": {"degree": [3, 3], "elements": [7, 4]},
    },
}
_EXACT = (1.374601231794j, 1.767482480613j, 1.825025163132j, 1.953583329521j, 2.024977609479j)
"""The first five, by ``cea exact blocks --count 5``."""
_TOLERANCE = 1e-4
"""Relative error of eigenvalues on such meshes."""


def mpi() -> Finding:
    """The MPI library that PETSc and its Python packages share."""
    try:
        from cea.petsc import MPI
    except Exception as fault:  # a library that does not load says so in many ways
        return Finding("MPI", f"{fault}".splitlines()[0], "make distclean setup")
    lines = MPI.Get_library_version().split("\n")
    return Finding("MPI", " ".join(" ".join(lines[:1]).split()))


def solve(backend: Backend) -> Finding:
    """Modes of two blocks in contact, beside exact eigenvalues."""
    name = f"solve on {backend}"
    start = perf_counter()
    try:
        error = worst_error(backend)
    except Exception as fault:  # whatever it is, it is what the doctor is asked for
        told = f"{type(fault).__name__}: {fault}".splitlines()[0]
        return Finding(name, told, "make distclean setup; should it stay, tell what this says")
    told = f"{perf_counter() - start:.1f} s, error {error:.0e}"
    if error > _TOLERANCE:
        return Finding(name, f"{told}: wrong eigenvalues", "make distclean setup")
    return Finding(name, told)


def worst_error(backend: Backend) -> float:
    """Largest relative error of the eigenvalues of the two blocks."""
    from scenes import run_modes
    from scenes.spec.reading import load_scene

    scene = load_scene(_SCENE, backend=backend).change(_COARSE)
    found = run_modes(scene).eigenvalues
    exact = np.array(_EXACT)
    nearest = np.abs(found[None] - exact[:, None]).min(axis=1)
    return float((nearest / np.abs(exact)).max())
