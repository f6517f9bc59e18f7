"""Rings between rollers: rigid motions left free, exact waves, Lame's ring, both backends alike."""

import numpy as np
import pytest
from blocks import ROTATED
from covering import covering
from lagrange_bodies import csr
from supported import ABOUT_PLACED, ABOUT_Z, MATERIAL, PLACED, QUARTER, RING, build, eigenvalues, on

from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.matrices import gather
from meshes.placement import Placement


@pytest.mark.parametrize(
    ("backend", "held"),
    covering(
        ["iga", "fe"],
        [("radial", None), ("radial", ROTATED), ("normal", ROTATED)],
        strength=1,
    ),
)
def test_ring_between_rollers_turns_and_slides_freely(backend, held):
    """Two zero eigenvalues and no more; the rotation satisfies every constraint exactly."""
    component, placement = held
    frame = (ABOUT_PLACED if placement else ABOUT_Z) if component == "radial" else {}
    rims = on(("inner", "outer"), component, **frame)
    part = build(backend, RING, rims, [2, 12, 1], placement=placement)
    kappa = eigenvalues(part, 0.25)
    assert np.abs(kappa[:2]).max() < 1e-12
    assert kappa[2] == pytest.approx(5.55e-3, rel=0.01)  # the ring tilts between its rims

    Z, K = csr(part.expansion).toarray(), csr(part.stiffness())
    place = PLACED if placement else Placement()
    axis, origin = place.rotation[:, 2], np.asarray(place.translation)
    sample = part.space.volume_cells()
    control = np.linalg.lstsq(sample.values.toarray(), sample.points, rcond=None)[0]
    for motion in (np.cross(axis, control - origin), np.broadcast_to(axis, control.shape)):
        v, *_ = np.linalg.lstsq(Z, motion.ravel(), rcond=None)
        assert np.abs(Z @ v - motion.ravel()).max() < 1e-12
        assert np.abs(K @ v).max() < 1e-12 * abs(K).max()


PLANE = on(("bottom", "top"), "axial", **ABOUT_Z)


@pytest.mark.parametrize(
    ("backend", "held"),
    covering(["iga", "fe"], [(RING, ("inner", "outer")), (QUARTER, ("start", "end"))], strength=1),
)
def test_ring_under_pressure_is_lame_s(backend, held):
    """Plane strain, u_theta held: u_r = A r + B / r, in all of the body."""
    geometry, turned = held
    p, a, b = 0.3, RING["inner_radius"], RING["outer_radius"]
    supports = PLANE + on(turned, "circumferential", **ABOUT_Z)
    elements = [4, 24 if geometry is RING else 6, 1]
    part = build(backend, geometry, supports, elements, degree=3, pressures=[("inner", p)])
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    full = part.expansion.createVecLeft()
    part.expansion.mult(x, full)
    sample = part.space.volume_cells().straight()
    u = sample.values @ gather(full).reshape(-1, 3)
    lam, mu = MATERIAL.lame
    scale = p * a**2 / (b**2 - a**2)
    r = np.linalg.norm(sample.points[:, :2], axis=1)
    radial = scale * (r / (2 * (lam + mu)) + b**2 / (2 * mu * r))
    expected = np.zeros_like(u)
    expected[:, :2] = sample.points[:, :2] * (radial / r)[:, None]
    assert np.abs(u - expected).max() < 1e-4 * radial.max()
