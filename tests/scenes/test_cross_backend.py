"""Both backends against each other where no closed form exists."""

import numpy as np
import pytest

from scenes import run_scene
from scenes.spec.reading import read_scene

BLOCK = {"shape": "box", "size": [1.0, 0.7, 0.4]}
QUARTER = {
    "shape": "sector", "inner_radius": 1.0, "outer_radius": 2.0, "start": 0.0, "end": 90.0,
    "bottom": 0.0, "top": 0.5,
}  # fmt: skip


def free_eigenvalues(geometry, max_frequency, backend, mesh):
    """Squares of the angular frequencies of a free body with E = 1, nu = 0.3, rho = 1."""
    body = {
        "backend": backend,
        "geometry": geometry,
        "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
        "mesh": {backend: mesh},
    }
    scene = read_scene(
        {
            "name": "free",
            "bodies": {"body": body},
            "analysis": {"kind": "cea", "max_frequency": max_frequency},
        }
    )
    return run_scene(scene).modes.eigenvalues.imag ** 2


def assert_same_body(geometry, max_frequency, meshes, tolerance):
    """Six zero eigenvalues in each backend and the same first ten elastic ones."""
    kappa = {
        backend: free_eigenvalues(geometry, max_frequency, backend, mesh)
        for backend, mesh in meshes.items()
    }
    for values in kappa.values():
        assert np.abs(values[:6]).max() < 1e-9 * values[6]
    assert kappa["fe"][6:16] == pytest.approx(kappa["iga"][6:16], rel=tolerance)


@pytest.mark.slow
def test_free_block():
    meshes = {
        "fe": {"degree": 4, "elements": [6, 5, 3]},
        "iga": {"degree": [5, 5, 5], "elements": [8, 6, 4]},
    }
    assert_same_body(BLOCK, 0.7, meshes, 1e-5)


def test_free_quarter_annulus_on_coarse_meshes():
    meshes = {
        "fe": {"degree": 3, "elements": [4, 8, 2]},
        "iga": {"degree": [3, 3, 3], "elements": [6, 12, 3]},
    }
    assert_same_body(QUARTER, 0.4, meshes, 1e-3)


@pytest.mark.slow
def test_free_quarter_annulus():
    meshes = {
        "fe": {"degree": 4, "elements": [6, 20, 3]},
        "iga": {"degree": [4, 4, 4], "elements": [14, 24, 6]},
    }
    assert_same_body(QUARTER, 0.4, meshes, 1e-5)
