"""Equilibria of bodies that rotate: those of the stiffness that small motions about them meet."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve
from scipy.special import jv, jvp, yv, yvp

from scenes import run_modes, run_static
from scenes.spec.reading import read_scene


def pinched_ring(backend, rate, kind="cea", **ring):
    """A soft ring on springs that rotates between two pads; a law of the closure, no friction."""

    def mesh(*elements):
        return {
            "fe": {"cell": "quadrilateral", "degree": 2, "elements": list(elements)},
            "iga": {"degree": [3, 3], "elements": list(elements)},
        }

    def pad(start, end):
        return {
            "backend": backend,
            "geometry": {
                "shape": "ring_sector",
                "inner_radius": 0.1,
                "outer_radius": 0.11,
                "start": start,
                "end": end,
            },
            "material": {"E": 1e8, "nu": 0.3, "rho": 1000.0},
            "supports": [
                {"surface": side, "components": ["circumferential"]} for side in ("start", "end")
            ],
            "mesh": mesh(1, 6),
        }

    bodies = {
        "ring": {
            "backend": backend,
            "geometry": {"shape": "ring", "inner_radius": 0.09, "outer_radius": 0.1},
            "material": {"E": 1e9, "nu": 0.3, "rho": 2000.0},
            "springs": [{"surface": "inner", "stiffness": [1e6, 1e6]}],
            "rotation": {"rate": rate, "convective_stiffness": True, "coriolis": False},
            "mesh": mesh(1, 40),
        }
        | ring,
        "p": pad(-15.0, 15.0),
        "q": pad(165.0, 195.0),
    }
    law = {"formulation": {"method": "segments"}, "c_n": 1e11, "mu": 0.0, "reach": 1e-4}
    analysis = {"kind": kind}
    if kind == "cea":
        analysis |= {"max_frequency": 100.0, "min_growth": -3000.0}
    return {
        "name": "pinched ring",
        "bodies": bodies,
        "contacts": {
            "s": {"a": "p.inner", "b": "ring.outer", **law},
            "t": {"a": "q.inner", "b": "ring.outer", **law},
        },
        "loads": [{"surface": f"{pad}.outer", "pressure": 1e5} for pad in ("p", "q")],
        "analysis": analysis,
    }


def stiffness(matrices, *, contacts=True):
    """K of stored matrices as an operator, with what damping makes of displacements."""
    K = matrices["K"] + matrices.get("K_c", 0 * matrices["K"])
    if contacts:
        K = K + matrices["K_n"] - matrices["K_f"]
    if "L" not in matrices:
        return lambda u: K @ u
    L, N, J = (matrices[name] for name in "LNJ")
    return lambda u: K @ u + L @ spsolve(N.tocsc(), J @ u)


def load_of(data):
    """Forces of the loads of a scene."""
    data = data | {"analysis": {"kind": "static"}}
    return run_static(read_scene(data)).system.load.array


@pytest.mark.grid
@pytest.mark.parametrize("rate", [0.0, 150.0, 300.0])
def test_the_stored_state_is_an_equilibrium_of_the_stored_matrices(backend, rate):
    """With m_n = 1 the tangent at closed points is the law itself, where sides touched before."""
    data = pinched_ring(backend, rate)
    result = run_modes(read_scene(data))
    u, load = result.steady.displacement.array, load_of(data)
    K = stiffness(result.matrices(), contacts=False)
    contact = sum(
        each.force(result.steady.contacts[each.name].pressure, friction=False).array
        for each in result.system.contacts
    )
    assert np.linalg.norm(K(u) + contact - load) < 1e-10 * np.linalg.norm(load)
    assert result.steady.residual < 1e-10
    assert all(0 < each.closed_fraction < 1 for each in result.steady.contacts.values())


def widened_ring(rate):
    """Largest displacement of a ring under pressure that rotates, in plane strain: exact waves.

    (lambda + 2 mu) (u'' + u'/r - u/r^2) + rho Omega^2 u = 0, the pressure on the inside.
    """
    E, nu, rho, a, b, p = 1.0, 0.3, 1.5, 0.6, 1.0, 1e-3
    lam, mu = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    k = rate * np.sqrt(rho / (lam + 2 * mu))

    def stress(f, df, r):
        return (lam + 2 * mu) * k * df(1, k * r) + lam * f(1, k * r) / r

    rows = [[stress(jv, jvp, r), stress(yv, yvp, r)] for r in (a, b)]
    A, B = np.linalg.solve(rows, [-p, 0.0])
    return A * jv(1, k * a) + B * yv(1, k * a)


def test_static_displacement_under_pressure_is_exact(backend):
    """Of a ring that widens as it rotates: centrifugal forces grow with its radius."""
    sizes = {}
    for rate in (0.3, 0.6):
        ring = {
            "backend": backend,
            "geometry": {"shape": "ring", "inner_radius": 0.6, "outer_radius": 1.0},
            "material": {"E": 1.0, "nu": 0.3, "rho": 1.5},
            "supports": [{"surface": "inner", "components": ["circumferential"]}],
            "rotation": {"rate": rate, "convective_stiffness": True},
            "mesh": {
                "fe": {"cell": "quadrilateral", "degree": 3, "elements": [2, 20]},
                "iga": {"degree": [3, 3], "elements": [2, 20]},
            },
        }
        data = {
            "name": "ring",
            "bodies": {"ring": ring},
            "contacts": {},
            "loads": [{"surface": "ring.inner", "pressure": 1e-3}],
            "analysis": {"kind": "static"},
        }
        result = run_static(read_scene(data))
        points = result.bodies["ring"].surfaces["inner"].gauss_points(3)
        u = result.displacements("ring.inner", points.at)
        sizes[rate] = np.linalg.norm(u, axis=1)
        np.testing.assert_allclose(sizes[rate], widened_ring(rate), rtol=2e-5)
    assert sizes[0.6].mean() > 1.1 * sizes[0.3].mean()
