"""Scenes with damping, rotation and sliding: from fields to modes."""

import numpy as np
import pytest
from damped_numbers import damped_disc, modally_damped_disc
from pressed import pressed_blocks

from comparisons.stability.dense import dense_eigenvalues
from scenes import SceneError, assemble, read_scene, run_modes

DISCS = {"Rayleigh": damped_disc, "modal": modally_damped_disc}


@pytest.mark.parametrize("damping", DISCS)
@pytest.mark.parametrize(
    ("backend", "form"), [("iga", "saddle"), pytest.param("fe", "penalty", marks=pytest.mark.slow)]
)
def test_modes_are_those_of_dense_matrices(backend, form, damping):
    data = DISCS[damping](backend, form=form)
    modes, dense = run_modes(read_scene(data)).modes, dense_eigenvalues(data)
    window = modes.window
    inside = (dense.imag <= 2 * np.pi * window.max_frequency) & (dense.real >= window.min_growth)
    assert inside.sum() > 5
    found, expected = np.sort_complex(modes.eigenvalues), np.sort_complex(dense[inside])
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


CHANGES = {
    "Rayleigh": {
        "bodies.disc.damping.alpha": 0.02,
        "bodies.disc.damping.beta": 0.001,
        "bodies.disc.rotation.rate": 0.1,
        "bodies.disc.material.rho": 1.3,
        "contacts.interface.sliding.pressure": 0.04,
        "contacts.interface.sliding.mu_slope": 0.2,
    },
    "modal": {"bodies.disc.damping.modal.ratio": 0.1, "bodies.pad.material.E": 1.3},
}


@pytest.mark.parametrize("damping", DISCS)
def test_changes_need_no_assembly(damping):
    assembled = assemble(read_scene(DISCS[damping]("iga")))
    expected = run_modes(assembled.scene.change(CHANGES[damping]))
    found = assembled.modes(CHANGES[damping])
    assert all(found.bodies[name] is body for name, body in assembled.bodies.items())
    assembled.free()
    np.testing.assert_allclose(found.eigenvalues, expected.eigenvalues, rtol=1e-9, atol=1e-9)


def test_matrices_are_named():
    matrices = run_modes(read_scene(damped_disc("iga"))).matrices()
    assert list(matrices) == ["K", "M", "K_n", "K_f", "C", "Y", "K_c", "L", "N", "J"]
    C, Y, K_c = (matrices[name].toarray() for name in ("C", "Y", "K_c"))
    assert (C == C.T).all()
    assert (Y == -Y.T).all()
    assert (K_c == -K_c.T).all()


def test_the_pressure_is_that_of_steady_sliding(backend):
    """Of a translation: along k it has the power N mu', across it N mu / v, N the normal force."""
    sliding = {"speed": 0.5, "mu_slope": -0.2}
    gpts = {"method": "gpts", "points": 3}
    data = pressed_blocks(backend, gpts, c_n=10.0, m_n=2.0, sliding=sliding)
    result = run_modes(read_scene(data))
    upper, shift = result.bodies["upper"], np.zeros((result.system.size, 3))
    translation, free = upper.expansion.createVecLeft(), upper.expansion.createVecRight()
    for axis in range(2):  # supports hold the back along x and y: tiny blocks of the rest move
        translation.array[:] = np.tile(np.eye(3)[axis], upper.num_scalar_dofs)
        upper.expansion.multTranspose(translation, free)
        shift[: free.getSize(), axis] = free.array
    k = np.array([1.0, 0.5, 0.0]) / np.hypot(1.0, 0.5)
    t = np.array([-k[1], k[0], 0.0])
    force = result.steady.contacts["interface"].normal_force
    expected = force * (-0.2 * np.outer(k, k) + 0.1 / 0.5 * np.outer(t, t))
    C = result.matrices()["C"].toarray()
    assert shift.T @ C @ shift == pytest.approx(expected, rel=1e-10, abs=1e-12 * force)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"bodies.pad.rotation": {"rate": 1.0}}, "bodies.pad.geometry.shape"),
        ({"bodies.disc.rotation.axis": [0.0, 1.0, 0.0]}, "bodies.disc.rotation.axis"),
        ({"bodies.disc.rotation.origin": [0.1, 0.0, 0.0]}, "bodies.disc.rotation.origin"),
        ({"bodies.disc.rotation.rate": -1.0}, "bodies.disc.rotation.rate"),
        ({"bodies.disc.placement.translation": [1.0, 0.0, 0.0]}, "rotation.origin"),
        ({"bodies.disc.damping.alpha": -1.0}, "bodies.disc.damping.alpha"),
        ({"bodies.disc.damping.ratios": [0.1, 0.1]}, "bodies.disc.damping.ratios"),
        ({"bodies.pad.damping.ratios": [0.1, 9.0]}, "bodies.pad.damping.ratios"),
        ({"bodies.pad.damping.frequencies": [0.1, 0.1]}, "bodies.pad.damping.frequencies"),
        ({"bodies.pad.damping": {"ratios": [0.1, 0.1]}}, "bodies.pad.damping.frequencies"),
        ({"bodies.disc.damping": {}}, "bodies.disc.damping.ratios"),
        ({"contacts.interface.p": None, "contacts.interface.c_n": 1.0}, "sliding.pressure"),
        ({"analysis.min_growth": 1.0}, "analysis.min_growth"),
    ],
)
def test_what_cannot_be_is_refused(change, named):
    with pytest.raises(SceneError) as refused:
        read_scene(damped_disc("iga")).change(change)
    assert named in str(refused.value)
