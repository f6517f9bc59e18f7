"""Stiffness of stresses and pressures: exact waves and buckling, rotations, scenes that have it."""

import numpy as np
import pytest
from blocks import rectangle
from bodies import FLAT, PLANE, PLASTIC, ROUND, SPACE, shape_body
from covering import covering
from motions import asymmetry, control_points, rigid_motions
from petsc_matrices import to_numpy
from pressed import pressed_blocks
from scipy.linalg import eigh
from scipy.optimize import brentq

from cea.supports.boundary import Pressure, Spring, Support
from meshes.shapes import Box, Rectangle
from scenes import read_scene, run_scene

E, NU, RHO = 2.0, 0.3, 1.5
LAM, MU = PLASTIC.lame
HEIGHT = 1.0


def solid(backend, dim, shapes, degree=2, elements=(2, 8, 1), **options):
    """A body of the shape of its dimension."""
    cell = None if backend == "iga" else {2: "quadrilateral", 3: "hexahedron"}[dim]
    return shape_body(shapes[dim], cell, degree, elements[:dim], **options)


def slab(backend, dim, *supports):
    """A box of which the faces hold some components."""
    shapes = {3: Box((0.7, HEIGHT, 0.5)), 2: Rectangle((0.7, HEIGHT))}
    held = [Support(face, tuple(axes)) for face, axes in supports]
    return solid(backend, dim, shapes, 3, (1, 5, 1), supports=held)


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


@pytest.mark.parametrize(("backend", "dim"), covering(["iga", "fe"], [2, 3]))
def test_a_body_under_pressure_all_round_turns_freely(backend, dim):
    """K_geo and the stiffness of the pressure cancel for rotations of a box, and are symmetric."""
    pressures = [Pressure(f"{axis}_{end}", 0.2) for axis in "xyz"[:dim] for end in ("min", "max")]
    body = solid(backend, dim, FLAT, placement=SPACE if dim == 3 else PLANE, pressures=pressures)
    K_geo = geometric(body, -0.2 / (dim * LAM + 2 * MU) * np.eye(dim))
    ((K_load, symmetric),) = body.load_stiffness()
    turns = rigid_motions(control_points(body))[:, dim:]
    assert symmetric
    assert asymmetry(K_load) == 0.0
    force = K_geo @ turns
    assert np.abs(force + to_numpy(K_load) @ turns).max() < 1e-12 * np.abs(force).max()


@pytest.mark.parametrize(("backend", "dim"), covering(["iga", "fe"], [2, 3]))
def test_a_pressure_grows_with_its_face(backend, dim):
    """A box that is stretched along y by a tenth: its load changes by - K_load u."""
    size, pressure = (1.0, 0.8, 0.5)[:dim], [Pressure("x_max", 0.2)]
    stretched = (1.0, 0.88, 0.5)[:dim]
    shapes = ({2: Rectangle, 3: Box}[dim](each) for each in (size, stretched))
    before, after = (solid(backend, dim, {dim: shape}, pressures=pressure) for shape in shapes)
    stiffness = sum(to_numpy(matrix) for matrix, _ in before.load_stiffness())
    moved = (control_points(after) - control_points(before)).ravel()
    change = after.full_load() - before.full_load()
    assert np.abs(change + stiffness @ moved).max() < 1e-12 * np.abs(change).max()


def test_the_rotation_of_a_ring_under_pressure(backend):
    """On springs: its frequency is that without pressure, but for strains of 2e-3."""
    springs, pressures = [Spring("inner", (0.01, 0.01))], [Pressure("outer", 2e-3)]
    body = solid(backend, 2, ROUND, springs=springs, pressures=pressures)
    K, M = to_numpy(body.stiffness()), to_numpy(body.mass())
    K_geo = to_numpy(body.geometric_stiffness(np.linalg.solve(K, body.load().array_r)))
    ((K_load, _),) = body.load_stiffness()
    turn = rigid_motions(control_points(body))[:, 2]
    free, dead, following = (turn @ each @ turn for each in (K, K + K_geo, to_numpy(K_load)))
    assert dead < 0.9 * free
    assert dead + following == pytest.approx(free, rel=5e-3)
    lowest = [eigh(each, M, eigvals_only=True)[0] for each in (K, K + K_geo + to_numpy(K_load))]
    assert lowest[1] == pytest.approx(lowest[0], rel=5e-3)


def becks_column(load):
    """The lowest frequency of a column under a force along its end (Beck, ZAMP 3, 1952, 225-228).

    In sqrt(EI / (rho A L^4)), for the load in EI / L^2.
    """

    def determinant(omega):
        root = np.sqrt(load**2 / 4 + omega**2)
        a, b = np.sqrt(root + load / 2), np.sqrt(root - load / 2)
        both = 2 * omega**2 * (1 + np.cos(a) * np.cosh(b))
        return load**2 + both + load * omega * np.sin(a) * np.sinh(b)

    return brentq(determinant, 3.0, 5.0)


def test_a_column_under_pressure_on_its_end(backend):
    """The pressure follows the end: beyond the load at which a dead one buckles it is stable."""
    load, height = 1.1 * np.pi**2 / 4, 0.02
    column = rectangle(backend, [1.0, height], [12, 1], degree=3, supports=[{"surface": "x_min"}])
    column["material"] = {"E": 2.0, "nu": 0.0, "rho": 1.5}
    upper, lower = (rectangle(backend, [0.2, 0.1], [1, 1], origin=[0, y]) for y in (3.0, 2.9))
    upper["supports"] = [{"surface": "y_max", "components": ["x"]}]
    lower["supports"] = [{"surface": "y_min"}]
    contact = {"a": "upper.y_min", "b": "lower.y_max", "formulation": {"method": "mortar"}}
    data = {"name": "column", "bodies": {"upper": upper, "lower": lower, "column": column}}
    data["contacts"] = {"interface": contact | {"c_n": 1e4}}
    pressures = {"upper.y_max": 1e-6, "column.x_max": load * 2.0 * height**2 / 12}
    data["loads"] = [{"surface": name, "pressure": p} for name, p in pressures.items()]
    unit = height * np.sqrt(2.0 / 1.5 / 12) / (2 * np.pi)
    data["analysis"] = {"kind": "cea", "max_frequency": 8 * unit, "geometric_stiffness": True}
    result = run_scene(read_scene(data))
    assert result.frequencies == pytest.approx([becks_column(load) * unit], rel=2e-3)
    assert result.growth_rates == pytest.approx([0.0], abs=1e-6)
    (warning,) = result.warnings
    assert warning.kind == "dead-contact-pressure"
    assert warning.data["pressure"] == pytest.approx(1e-6, rel=0.1)
