"""Geometric stiffness of a prestress: exact waves and buckling, rotations, scenes that have it."""

import numpy as np
import pytest
from bodies import shape_body
from covering import covering
from motions import control_points, dense
from pressed import pressed_blocks
from scipy.linalg import eigh

from cea.material import IsotropicMaterial
from cea.supports.boundary import Support
from meshes.shapes import Box, Rectangle
from scenes import read_scene, run_scene

STEEL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
MU = STEEL.lame[1]
HEIGHT = 1.0
GPTS = {"method": "gpts", "points": 3}
BOTH_WAYS = [("x_min", "y"), ("x_max", "y"), ("y_min", "xy"), ("y_max", "xy")]


def slab(backend, dim, supports=()):
    """A box of which the faces hold some components."""
    shape = Box((0.7, HEIGHT, 0.5)) if dim == 3 else Rectangle((0.7, HEIGHT))
    cell = None if backend == "iga" else {2: "quadrilateral", 3: "hexahedron"}[dim]
    held = [Support(face, tuple(map("xyz".index, axes))) for face, axes in supports]
    return shape_body(shape, cell, 3, (1, 5, 1)[:dim], material=STEEL, supports=held)


def stretch(dim, stress):
    """Gradient of the displacement of a uniform tension along y (N/m^2)."""
    across = -STEEL.nu if dim == 3 else -STEEL.nu / (1 - STEEL.nu)
    rate = stress / STEEL.E if dim == 3 else stress * (1 - STEEL.nu**2) / STEEL.E
    return rate * np.diag([across, 1.0, across][:dim])


def geometric(body, gradient):
    """K_geo of a body whose displacement has a uniform gradient."""
    return dense(body.geometric_stiffness((control_points(body) @ gradient.T).ravel()))


@pytest.mark.parametrize(
    ("backend", "dim", "stress"), covering(["iga", "fe"], [2, 3], [0.3, -0.3, -MU])
)
def test_thickness_shear_waves_of_a_stretched_slab(backend, dim, stress):
    """u_x = sin(k y) where faces hold u_y: rho omega^2 = (mu + sigma) k^2, 0 at sigma = -mu."""
    body = slab(backend, dim, BOTH_WAYS + [("z_min", "z"), ("z_max", "z")][: 2 * (dim - 2)])
    stiffness = dense(body.stiffness()) + geometric(body, stretch(dim, stress))
    found = eigh(stiffness, dense(body.mass()), eigvals_only=True)
    exact = (MU + stress) * (np.pi / HEIGHT) ** 2 / STEEL.rho
    scale = MU * (np.pi / HEIGHT) ** 2 / STEEL.rho
    assert np.abs(found - exact).min() < 1e-5 * scale * abs(1 + stress / MU) + 1e-12 * scale


def test_it_equals_a_sum_over_points(backend):
    """Of any stress, by finite differences of the energy of a slab sampled without the backend."""
    body = slab(backend, 2)
    rng = np.random.default_rng(4)
    first, second = (rng.standard_normal((2, 2)) for _ in range(2))
    gradient = rng.standard_normal((2, 2))
    K_geo, x = geometric(body, gradient), control_points(body)
    u, v = (x @ first.T).ravel(), (x @ second.T).ravel()
    lam, mu = STEEL.lame
    stress = lam * np.trace(gradient) * np.eye(2) + mu * (gradient + gradient.T)
    exact = 0.7 * HEIGHT * np.sum(stress * (first.T @ second))
    assert u @ K_geo @ v == pytest.approx(exact, rel=1e-11)


def column(backend, pressure, **analysis):
    """Two layers between rollers, pressed by a load: stresses are uniform, and known."""
    data = pressed_blocks(backend, GPTS, c_n=1e4, mu=0.0, pressure=pressure)
    walls = [("x_min", "x"), ("x_max", "x"), ("y_min", "y"), ("y_max", "y")]
    lower = data["bodies"]["lower"]
    lower["geometry"] = {"shape": "box", "size": [0.5, 0.6, 0.4], "origin": [0.2, 0.3, 0.0]}
    for name, ground in (("upper", "z_max"), ("lower", "z_min")):
        body = data["bodies"][name]
        body["supports"] = [{"surface": face, "components": [axis]} for face, axis in walls]
        mesh = {"degree": 3, "elements": [1, 1, 2]}
        body["mesh"] = {"fe": mesh | {"cell": "hexahedron"}, "iga": mesh | {"degree": [3, 3, 3]}}
        if name == "lower":
            body["supports"].append({"surface": ground, "components": ["z"]})
    data["analysis"] |= {"max_frequency": 0.55} | analysis
    return data


def test_waves_along_a_pressed_column(backend):
    """Along its axis two layers are rods of the modulus lambda + 2 mu - pressure."""
    pressure = 0.05
    result = run_scene(read_scene(column(backend, pressure, geometric_stiffness=True)))
    modulus = sum(STEEL.lame) + MU - pressure
    height, layer = 0.7, pressure / 1e4  # the layer of the contact is next to rigid
    assert layer < 1e-5
    frequency = np.sqrt(modulus / STEEL.rho) / (4 * height)
    assert np.abs(result.frequencies - frequency).min() < 2e-4 * frequency
    plain = run_scene(read_scene(column(backend, pressure)))
    assert np.abs(plain.frequencies - frequency).min() > 5e-3 * frequency
