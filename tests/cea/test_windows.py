"""Windows of any growth: discs that cover them, bounds, signs, shifts, errors, verdicts."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from blocks import assemble, coarse, two_blocks
from covering import covering
from petsc_matrices import dense_pencil, sliding_pencil
from random_pencils import pencil_of

from cea.eigen import window
from cea.eigen.driver import EigenSolver, solve_modes
from cea.eigen.field_of_values import field_of_values
from cea.eigen.krylov_schur import KrylovOptions
from cea.eigen.modes import Modes
from cea.eigen.regions import covering_disc, distance_of_cone
from cea.eigen.shifted import Shifted
from cea.eigen.static import solve_static
from cea.errors import ConvergenceError
from scenes import load_scene, run_modes

HERTZ = 1 / (2 * np.pi)
KRYLOV = KrylovOptions(dense_limit=0)
"""Small systems are searched as large ones are."""


def pencil_with(blocks, *, turned=True, seed=0):
    """A pencil of mass 1 with given diagonal blocks."""
    whole = scipy.linalg.block_diag(*blocks)
    n = len(whole)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0] if turned else np.eye(n)
    symmetric, rest = (turn @ (0.5 * (whole + s * whole.T)) @ turn.T for s in (1, -1))
    return pencil_of(np.eye(n), None, 0.5 * (symmetric + symmetric.T) + rest)


def pair(real, imaginary):
    """A block with kappa = real +- i imaginary."""
    return np.array([[real, imaginary], [-imaginary, real]])


def band(n, low=0.5, high=400.0):
    return [[[value]] for value in np.linspace(low, high, n)]


@pytest.mark.parametrize(
    ("strength", "options"),
    [(0.5, KRYLOV), (5.0, KRYLOV), *((each, KrylovOptions()) for each in (0.5, 5.0, 50.0, 1e4))],
)
def test_growth_of_any_strength_is_found(strength, options):
    """Flutter and divergence far outside of the disc about the window, beside 150 other modes.

    Left vectors are found in the discs that hold them.
    """
    fast = -((strength + 0.4j) ** 2)
    blocks = [*band(150), pair(fast.real, fast.imag), [[-((2 * strength) ** 2)]]]
    pencil = pencil_with(blocks, turned=strength < 1e3)
    modes = solve_modes(pencil, HERTZ, options=options, left=True)
    assert modes.window.complete
    assert modes.verdict() == "unstable"
    inner = modes.left.vectors.conj().T @ modes.vectors
    np.testing.assert_allclose(inner, np.eye(len(modes)), atol=1e-6)
    growing = np.sort(modes.growth_rates[modes.unstable()])
    assert growing == pytest.approx([strength, 2 * strength], rel=1e-6)


def test_what_was_not_searched_is_told(monkeypatch):
    """With fewer discs than it takes the run says how far it went, and gives no verdict."""
    monkeypatch.setattr(window, "field_of_values", lambda *_, **__: None)
    blocks = [*band(150, high=1e9), pair(2.0, 0.1)]
    options = KrylovOptions(dense_limit=0, max_discs=1)
    modes = solve_modes(pencil_with(blocks), HERTZ, options=options)
    assert not modes.window.complete
    assert modes.window.max_growth == pytest.approx(np.sqrt(2.4))
    assert modes.verdict() == "no unstable mode found"
    assert f"up to a growth rate of {modes.window.max_growth:.4g} 1/s" in modes.headline()
    assert set(modes.verdicts()) == {"stable"}
    assert "not excluded" in modes.window.evidence


@pytest.mark.parametrize(("kappa", "found"), [(-2.0, True), (-1e6, False)])
def test_a_real_mode_that_a_wrong_bound_leaves_out_is_seen_by_signs(kappa, found, monkeypatch):
    """The determinant changes its sign at it: it is searched, or the window says that it is not."""
    monkeypatch.setattr(window, "field_of_values", lambda *_, **__: 0.0)
    blocks = [*band(150), np.array([[0.6, 0.3], [0.0, 0.7]]), [[kappa]]]
    modes = solve_modes(pencil_with(blocks, turned=found), HERTZ, options=KRYLOV)
    assert modes.window.odd != found
    assert modes.window.complete == found
    assert modes.verdict() == ("unstable" if found else "undecided")
    assert ("sign of a determinant" in modes.window.evidence) != found


@pytest.mark.parametrize(
    ("backend", "of_contact", "mu", "P"),
    covering(
        ["iga", "fe"],
        ["penalty", "saddle", "mortar", "both"],
        [1e-6, 0.9, 3.0],
        [2.0, 1e3, 1e6],
        strength=1,
    ),
)
def test_bounds_are_those_of_the_field_of_values(backend, of_contact, mu, P):
    """How far it reaches, and the slope of a cone that holds it, with a safety of one half."""

    def pencil_in(form):
        fields = {"form": form} if form != "mortar" else {}
        method = {"method": "mortar"} if form == "mortar" else {"method": "gpts", "points": 3}
        data = coarse(two_blocks(backend, method, held=True, mu=mu, P=P, **fields))
        return assemble(data).pencil().at()

    if of_contact == "both":
        matrices = replace(pencil_in("penalty"), multipliers=pencil_in("saddle").multipliers)
    else:
        matrices = pencil_in(of_contact)
    assert (matrices.multipliers is None) == (of_contact == "penalty")
    assert (matrices.unsymmetric is None) == (of_contact in ("saddle", "mortar"))
    M, _, K = dense_pencil(matrices)
    lowest = scipy.linalg.eigvalsh(0.5 * (K + K.T), M)[0]
    assert field_of_values(matrices, -lowest + 1e-3 * abs(lowest)) is not None
    assert field_of_values(matrices, -lowest - 1e-3 * abs(lowest)) is None
    depth = max(0.0, -1.5 * lowest) + 0.1
    found = field_of_values(matrices, depth, cone=True)
    slope = scipy.linalg.eigvalsh(0.5j * (K.T - K), 0.5 * (K + K.T) + depth * M)[-1]
    assert found == pytest.approx(1.5 * slope, rel=0.02)
    kappa = scipy.linalg.eigvals(K, M)
    assert (np.abs(kappa.imag) <= found * (kappa.real + depth) * (1 + 1e-9)).all()


@pytest.mark.parametrize("slope", [0.0, 1e-3, 0.6, 4.0, 1e3])
@pytest.mark.parametrize("depth", [0.0, 0.1, 30.0])
def test_a_disc_about_the_middle_covers_what_a_cone_leaves(slope, depth):
    rng = np.random.default_rng(2)
    real = rng.uniform(-depth, 1.0, 200_000)
    cone = slope * (real + depth)
    kappa = real + 1j * np.minimum(cone, 2 * np.sqrt(1 - real)) * rng.choice([-1, 1], len(real))
    radius = distance_of_cone(1.0, 0.5, depth, slope)
    farthest = np.abs(kappa - 0.5).max()
    assert farthest <= radius <= 1.06 * farthest
    assert distance_of_cone(1.0, 0.5, depth, np.inf) == np.inf


def test_a_wide_cone_takes_a_second_shift():
    """Flutter that the first disc does not hold."""
    beyond = 100
    blocks = [*band(beyond, 1.05, 4.0), *band(beyond // 4, 0.013, 0.99), [[900.0]], pair(0.2, 0.75)]
    modes = solve_modes(pencil_with(blocks), HERTZ, options=KRYLOV)
    assert modes.window.discs == 2
    assert modes.window.complete
    kappa = -(modes.eigenvalues**2)
    inside = [*np.linspace(0.013, 0.99, beyond // 4), 0.2 + 0.75j, 0.2 - 0.75j]
    assert np.sort_complex(kappa) == pytest.approx(np.sort_complex(inside), abs=1e-9)
    assert modes.verdict() == "unstable"


@pytest.mark.parametrize("turned", [False, True])
def test_a_shift_that_is_an_eigenvalue_is_stepped_aside_from(turned):
    """The middle of the window, exactly and but for rounding; a place, and next to one."""
    pencil = pencil_with([*band(60), [[0.5]], pair(0.8, 0.1)], turned=turned)
    modes = solve_modes(pencil, HERTZ, options=KRYLOV)
    kappa = np.sort_complex(-(modes.eigenvalues**2))
    assert kappa == pytest.approx([0.5, 0.5, 0.8 - 0.1j, 0.8 + 0.1j], abs=1e-11)
    assert modes.trusted.all()
    assert modes.window.complete
    with EigenSolver(pencil) as driver:
        for place in (0.5, 0.51):
            nearest = driver.nearest(place, 1).eigenvalues
            assert np.abs(nearest**2 + 0.5).min() < 1e-11


def test_verdicts_leave_open_what_errors_do():
    blocks = [*band(40, low=1.1), np.array([[0.5, 1.0], [-1e-18, 0.5]])]  # a pair that coalesces
    modes = solve_modes(pencil_with(blocks), HERTZ)
    near = np.abs(-(modes.eigenvalues**2) - 0.5) < 1e-3
    verdicts = np.array(modes.verdicts(1e-9))
    assert near.sum() == 2
    assert not (verdicts[near] == "stable").any()
    assert modes.verdict(1e-9) == "undecided"
    assert not modes.unstable(1e-9).any()


def test_modes_lost_to_rounding_are_refused():
    blocks = [[[1e-3]], *band(5), *[[[value]] for value in np.geomspace(1e15, 1e22, 30)]]
    with pytest.raises(ConvergenceError, match="lost to rounding") as caught:
        solve_modes(pencil_with(blocks), HERTZ)
    assert "stable" not in caught.value.best.verdicts()


def test_displacements_of_bodies_that_nothing_holds_are_refused(backend):
    data = two_blocks(backend, {"method": "gpts", "points": 3}, mu=0.0)
    data["analysis"] = {"kind": "static"}
    data["loads"] = [{"surface": "upper.x_min", "pressure": 1.0}]
    system = assemble(data)
    with pytest.raises(ConvergenceError, match="not held"):
        solve_static(system.pencil(), system.load)


@pytest.mark.parametrize("options", [KrylovOptions(), KRYLOV], ids=["LAPACK", "Krylov"])
def test_a_mode_that_rounding_moved_out_of_an_empty_window_is_told(options):
    """Rounding of 1e12 moves kappa = 1e-8 by 1e-4: it may lie anywhere about the window."""
    pencil = pencil_with([np.diag([1e-8, *np.logspace(6, 12, 29)])])
    with (
        EigenSolver(pencil, options) as driver,
        pytest.raises(ConvergenceError, match=r"rounding|inertia"),
    ):
        driver.solve(1e-4 * HERTZ * 2, hints=True)


def test_an_empty_window_names_the_lowest_mode_above():
    with EigenSolver(pencil_with([np.diag([4.0, 9.0, 16.0])])) as driver:
        modes = driver.solve(1.0 * HERTZ, hints=True)
    assert len(modes) == 0
    assert modes.window.lowest == pytest.approx(2.0 * HERTZ, rel=1e-9)


def test_growth_just_above_the_window_is_hinted_at():
    scene = load_scene("blocks", ["analysis.max_frequency=0.46"], "iga")
    (hint,) = run_modes(scene).modes.window.hints
    assert "+0.0274 1/s at 0.46125" in hint


def test_signs_of_determinants_know_damping_of_low_rank():
    """Negative stiffness: some shifts have an odd number of real eigenvalues beyond them."""
    rng = np.random.default_rng(4)
    stiffness = np.diag([-2.0, -1.0, 3.0, 4.0]) + 0.1 * rng.standard_normal((4, 4))
    piece = rng.standard_normal((4, 3)), np.array([1.0, 5.0, 0.3])
    matrices = pencil_of(np.eye(4), None, stiffness, piece).at()
    M, C, K = dense_pencil(matrices)
    found = []
    for shift in np.linspace(0.05, 2.0, 12):
        factors = Shifted.quadratic(matrices, float(shift))
        sign = np.sign(np.linalg.det(shift**2 * M + shift * C + K))
        assert factors.parity() == int(sign < 0)
        found.append(factors.parity())
        factors.free()
    assert set(found) == {0, 1}


@pytest.mark.parametrize(
    ("left", "right"), [(0.0, 1.01), (-0.1, 1.01), (-3.0, 1.01), (-1e3, 1.01), (-8.0, -1.0)]
)
def test_the_disc_covers_every_growth_of_its_part(left, right):
    """Modes with Im lambda <= 1 and left <= Re kappa <= right lie in it, those above 1.02 do not.

    Both ends lie on its edge: it reaches no farther to the right than it must.
    """
    rng = np.random.default_rng(1)
    value = rng.uniform(left - 2, 2 - left, 100_000) + 1j * rng.uniform(0, 1, 100_000)
    kappa = -(value**2)
    kappa = kappa[(kappa.real >= left) & (kappa.real <= right)]
    disc = covering_disc(1.0, left, right)
    assert len(kappa) > 1000
    assert (np.abs(kappa - disc.centre) <= disc.radius).all()
    assert disc.centre + disc.radius < 1.02
    ends = [np.hypot(x - disc.centre, 2 * np.sqrt(1.01 * (1.01 - x))) for x in (left, right)]
    assert ends == pytest.approx([disc.radius] * 2, rel=1e-12)


@pytest.mark.parametrize("coupling", [1e3, 1e4])
def test_errors_count_left_vectors_that_reach_out_of_the_window(coupling):
    """A triangular system, turned: modes beyond the window make its left vectors long."""
    inside, outside = np.linspace(1, 10, 10), np.linspace(20, 40, 50)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        turn = np.linalg.qr(rng.standard_normal((60, 60)))[0]
        coupled = np.zeros((60, 60))
        coupled[:10, 10:] = coupling * rng.standard_normal((10, 50)) / np.sqrt(60)
        stiffness = turn @ np.diag(np.r_[inside, outside]) @ turn.T
        matrices = (0.5 * (stiffness + stiffness.T), np.eye(60), -turn @ coupled @ turn.T)
        modes = solve_modes(sliding_pencil(*matrices), 0.55)
        assert len(modes) == 10
        true = 1j * np.sqrt(inside)
        distance = np.abs(modes.eigenvalues[:, None] - true).min(axis=1)
        assert (distance <= modes.growth_uncertainties).all()


def test_eigenvalues_that_friction_moves_out_are_told_from_missed_ones():
    """The symmetric part has one more than there is; a search beside those found finds no other."""
    stiffness = np.diag(np.r_[np.arange(1.0, 30.0), 40.0, np.arange(60.0, 400.0)])
    coupling = np.zeros((370, 370))
    coupling[29, 30], coupling[30, 29] = 30.0, -30.0
    modes = solve_modes(sliding_pencil(stiffness, np.eye(370), coupling), 6.6 * HERTZ)
    assert modes.window.complete
    assert modes.window.found_below == 29
    assert modes.verdict() == "stable"
    assert (-(modes.eigenvalues**2)).real == pytest.approx(np.arange(1.0, 30.0))


def test_failed_convergence_carries_the_best_answer():
    stiffness, friction = np.diag(np.arange(1.0, 501.0)), np.diag(np.full(499, 0.1), 1)
    options = KrylovOptions(tolerance=1e-300, max_restarts=1, dense_limit=0)
    with pytest.raises(ConvergenceError) as caught:
        solve_modes(sliding_pencil(stiffness, np.eye(500), friction), 0.5, options=options)
    assert isinstance(caught.value.best, Modes)


@pytest.mark.parametrize("options", [KrylovOptions(), KRYLOV], ids=["LAPACK", "Krylov"])
@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize("end", [1e3, 1e8, 1e12])
def test_a_window_far_wider_than_the_spectrum_changes_no_eigenvalue(options, damping, end):
    """A shift as far away as the end of the window would leave rounding alone."""
    kappa = np.array([*np.linspace(0.5, 400.0, 60), 2.0 + 1.0j, 2.0 - 1.0j])
    K = scipy.linalg.block_diag(np.diag(kappa[:-2].real), pair(2.0, 1.0))
    modes = solve_modes(
        pencil_of(np.eye(62), damping * np.eye(62), K), end * HERTZ, options=options
    )
    root = np.sqrt(damping**2 / 4 - kappa)
    exact = np.where(root.imag < 0, -root, root) - damping / 2
    assert modes.verdict() == "unstable"
    assert len(modes) == len(exact)
    errors = np.abs(modes.eigenvalues[:, None] - exact).min(axis=1)
    assert (errors <= modes.growth_uncertainties + 1e-9).all()
    assert modes.growth_uncertainties.max() < 1e-6
