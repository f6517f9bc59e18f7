"""Scenes on meshes that are too coarse, dense eigenvalues of richer spaces, estimated errors."""

from pathlib import Path

import numpy as np
from petsc_matrices import gather
from reference_data import plane_meshes
from scipy.linalg import eigvals

from cea.eigen.matching import assign
from scenes import run_modes
from scenes.running.enrich import richer_scene
from scenes.running.nested import estimate_errors, prolongation
from scenes.spec.reading import load_scene

MESHES = {
    ("drum", "fe"): {"outer": [4, 24], "inner": [8, 16]},
    ("drum", "iga"): {"outer": [4, 48], "inner": [8, 40]},
    ("blocks", "fe"): {"upper": [16, 4], "lower": [10, 6]},
    ("blocks", "iga"): {"upper": [20, 4], "lower": [14, 6]},
}


def coarse_modes(name, backend, degree, highest, overrides=(), elements=None):
    """Modes up to a highest Im lambda (rad/s), with left vectors."""
    meshes = plane_meshes(backend, degree, elements or MESHES[name, backend])
    window = f"analysis.max_frequency={highest / (2 * np.pi)!r}"
    scene = load_scene(Path(name), [*meshes, window, *overrides], backend)
    return run_modes(scene, left=True)


def paired(values, others):
    """Of each value the one among others that it stands for."""
    return others[assign(np.abs(values[:, None] - others))[1]]


def dense_eigenvalues(scene):
    """All lambda of lambda^2 M + lambda D + K, and what rounding does to lambda^2."""
    parts = {name: m.toarray() for name, m in run_modes(scene).matrices().items()}
    M, K = parts["M"], parts["K"] + parts["K_n"] - parts["K_f"]
    none = np.zeros_like(K)
    K = K + parts.get("K_c", none)
    if "L" in parts:
        K += parts["L"] @ np.linalg.solve(parts["N"], parts["J"])
    D = parts.get("C", none) + parts.get("Y", none)
    if "W" in parts:
        D = D + parts["W"] @ parts["W"].T
    K, D = np.linalg.solve(M, K), np.linalg.solve(M, D)
    size = np.sqrt(np.abs(K).max())
    one = np.eye(len(K))
    companion = np.block([[0 * one, one], [-K / size**2, -D / size]])
    return size * eigvals(companion), 1e-14 * size**2


def apart_from_richer(estimate, coarse, by="degree"):
    """Distances of corrected eigenvalues from those of the richer space, less dense rounding."""
    values, rounding = dense_eigenvalues(richer_scene(coarse.scene, by))
    apart = np.abs(estimate.corrected - paired(estimate.corrected, values))
    return np.maximum(apart - rounding / np.abs(estimate.corrected), 0.0)


def parallel_numbers(name, backend, by):
    """What must not depend on the number of ranks: P by its image, estimates."""
    elements = {"fe": {"upper": [5, 2], "lower": [4, 2]}, "iga": {"upper": [4, 2], "lower": [3, 2]}}
    coarse = coarse_modes(name, backend, 2, 3.2, elements=elements[backend])
    fine = richer_scene(coarse.scene, by)
    step = prolongation(coarse.bodies, run_modes(fine).bodies)
    smooth, image = step.createVecs()
    smooth.set(1.0)
    step.mult(smooth, image)
    estimate = estimate_errors(coarse, fine)
    return {
        "size": list(step.getSize()),
        "norm": step.norm(),
        "image": [float(np.sum(gather(image) ** k)) for k in (1, 2, 3)],
        "corrected": [[v.real, v.imag] for v in estimate.corrected.tolist()],
    }
