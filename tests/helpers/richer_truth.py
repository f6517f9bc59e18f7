"""Dense eigenvalues of a richer space beside the corrected ones of a coarse mesh."""

import numpy as np
from nested_scenes import paired
from scipy.linalg import eigvals

from scenes import run_modes
from scenes.running.enrich import richer_scene


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
