"""What supports bear of bodies that rotate with convective stiffness or damping."""

import numpy as np
import pytest
from rotating_numbers import pressed_disc
from scipy.integrate import solve_bvp

from cea.matrices import gather
from cea.system.support_forces import balances
from scenes import run_modes, run_static
from scenes.spec.reading import read_scene

E, NU, RHO, INNER, OUTER, FORCE, RATE = 1.0, 0.3, 1.5, 0.6, 1.0, 1e-3, 0.9
CASES = [
    {"convective_stiffness": True},
    {"convective_stiffness": True, "coriolis": False},
    {"alpha": 0.4},
    {"beta": 0.5},
    {"convective_stiffness": True, "alpha": 0.4, "beta": 0.5},
    {"convective_stiffness": True, "coriolis": False, "alpha": 0.4, "beta": 0.5},
]


def names(case):
    return " ".join(case)


def ring(backend, case, force=(FORCE, 0.0)):
    """A ring in plane strain whose rims are held, under a force on every part, as it rotates."""
    factors = {name: case.get(name, 0.0) for name in ("alpha", "beta")}
    rotation = {name: case[name] for name in ("convective_stiffness", "coriolis") if name in case}
    body = {
        "backend": backend,
        "geometry": {"shape": "ring", "inner_radius": INNER, "outer_radius": OUTER},
        "material": {"E": E, "nu": NU, "rho": RHO},
        "supports": [{"surface": "inner"}, {"surface": "outer"}],
        "rotation": {"rate": RATE} | rotation,
        "mesh": {
            "fe": {"cell": "quadrilateral", "degree": 3, "elements": [4, 24]},
            "iga": {"degree": [3, 3], "elements": [4, 24]},
        },
    }
    if any(factors.values()):
        body["damping"] = factors
    return {
        "name": "ring",
        "bodies": {"ring": body},
        "contacts": {},
        "loads": [{"body": "ring", "body_force": list(force)}],
        "analysis": {"kind": "static"},
    }


def borne(case):
    """What inner and outer rim bear: exact, from an equation along the radius.

    With u_x + i u_y = conj(h) + g exp(2 i theta), R of the material multiplies conj(h) by -i and
    g exp(2 i theta) by i, and d / d theta by 0 and 2 i. With D = h' + g' + 2 g / r and
    c = 1 + i beta Omega the equilibrium of h and g is

        c (mu (h'' + h' / r) + (lambda + mu) / 2 (D' + D / r)) + rho s h + force = 0
        c (mu (g'' + g' / r - 4 g / r^2) + (lambda + mu) / 2 (D' - D / r)) + rho t g = 0

    and the mean traction on a rim is the conjugate of c (mu h' + (lambda + mu) / 2 D).
    """
    lam, mu = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    half = (lam + mu) / 2
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
                -mu * dh / r - half * (rest + D / r) - (RHO * s * h + FORCE) / c,
                -mu * (dg / r - 4 * g / r**2) - half * (rest - D / r) - RHO * t * g / c,
            ]
        )
        return np.vstack([dh, dg, np.linalg.solve([[mu + half, half], [half, mu + half]], right)])

    def ends(a, b):
        return np.array([a[0], a[1], b[0], b[1]])

    r = np.linspace(INNER, OUTER, 41)
    found = solve_bvp(derivatives, ends, r, np.zeros((4, len(r)), dtype=complex), tol=1e-9)
    assert found.success, found.message
    forces = []
    for sign, at in ((-1, INNER), (1, OUTER)):
        _, g, dh, dg = found.sol(at)
        traction = np.conj(c * (mu * dh + half * (dh + dg + 2 * g / at)))
        forces.append(sign * 2 * np.pi * at * np.array([traction.real, traction.imag]))
    return np.array(forces)


@pytest.mark.grid
@pytest.mark.parametrize("case", CASES, ids=names)
def test_rims_bear_what_the_exact_solution_says(backend, case):
    """Of the forces of a rotation, too, that held dofs meet: up to a third of all."""
    found = run_static(read_scene(ring(backend, case))).reactions["ring"]
    expected = borne(case)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4 * np.abs(expected).max())


@pytest.mark.grid
@pytest.mark.parametrize("case", CASES, ids=names)
def test_resultants_are_those_of_the_motion_as_a_whole(backend, case):
    """To rounding, with the first moment S = int rho u.

    Seen from the frame at rest the momentum of the body does not change but for what damping of
    the mass and, without Coriolis forces, the convective stiffness make of it:

        loads + springs + supports + alpha Omega a x S  (+ Omega^2 S)  =  0.
    """
    result = run_static(read_scene(ring(backend, case)))
    u = result.system.displacement(result.displacement, "ring")
    loads = [
        gather(run_static(read_scene(ring(backend, case, force))).bodies["ring"].full_load())
        for force in ((1.0, 0.0), (0.0, 1.0))
    ]
    S = RHO * np.array([load @ u for load in loads])
    force = np.array([FORCE * np.pi * (OUTER**2 - INNER**2), 0.0])
    force += case.get("alpha", 0.0) * RATE * np.array([-S[1], S[0]])
    if case.get("convective_stiffness") and not case.get("coriolis", True):
        force += RATE**2 * S
    found = result.reactions["ring"].sum(axis=0)
    accuracy = 1e-10 if backend == "iga" else 1e-4  # facets of the round rims
    np.testing.assert_allclose(found, -force, rtol=0, atol=accuracy * np.linalg.norm(force))


@pytest.mark.grid
def test_reactions_turn_with_the_load(backend):
    """A quarter of a turn, which leaves the mesh as it is."""
    case = CASES[-1]
    first, second = (
        run_static(read_scene(ring(backend, case, force))).reactions["ring"]
        for force in ((FORCE, 0.0), (0.0, FORCE))
    )
    turned = np.column_stack([-first[:, 1], first[:, 0]])
    np.testing.assert_allclose(second, turned, rtol=0, atol=1e-10 * np.abs(first).max())


@pytest.mark.grid
@pytest.mark.parametrize("coriolis", [True, False])
def test_a_pressed_disc_is_in_equilibrium(backend, coriolis):
    """Under friction, on springs: resultants and moments, of both bodies and their contact."""
    data = pressed_disc(backend, "Rayleigh")
    data["bodies"]["disc"]["springs"] = [{"surface": "bottom", "stiffness": [0.2, 0.2, 0.5]}]
    data["bodies"]["disc"]["rotation"] |= {"convective_stiffness": True, "coriolis": coriolis}
    result = run_modes(read_scene(data))
    steady = result.system.steady
    found = balances(result.system, steady.displacement, steady.forces)
    assert {each.of for each in found} == {"disc", "pad", "contact interface"}
    labels = {label for each in found if each.of == "disc" for label in each.labels}
    assert {"damping", "convective stiffness", "springs"} <= labels
    assert max(each.left for each in found) <= 1


def test_modes_that_are_damped_do_not_tell_the_forces_of_supports():
    result = run_static(read_scene(pressed_disc("iga", "modal", "static")))
    assert set(result.reactions) == {"pad"}
