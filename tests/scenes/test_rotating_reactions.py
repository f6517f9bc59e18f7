"""What supports bear of bodies that rotate with convective stiffness or damping."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from scenes import run_static
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
