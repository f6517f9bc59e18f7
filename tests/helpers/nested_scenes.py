"""Scenes whose eigenvalues are known, on meshes that are too coarse, and their estimated errors."""

from pathlib import Path

import numpy as np
from reference_data import plane_meshes

from cea.eigen.matching import assign
from cea.matrices import gather
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


def parallel_numbers(name, backend, by):
    """What must not depend on the number of ranks: P by its image, estimates."""
    elements = {"fe": {"upper": [5, 2], "lower": [4, 2]}, "iga": {"upper": [4, 2], "lower": [3, 2]}}
    coarse = coarse_modes(name, backend, 2, 3.2, elements=elements[backend])
    fine = richer_scene(coarse.scene, by)
    step = prolongation(coarse.bodies, run_modes(fine).bodies)
    smooth, image = step.matrix.createVecs()
    smooth.set(1.0)
    step.matrix.mult(smooth, image)
    estimate = estimate_errors(coarse, fine)
    return {
        "size": list(step.matrix.getSize()),
        "norm": step.matrix.norm(),
        "image": [float(np.sum(gather(image) ** k)) for k in (1, 2, 3)],
        "defect": step.defect,
        "corrected": [[v.real, v.imag] for v in estimate.corrected.tolist()],
        "verdicts": estimate.verdicts,
    }


def parallel_remaining(backend):
    """Corrected eigenvalues of damped blocks and what remains of them."""
    changes = ["bodies.upper.damping={alpha=0.02,beta=0.01}", "bodies.lower.damping={beta=0.02}"]
    elements = {"upper": [4, 2], "lower": [3, 2]}
    estimate = estimate_errors(coarse_modes("blocks", backend, 2, 2.9, changes, elements))
    return {
        "corrected": [[v.real, v.imag] for v in estimate.corrected.tolist()],
        "remaining": estimate.remaining.tolist(),
    }
