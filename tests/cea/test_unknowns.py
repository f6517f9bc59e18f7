"""Operators on full dofs as operators on unknowns, against dense products with expansions."""

import gc
from functools import cache

import numpy as np
import pytest
from blocks import two_blocks
from lagrange_bodies import csr
from scipy.sparse import csr_array, random_array
from supported import ABOUT_Z, BOX, RING, build, on

from cea.body.unknowns import free_operator
from cea.contact.interface import along, jump_along
from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_interfaces
from scenes.spec.reading import read_scene

RNG = np.random.default_rng(3)
SUPPORTS = {
    "free": (BOX, []),
    "held": (BOX, [{"surface": "x_min"}, {"surface": "z_max", "components": ["y"]}]),
    "oblique": (RING, on(("inner", "outer"), "radial", **ABOUT_Z)),
}


@pytest.fixture
def bodies(backend):
    """A free body, one whose supports select dofs, one whose supports mix them."""
    return _bodies(backend)


@cache
def _bodies(backend):
    return {
        name: build(backend, shape, supports, [2, 8, 1] if shape is RING else [2, 2, 1])
        for name, (shape, supports) in SUPPORTS.items()
    }


def operator_on(body, rows, density=0.02):
    size = body.dim * body.num_scalar_dofs
    rng = np.random.default_rng(size)
    return csr_array(random_array((rows, size), density=density, format="csr", rng=rng))


def test_matrices_outlive_the_bodies_they_are_made_for(backend):
    body = build(backend, *SUPPORTS["held"], [2, 2, 1])
    matrices = [free_operator(operator_on(body, 20), body), body.stiffness(), body.mass()]
    entries = [csr(matrix) for matrix in matrices]
    del body
    gc.collect()
    for matrix, kept in zip(matrices, entries, strict=True):
        x, y = matrix.createVecs()
        x.array[:] = RNG.random(x.getSize())
        matrix.mult(x, y)
        np.testing.assert_allclose(y.array, kept @ x.array, rtol=1e-13, atol=1e-13)


def touching(backend, angle):
    """Interface of two blocks, turned, on meshes that do not match."""
    placement = {"axis": [1.0, 2.0, 0.5], "angle": angle}
    data = two_blocks(backend, {"method": "gpts", "points": 3}, placement if angle else None)
    scene = read_scene(data)
    bodies = build_bodies(scene, StageTimer())
    (interface,) = build_interfaces(scene, bodies, StageTimer()).values()
    return interface


@pytest.mark.parametrize("many", [False, True])
@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_components_without_a_part_have_no_entries(backend, angle, many, monkeypatch):
    """Of many points a plane along axes needs one component, any other plane three."""
    interface = touching(backend, angle)
    if many:
        monkeypatch.setattr("cea.contact.interface._MANY_POINTS", 1)
    normal = interface.local_points.normal.copy()
    if not angle:
        normal[:, 0], normal[:, 1] = 0.0, 1e-17
    traces = interface.trace_a, interface.trace_b
    components = 3 if angle else 1 if many else 2
    for sign, jump, trace in zip((1, -1), jump_along(interface, normal), traces, strict=True):
        whole = along(trace, sign * normal)
        assert whole.nnz == 3 * trace.nnz
        assert jump.nnz == components * trace.nnz
        assert abs(jump - whole).max() <= 1e-16
