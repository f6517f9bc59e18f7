"""Equilibria of bodies that rotate: those of the stiffness that small motions about them meet."""

import numpy as np
from scipy.special import jv, jvp, yv, yvp

from scenes import run_static
from scenes.spec.reading import read_scene


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
