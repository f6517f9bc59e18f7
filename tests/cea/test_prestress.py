"""Geometric stiffness of a prestress: exact waves and buckling, rotations, scenes that have it."""

import numpy as np
import pytest
from bodies import PLASTIC, shape_body
from covering import covering
from motions import control_points
from petsc_matrices import to_numpy
from pressed import pressed_blocks
from scipy.linalg import eigh

from cea.supports.boundary import Support
from meshes.shapes import Box, Rectangle
from scenes import read_scene, run_scene

E, NU, RHO = 2.0, 0.3, 1.5
LAM, MU = PLASTIC.lame
HEIGHT = 1.0


def slab(backend, dim, *supports):
    """A box of which the faces hold some components."""
    shape = Box((0.7, HEIGHT, 0.5)) if dim == 3 else Rectangle((0.7, HEIGHT))
    cell = None if backend == "iga" else {2: "quadrilateral", 3: "hexahedron"}[dim]
    held = [Support(face, tuple(axes)) for face, axes in supports]
    return shape_body(shape, cell, 3, (1, 5, 1)[:dim], supports=held)


def geometric(body, gradient):
    """K_geo of a body whose displacement has a uniform gradient."""
    return to_numpy(body.geometric_stiffness((control_points(body) @ gradient.T).ravel()))


@pytest.mark.parametrize(
    ("backend", "dim", "stress"), covering(["iga", "fe"], [2, 3], [0.3, -0.3, -MU])
)
def test_thickness_shear_waves_of_a_stretched_slab(backend, dim, stress):
    """u_x = sin(k y) where faces hold u_y: rho omega^2 = (mu + sigma) k^2, 0 at sigma = -mu."""
    held = [("x_min", "y"), ("x_max", "y"), ("y_min", "xy"), ("y_max", "xy")]
    body = slab(backend, dim, *held, *[("z_min", "z"), ("z_max", "z")][: 2 * (dim - 2)])
    across = -NU if dim == 3 else -NU / (1 - NU)
    rate = stress / E if dim == 3 else stress * (1 - NU**2) / E  # uniform tension along y
    stretch = rate * np.diag([across, 1.0, across][:dim])
    stiffness = to_numpy(body.stiffness()) + geometric(body, stretch)
    found = eigh(stiffness, to_numpy(body.mass()), eigvals_only=True)
    scale = MU * (np.pi / HEIGHT) ** 2 / RHO
    relative = 1 + stress / MU
    assert np.abs(found - scale * relative).min() < 1e-5 * scale * abs(relative) + 1e-12 * scale


def test_it_equals_a_sum_over_points(backend):
    """Of any stress S: the integral of S : (grad u^T grad v) over a slab."""
    body = slab(backend, 2)
    gradient, first, second = np.random.default_rng(4).standard_normal((3, 2, 2))
    K_geo, x = geometric(body, gradient), control_points(body)
    stress = LAM * np.trace(gradient) * np.eye(2) + MU * (gradient + gradient.T)
    exact = 0.7 * HEIGHT * np.sum(stress * (first.T @ second))
    found = (x @ first.T).ravel() @ K_geo @ (x @ second.T).ravel()
    assert found == pytest.approx(exact, rel=1e-11)


def test_waves_along_a_pressed_column(backend):
    """Two layers between rollers, pressed: rods along the axis of lambda + 2 mu - pressure."""
    pressure = 0.05
    data = pressed_blocks(
        backend, {"method": "gpts", "points": 3}, c_n=1e4, mu=0.0, pressure=pressure
    )
    lower = data["bodies"]["lower"]
    lower["geometry"] = {"shape": "box", "size": [0.5, 0.6, 0.4], "origin": [0.2, 0.3, 0.0]}
    walls = ("x_min", "x_max", "y_min", "y_max")
    mesh = {"degree": 3, "elements": [1, 1, 2]}
    for body in data["bodies"].values():
        body["supports"] = [{"surface": face, "components": [face[0]]} for face in walls]
        body["mesh"] = {"fe": mesh | {"cell": "hexahedron"}, "iga": mesh | {"degree": [3, 3, 3]}}
    lower["supports"].append({"surface": "z_min", "components": ["z"]})
    # The layer of the contact is next to rigid: it closes by 5e-6 of a height of 0.7.
    exact = np.sqrt((LAM + 2 * MU - pressure) / RHO) / (4 * 0.7)
    for geometric_stiffness in (True, False):
        options = {"max_frequency": 0.55, "geometric_stiffness": geometric_stiffness}
        result = run_scene(read_scene(data | {"analysis": data["analysis"] | options}))
        error = np.abs(result.frequencies / exact - 1).min()
        assert error < 2e-4 if geometric_stiffness else error > 5e-3
