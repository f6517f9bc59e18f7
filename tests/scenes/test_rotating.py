"""Scenes with damping, rotation and sliding: dense eigenvalues, exact equilibria, refusals."""

import numpy as np
import pytest
from blocks import alone, coarse, scene_body
from damped_numbers import damped_disc, modally_damped_disc
from pressed import pressed_blocks
from scipy.integrate import solve_bvp

from comparisons.stability.dense import dense_eigenvalues
from scenes import SceneError, read_scene, run_modes, run_static

DISCS = {"Rayleigh": damped_disc, "modal": modally_damped_disc}


@pytest.mark.parametrize("damping", ["Rayleigh", pytest.param("modal", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("backend", "form"), [("iga", "saddle"), pytest.param("fe", "penalty", marks=pytest.mark.slow)]
)
def test_modes_are_those_of_dense_matrices(backend, form, damping):
    data = DISCS[damping](backend, form=form)
    result, dense = run_modes(read_scene(data)), dense_eigenvalues(data)
    window = result.modes.window
    inside = (dense.imag <= 2 * np.pi * window.max_frequency) & (dense.real >= window.min_growth)
    assert inside.sum() > 5
    found, expected = np.sort_complex(result.eigenvalues), np.sort_complex(dense[inside])
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
    for name, sign in (("C", 1), ("Y", -1), ("K_c", -1)):
        if name in result.matrices():  # no circulatory matrix of modal damping
            matrix = result.matrices()[name].toarray()
            assert (matrix == sign * matrix.T).all()


def test_the_pressure_is_that_of_steady_sliding(backend):
    """Of a translation: along k it has the power N mu', across it N mu / v, N the normal force."""
    sliding = {"speed": 0.5, "mu_slope": -0.2}
    gpts = {"method": "gpts", "points": 3}
    data = coarse(pressed_blocks(backend, gpts, c_n=10.0, m_n=2.0, sliding=sliding))
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


def two_rings(inner, outer, translation=(0.0, 0.0, 0.0), **contact):
    """A cylinder in another one, each with a rotation or without (None)."""
    bodies = {}
    for name, radii, rotation in (("inner", (0.5, 0.7), inner), ("outer", (0.7, 1.0), outer)):
        geometry = dict(zip(("inner_radius", "outer_radius"), radii, strict=True))
        geometry |= {"shape": "annulus", "bottom": 0.0, "top": 0.3}
        placed = {"placement": {"translation": list(translation)}, "rotation": rotation}
        bodies[name] = scene_body("iga", geometry, [1, 12, 1]) | placed
    sides = {"a": "inner.outer", "b": "outer.inner", "formulation": {"method": "mortar"}}
    contacts = {"joint": sides | {"P": np.inf} | contact}
    analysis = {"kind": "cea", "max_frequency": 0.3}
    return {"name": "rings", "bodies": bodies, "contacts": contacts, "analysis": analysis}


SPINS = {"rate": 0.5}
TURNED = {"rate": 0.5, "axis": [0.0, 0.0, -1.0]}
SAME = {"rate": 0.5, "axis": [0.0, 0.0, 3.0], "origin": [0.0, 0.0, 2.0]}
RESTS = {"rate": 0.0}
BONDED = {"formulation": {"method": "bonded"}}


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        (SPINS, None, False),
        (None, SPINS, False),
        (SPINS, {"rate": 0.4}, False),
        (SPINS, TURNED, False),
        (SPINS, RESTS, False),
        (SPINS, SAME, True),
        (RESTS, None, True),
        (None, None, True),
    ],
)
def test_bonded_sides_rotate_alike_and_sides_that_do_not_slide_have_no_friction(one, other, alike):
    """Normal contact alone allows any rotations; friction along the axis a sliding bush."""
    around, along = {"circumferential_about": [0.0, 0.0, 1.0]}, {"vector": [0.0, 0.0, 2.0]}
    friction = {"mu": 0.3, "friction_direction_on_a": around}
    read_scene(two_rings(one, other))
    read_scene(two_rings(one, other, **friction | {"friction_direction_on_a": along}))
    together = alike and SPINS in (one, other)
    across = friction | {"friction_direction_on_a": {"vector": [1.0, 0.0, 0.0]}}
    for contact, field, allowed in (
        (BONDED, "formulation.method", alike),
        (friction, "friction_direction_on_a", not together),
        (across, "friction_direction_on_a", not together),
    ):
        data = two_rings(one, other, **contact)
        if allowed:
            read_scene(data)
            continue
        with pytest.raises(SceneError, match=f"contacts.joint.{field} = .*same rotation"):
            read_scene(data)


def test_axes_apart_are_different_rotations():
    """Of the same rate: a point of either axis decides, wherever along it."""
    there = (0.3, -0.2, 0.1)
    spins = SPINS | {"origin": [0.3, -0.2, 5.0]}
    read_scene(two_rings(spins, spins | {"origin": [0.3, -0.2, 0.0]}, there, **BONDED))
    data = two_rings(spins, spins, there, **BONDED)
    data["bodies"]["outer"] |= {"placement": {}, "rotation": SPINS}
    with pytest.raises(SceneError, match=r"contacts.joint.formulation.method = .*same rotation"):
        read_scene(data)


E, NU, RHO, INNER, OUTER, FORCE, RATE = 1.0, 0.3, 1.5, 0.6, 1.0, 1e-3, 0.9
LAMBDA, MU = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
MATERIAL = {"E": E, "nu": NU, "rho": RHO}


