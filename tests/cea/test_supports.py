"""Supports in local frames: turned bodies, rings between rollers, closed forms; what is refused."""

import numpy as np
import pytest
from blocks import ROTATED, alone, scene_body
from covering import covering
from motions import control_points
from petsc_matrices import gather, to_scipy

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.timing import StageTimer
from meshes.placement import Placement
from scenes.building.build import build_bodies
from scenes.spec.reading import read_scene

MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
BOX = {"shape": "box", "size": [1.0, 0.7, 0.4]}
RADII = {"inner_radius": 0.8, "outer_radius": 1.6, "bottom": 0.0, "top": 0.2}
RING = {"shape": "annulus", **RADII}
QUARTER = {"shape": "sector", "start": 0.0, "end": 90.0, **RADII}
PLACED = Placement(tuple(ROTATED["axis"]), ROTATED["angle"], tuple(ROTATED["translation"]))
ABOUT_Z = {"axis": [0.0, 0.0, 1.0]}
ABOUT_PLACED = {"axis": PLACED.rotation[:, 2].tolist(), "origin": ROTATED["translation"]}


def build(backend, geometry, supports, elements, *, degree=2, placement=None, loads=()):
    """A body as scenes say it."""
    sections = {"supports": supports, "placement": placement or {}}
    scene = alone(scene_body(backend, geometry, elements, degree, **sections))
    return build_bodies(read_scene(scene | {"loads": list(loads)}), StageTimer())["part"]


def on(names, component="normal", **frame):
    """One component held on each of several surfaces."""
    return [{"surface": name, "components": [component], **frame} for name in names]


def eigenvalues(body, max_frequency):
    """Squares of the angular frequencies."""
    modes = solve_modes(Pencil.of(body.stiffness(), body.mass()), max_frequency)
    return modes.eigenvalues.imag**2


SIDES = [("start", "y"), ("end", "x"), ("bottom", "z")]
TURNED = {
    "corner of a box": (
        BOX,
        [4, 3, 2],
        [("x_min", "x"), ("y_max", "y"), ("z_min", "z")],
        on(("x_min", "y_max", "z_min")),
        0.9,
    ),
    "sides of a sector": (QUARTER, [3, 5, 1], SIDES, on(("start", "end", "bottom")), 0.6),
    "sides held around": (
        QUARTER,
        [3, 5, 1],
        SIDES,
        on(("start", "end"), "circumferential", **ABOUT_PLACED) + on(["bottom"]),
        0.6,
    ),
}


@pytest.mark.grid
@pytest.mark.parametrize("case", TURNED)
def test_flat_faces_of_turned_bodies_are_held_as_upright_ones(backend, case):
    """Faces held in every direction, edges and a corner where rollers meet at right angles."""
    geometry, elements, axes, supports, window = TURNED[case]
    plain = [{"surface": name, "components": [axis]} for name, axis in axes]
    upright = build(backend, geometry, plain, elements)
    turned = build(backend, geometry, supports, elements, placement=ROTATED)
    assert turned.expansion.getSize() == upright.expansion.getSize()
    Z = to_scipy(turned.expansion)
    assert np.diff(Z.indptr).max() <= 3
    assert abs(Z.T @ Z - np.eye(Z.shape[1])).max() < 1e-14
    expected = eigenvalues(upright, window)
    assert len(expected) > 5
    assert eigenvalues(turned, window) == pytest.approx(expected, rel=1e-9)


def test_one_of_two_directions_is_not_held_at_an_axis(backend):
    frame = ABOUT_Z | {"origin": [1.2, 0.0, 0.0]}
    with pytest.raises(InputError, match=r"components.*both or neither"):
        _ = build(backend, RING, on(["top"], "radial", **frame), [1, 16, 1]).expansion


@pytest.mark.grid
@pytest.mark.parametrize("component", ["radial", "normal"])
def test_ring_between_rollers_turns_and_slides_freely(backend, component):
    """Two zero eigenvalues and no more; the rotation satisfies every constraint exactly."""
    frame = ABOUT_PLACED if component == "radial" else {}
    rims = on(("inner", "outer"), component, **frame)
    part = build(backend, RING, rims, [2, 12, 1], placement=ROTATED)
    kappa = eigenvalues(part, 0.25)
    assert np.abs(kappa[:2]).max() < 1e-12
    assert kappa[2] == pytest.approx(5.55e-3, rel=0.01)  # the ring tilts between its rims

    Z, K = to_scipy(part.expansion).toarray(), to_scipy(part.stiffness())
    axis, control = PLACED.rotation[:, 2], control_points(part)
    around = np.cross(axis, control - np.asarray(PLACED.translation))
    for motion in (around, np.broadcast_to(axis, control.shape)):
        v, *_ = np.linalg.lstsq(Z, motion.ravel(), rcond=None)
        assert np.abs(Z @ v - motion.ravel()).max() < 1e-12
        assert np.abs(K @ v).max() < 1e-12 * abs(K).max()


@pytest.mark.parametrize(
    ("backend", "held"),
    covering(["iga", "fe"], [(RING, ("inner", "outer")), (QUARTER, ("start", "end"))], strength=1),
)
def test_ring_under_pressure_is_lame_s(backend, held):
    """Plane strain, u_theta held: u_r = A r + B / r, in all of the body."""
    geometry, turned = held
    p, a, b = 0.3, RADII["inner_radius"], RADII["outer_radius"]
    supports = on(("bottom", "top"), "axial", **ABOUT_Z) + on(turned, "circumferential", **ABOUT_Z)
    elements = [4, 24 if geometry is RING else 6, 1]
    loads = [{"surface": "part.inner", "pressure": p}]
    part = build(backend, geometry, supports, elements, degree=3, loads=loads)
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    sample = part.space.volume_cells().straight()
    u = sample.values @ gather(part.expansion @ x).reshape(-1, 3)
    lam, mu = MATERIAL.lame
    scale = p * a**2 / (b**2 - a**2)
    r = np.linalg.norm(sample.points[:, :2], axis=1)
    radial = scale * (r / (2 * (lam + mu)) + b**2 / (2 * mu * r))
    expected = np.zeros_like(u)
    expected[:, :2] = sample.points[:, :2] * (radial / r)[:, None]
    assert np.abs(u - expected).max() < 1e-4 * radial.max()
