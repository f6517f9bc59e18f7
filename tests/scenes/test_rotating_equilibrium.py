"""Equilibria of bodies that rotate: those of the stiffness that small motions about them meet."""

import numpy as np
import pytest
from damped_numbers import RATE
from mpi import on_ranks
from rotating_numbers import DAMPING, pressed_disc
from scipy.sparse.linalg import spsolve
from scipy.special import jv, jvp, yv, yvp

from cea.errors import ConvergenceError
from cea.system.steady_equations import SteadyEquations
from scenes import run_modes, run_static
from scenes.running.assembled import AssembledScene
from scenes.running.system import coupled
from scenes.spec.problems import SceneError
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


def test_the_rotation_softens_what_the_pads_pinch():
    """By 35 %, 26 % of which came with the points that are closed at rest."""
    sizes, forces = [], []
    for rate in (0.0, 300.0):
        steady = run_modes(read_scene(pinched_ring("iga", rate))).steady
        sizes.append(np.abs(steady.displacement.array).max())
        forces.append(steady.contacts["s"].normal_force)
    assert sizes[1] / sizes[0] == pytest.approx(1.35, abs=0.01)
    assert forces[0] == pytest.approx(1505.6, rel=1e-3)
    assert forces[1] == pytest.approx(422.0, rel=1e-2)


def test_beyond_a_critical_rate_there_may_be_none():
    with pytest.raises(ConvergenceError, match="beyond a critical rate"):
        run_modes(read_scene(pinched_ring("iga", 600.0)))


@pytest.mark.grid
@pytest.mark.parametrize("damping", DAMPING)
def test_damping_that_rotates_acts_in_the_equilibrium(backend, damping):
    """Of displacements at rest in space the material sees the rate Omega R u."""
    data = pressed_disc(backend, damping)
    result = run_modes(read_scene(data))
    u, load = result.steady.displacement.array, load_of(pressed_disc(backend, damping, "static"))
    matrices = result.matrices()
    contact = sum(
        each.force(result.steady.contacts[each.name].pressure, friction=True).array
        for each in result.system.contacts
    )
    defect = stiffness(matrices, contacts=False)(u) + contact - load
    assert np.linalg.norm(defect) < 1e-10 * np.linalg.norm(load)
    without = matrices["K"] @ u + contact - load
    assert np.linalg.norm(without) > 1e-4 * np.linalg.norm(load)
    static = run_static(read_scene(pressed_disc(backend, damping, "static")))
    assert static.displacement.array == pytest.approx(u, rel=1e-9, abs=1e-12 * np.abs(u).max())


def test_a_state_that_is_no_equilibrium_is_refused():
    system = coupled(read_scene(pressed_disc("iga", "Rayleigh")))[0]
    problem = SteadyEquations(system)
    x = system.steady.displacement.array.copy()
    state = problem.state(x, np.zeros(0), 1.0)
    tangent = problem.tangent(problem.slopes(state.closures))
    assert problem.checked_residual(state, tangent) == pytest.approx(system.steady.residual)
    moved = problem.state((1 + 1e-6) * x, np.zeros(0), 1.0)
    with pytest.raises(ConvergenceError, match="is no equilibrium"):
        problem.checked_residual(moved, tangent)


def test_a_state_moves_with_the_rate_of_a_rotation():
    """Rate, density and damping are part of the equilibrium: it is sought anew, or told to stay."""
    scene = read_scene(pressed_disc("iga", "Rayleigh"))
    assembled = AssembledScene(scene)
    for name in ("rotation.rate", "material.rho", "damping.alpha", "damping.beta"):
        assert assembled.depends_on_state([f"bodies.disc.{name}"])
    assert not assembled.depends_on_state(["bodies.pad.material.rho", "bodies.pad.damping.alpha"])
    change = {"bodies.disc.rotation.rate": 1.4 * RATE}
    found, fresh = assembled.modes(change), run_modes(scene.change(change))
    assert found.steady.contacts["interface"].normal_force == pytest.approx(
        fresh.steady.contacts["interface"].normal_force, rel=1e-12
    )
    np.testing.assert_allclose(found.eigenvalues, fresh.eigenvalues, rtol=1e-9, atol=1e-9)
    assembled.free()


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


def test_prescribed_displacements_of_bodies_that_rotate_are_refused():
    scene = read_scene(pressed_disc("iga", "Rayleigh"))
    moved = [{"surface": "inner", "components": ["z"], "value": -1e-3}, {"surface": "inner"}]
    with pytest.raises(SceneError, match=r"disc\.supports\.0\.value = -0\.001: zero"):
        scene.change({"bodies.disc.supports": moved})


def test_a_static_scene_needs_the_density_of_what_rotates():
    data = pressed_disc("iga", "Rayleigh", "static")
    del data["bodies"]["pad"]["damping"]
    del data["bodies"]["pad"]["material"]["rho"]
    read_scene(data)
    del data["bodies"]["disc"]["material"]["rho"]
    with pytest.raises(SceneError, match=r"bodies\.disc\.material\.rho"):
        read_scene(data)


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "backend", "damping"),
    [
        (2, "iga", "Rayleigh"),
        (2, "fe", "modal"),
        pytest.param(3, "fe", "modal", marks=pytest.mark.slow),
        pytest.param(3, "iga", "Rayleigh", marks=pytest.mark.slow),
        pytest.param(2, "fe", "Rayleigh", marks=pytest.mark.slow),
    ],
)
def test_numbers_do_not_depend_on_the_ranks(ranks, backend, damping):
    alone, together = (
        on_ranks(n, "rotating_numbers.numbers", backend, damping) for n in (1, ranks)
    )
    assert max(each["residual"] for each in (alone, together)) < 1e-10
    for key in ("force", "pressure", "re", "im", "slopes", "reactions"):
        size = np.abs(alone[key]).max()
        np.testing.assert_allclose(together[key], alone[key], rtol=1e-8, atol=1e-8 * size)