def ring(backend, radii, elements, material=MATERIAL, max_frequency=None, **sections):
    """A scene of a ring of degree 3 in plane strain."""
    geometry = {"shape": "ring", "inner_radius": radii[0], "outer_radius": radii[1]}
    return alone(
        scene_body(backend, geometry, elements, degree=3, material=material, **sections),
        max_frequency,
    )


@pytest.mark.grid
@pytest.mark.parametrize(("part", "told"), [(0.75, False), (1.2, True)])
def test_a_rim_that_outruns_surface_waves_is_warned_of(backend, part, told):
    """Waves of the mesh that the exact ring does not have grow beyond it; below none does."""
    steel = {"E": 2e11, "nu": 0.3, "rho": 7800.0}
    rate = part * np.sqrt(2e11 / 2.6 / 7800.0) / 0.1
    rotation = {"rate": rate, "convective_stiffness": True, "coriolis": False}
    data = ring(backend, (0.09, 0.1), [1, 24], steel, 2500.0, rotation=rotation)
    data["analysis"]["min_growth"] = -20000.0
    result = run_modes(read_scene(data))
    found = [each for each in result.warnings if each.kind == "faster-than-waves"]
    assert bool(found) == told
    assert (result.eigenvalues.real.max() > 1e3) == told
    if told:
        assert found[0].data["speed"] == pytest.approx(part * found[0].data["wave_speed"], rel=0.01)


CASES = [
    {"convective_stiffness": True},
    {"convective_stiffness": True, "coriolis": False},
    {"alpha": 0.4},
    {"beta": 0.5},
    {"convective_stiffness": True, "alpha": 0.4, "beta": 0.5},
    {"convective_stiffness": True, "coriolis": False, "alpha": 0.4, "beta": 0.5},
]
"""Fields of rotation, and of damping."""


def borne(case):
    """What inner and outer rim bear: exact, from an equation along the radius.

    With u_x + i u_y = conj(h) + g exp(2 i theta), R of the material multiplies conj(h) by -i and
    g exp(2 i theta) by i, and d / d theta by 0 and 2 i. With D = h' + g' + 2 g / r and
    c = 1 + i beta Omega the equilibrium of h and g is

        c (mu (h'' + h' / r) + (lambda + mu) / 2 (D' + D / r)) + rho s h + force = 0
        c (mu (g'' + g' / r - 4 g / r^2) + (lambda + mu) / 2 (D' - D / r)) + rho t g = 0

    and the mean traction on a rim is the conjugate of c (mu h' + (lambda + mu) / 2 D).
    """
    half = (LAMBDA + MU) / 2
    c = 1 + 1j * case.get("beta", 0.0) * RATE
    damped = -1j * case.get("alpha", 0.0) * RATE
    convective = RATE**2 if case.get("convective_stiffness") else 0.0
    h_turns, g_turns = (0.0, 4.0) if case.get("coriolis", True) else (1.0, 1.0)
    s, t = damped + h_turns * convective, damped + g_turns * convective

    def derivatives(r, y):
        h, g, dh, dg = y
        D = dh + dg + 2 * g / r
        rest = 2 * dg / r - 2 * g / r**2  # D' without h'' and g''
        right = np.array(
            [
                -MU * dh / r - half * (rest + D / r) - (RHO * s * h + FORCE) / c,
                -MU * (dg / r - 4 * g / r**2) - half * (rest - D / r) - RHO * t * g / c,
            ]
        )
        return np.vstack([dh, dg, np.linalg.solve([[MU + half, half], [half, MU + half]], right)])

    def ends(a, b):
        return np.array([a[0], a[1], b[0], b[1]])

    r = np.linspace(INNER, OUTER, 41)
    found = solve_bvp(derivatives, ends, r, np.zeros((4, len(r)), dtype=complex), tol=1e-9)
    assert found.success, found.message
    forces = []
    for sign, at in ((-1, INNER), (1, OUTER)):
        _, g, dh, dg = found.sol(at)
        traction = np.conj(c * (MU * dh + half * (dh + dg + 2 * g / at)))
        forces.append(sign * 2 * np.pi * at * np.array([traction.real, traction.imag]))
    return np.array(forces)


@pytest.mark.grid
@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_rims_bear_what_the_exact_solution_says(backend, case):
    """Of the forces of a rotation, too, that held dofs meet: up to a third of all."""
    damping = {name: case[name] for name in ("alpha", "beta") if name in case}
    fields = {name: value for name, value in case.items() if name not in damping}
    data = ring(
        backend,
        (INNER, OUTER),
        [4, 24],
        supports=[{"surface": "inner"}, {"surface": "outer"}],
        rotation={"rate": RATE} | fields,
        **({"damping": damping} if damping else {}),
    )
    data["loads"] = [{"body": "part", "body_force": [FORCE, 0.0]}]
    found = run_static(read_scene(data)).reactions["part"]
    expected = borne(case)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4 * np.abs(expected).max())


def test_supports_may_differ_round_the_axis_without_rotation_or_without_damping():
    scene = read_scene(modally_damped_disc("iga"))
    change = {"bodies.disc.supports": [{"surface": "inner", "components": ["x"]}]}
    for left_out in ("damping", "rotation"):
        scene.change(change | {f"bodies.disc.{left_out}": None})
