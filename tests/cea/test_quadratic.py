"""Damped and rotating pencils: lumped systems, limits, derivatives, places, ranks, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from blocks import GPTS, assemble, coarse, two_blocks
from covering import covering
from damped_numbers import modally_damped_disc
from dense_reference import dense_quadratic
from mpi import on_ranks
from petsc_matrices import to_petsc
from random_pencils import pencil_of, random_quadratic
from reference_data import eigenvalues, stored
from scipy.sparse import diags_array, eye_array

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.driver import EigenSolver, solve_modes
from cea.eigen.field_of_values import bounded_growth, largest_growth
from cea.eigen.krylov_schur import KrylovOptions
from cea.eigen.pencil import Pencil, Term
from cea.eigen.unformed import LowRank, UnformedTerm
from cea.errors import ConvergenceError, InputError
from cea.reduced.full_solves import first_threshold

TOP = 1.0
"""End of the windows of the two blocks (Hz)."""
slow = pytest.mark.slow


def by_size(values):
    return np.array(sorted(values, key=lambda value: (round(value.imag, 9), value.real)))


DAMPED = [entry for entry in stored("lumped") if np.any(entry["C"])]


@pytest.mark.parametrize("entry", DAMPED, ids=lambda entry: entry["name"])
def test_lumped_systems_to_twelve_digits(entry):
    M, C, K = (np.array(entry[name], dtype=float) for name in ("M", "C", "K"))
    modes = solve_modes(pencil_of(M, C, K), 0.4, min_growth=-1.0)
    exact = np.array([value for value in eigenvalues(entry) if value.imag >= 0])
    found = modes.eigenvalues
    assert len(found) == len(exact)
    distance = np.abs(by_size(found) - by_size(exact))
    assert (distance < 1e-12 * np.abs(exact).min()).all()
    assert modes.window.complete
    assert modes.residuals.max() < 1e-13
    assert (modes.growth_uncertainties < 1e-12).all()
    grows = (exact.real > 0).any()
    assert modes.verdict() == ("unstable" if grows else "stable")


def hulten(c1, c2):
    """The Hulten model with mu as its parameter."""
    mu = Coefficient({"mu": (1.0, 1.0)})
    return Pencil(
        [
            Term("mass", to_petsc(np.eye(2))),
            Term("damping", to_petsc(np.diag([c1, c2]))),
            Term("stiffness", to_petsc(np.diag([1.0, 1.44]))),
            Term("stiffness", to_petsc(np.array([[0, -1.44], [1.0, 0]])), mu, symmetric=False),
        ],
        [Parameter("mu", 0.3)],
    )


@pytest.mark.parametrize(
    ("mu", "c1", "c2"), [(0.3, 0.02, 0.02), (0.3, 0.02, 0.1), (0.1, 0.002, 0.02)]
)
def test_the_threshold_of_a_damped_system_is_exact(mu, c1, c2):
    name = f"Hulten mu={mu} c=({c1},{c2})"
    entry = next(entry for entry in stored("lumped") if entry["name"] == name)
    exact = float(entry["info"]["mu_c"])
    with EigenSolver(hulten(c1, c2)) as driver:
        found = first_threshold(driver, "mu", 0.01, 0.5, max_frequency=0.3)
        assert found.value == pytest.approx(exact, rel=1e-10)
        assert abs(found.eigenvalue.real) < 1e-12


@pytest.mark.parametrize(
    ("backend", "form", "mu"),
    covering(["fe", "iga"], ["penalty", "saddle"], [0.0, 0.4], strength=1),
)
def test_proportional_damping_turns_eigenvalues_as_it_must(backend, form, mu):
    """With C = alpha M, lambda^2 + alpha lambda is -kappa of the undamped pencil."""
    data, alpha = coarse(two_blocks(backend, GPTS, mu=mu, held=True, form=form)), 0.05
    kappa = -(solve_modes(assemble(data).pencil(), TOP).eigenvalues ** 2)
    expected = -0.5 * alpha + np.sqrt(0.25 * alpha**2 - kappa + 0j)
    expected = np.where(expected.imag < 0, -alpha - expected, expected)
    for body in data["bodies"].values():
        body["damping"] = {"alpha": alpha}
    modes = solve_modes(assemble(data).pencil(), 0.95 * TOP)
    expected = [v for v in expected if v.imag < 0.95 * 2 * np.pi * TOP]
    assert len(expected) > 3
    assert by_size(modes.eigenvalues) == pytest.approx(by_size(expected), abs=1e-9)
    assert modes.window.complete
    assert modes.residuals.max() < 1e-9


def test_derivatives_are_those_of_differences():
    """With friction, damping, rotation and a piece of low rank; eigenvalues are simple."""
    random = np.random.default_rng(5)
    turn, whole = random.standard_normal((2, 8, 8))
    M = np.eye(8) + 0.1 * turn @ turn.T
    K = np.diag(np.linspace(1.0, 20.0, 8)) + 0.4 * whole
    D = 0.02 * np.eye(8) + 0.01 * turn @ turn.T + 0.1 * (whole - whole.T)
    piece = LowRank(random.standard_normal((8, 2)), np.array([0.02, 0.1]))
    names = ("mass", "damping", "stiffness", "low rank")
    by_name = {name: Coefficient({name: (1.0, 1.0)}) for name in names}
    terms = [replace(t, coefficient=by_name[t.role]) for t in pencil_of(M, D, K).terms]
    parameters = [Parameter(name, 1.0) for name in names]
    low_rank = [UnformedTerm(piece, by_name["low rank"])]
    pencil, end = Pencil(terms, parameters, low_rank=low_rank), 0.6
    modes = solve_modes(pencil, end, left=True)
    assert len(modes) > 4
    step = 1e-5
    for name in names:
        slopes = modes.sensitivity(name)
        more, less = (
            solve_modes(pencil, 1.1 * end, {name: 1 + s}, min_growth=-end).eigenvalues
            for s in (step, -step)
        )
        for value, slope in zip(modes.eigenvalues, slopes, strict=True):
            ahead = more[np.argmin(np.abs(more - value - step * slope))]
            behind = less[np.argmin(np.abs(less - value + step * slope))]
            difference = (ahead - behind) / (2 * step)
            rel, least = (1e-6, 0.0) if name == "low rank" else (1e-5, 1e-6 * abs(value))
            assert slope == pytest.approx(difference, rel=rel, abs=least)


@pytest.mark.parametrize("seed", [0, 31])
def test_windows_of_rigid_motions_alone_have_left_vectors(seed):
    """Theirs are rounding of zero, right and left: they are alike beside the window."""
    problem = random_quadratic(seed)
    modes = solve_modes(
        problem.pencil(), problem.max_frequency, min_growth=problem.min_growth, left=True
    )
    assert np.abs(modes.eigenvalues).max() < 1e-6 * 2 * np.pi * problem.max_frequency
    y = modes.left.vectors / np.linalg.norm(modes.left.vectors, axis=0)
    assert np.abs(y.conj().T @ problem.stiffness).max() < 1e-6 * np.abs(problem.stiffness).max()


@pytest.mark.parametrize(
    ("name", "value"),
    [("max_frequency", 0.0), *(("min_growth", value) for value in (0.5, -np.inf, np.nan))],
)
def test_ends_of_windows_are_checked(name, value):
    with pytest.raises(InputError, match=name):
        solve_modes(hulten(0.1, 0.1), **{"max_frequency": 1.0} | {name: value})


def damped_disc(form):
    """Modes of a damped disc that rotates under a damped pad, which slides."""
    pencil = assemble(modally_damped_disc("iga", form=form)).pencil()
    modes = solve_modes(pencil, 0.3, options=KrylovOptions(dense_limit=0), left=True)
    with EigenSolver(pencil) as driver:
        near = driver.nearest(-((0.2 + 1j) ** 2), 3).eigenvalues
    slopes = np.abs(modes.sensitivity("contacts.interface.mu"))
    values = modes.eigenvalues
    found = {"re": values.real, "im": values.imag, "slopes": slopes, "near": [near.real, near.imag]}
    return {name: np.ravel(each).tolist() for name, each in found.items()}


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "form"),
    [(2, "saddle"), *(pytest.param(*case, marks=slow) for case in ((2, "penalty"), (3, "saddle")))],
)
def test_numbers_do_not_depend_on_the_ranks(ranks, form):
    alone, together = damped_disc(form), on_ranks(ranks, damped_disc, form)
    assert len(alone["re"]) > 3
    for name, values in alone.items():
        assert together[name] == pytest.approx(values, rel=1e-8, abs=1e-9)


def overdamped(n, end, rate=0.1):
    """A string of which modes crowd at one rate of decay, relative to the end of the window."""
    ones = np.ones(n)
    K = diags_array([2 * ones, -ones[1:], -ones[1:]], offsets=[0, 1, -1]) * (n + 1.0) ** 2
    return Pencil(
        [
            Term("mass", to_petsc(eye_array(n))),
            Term("stiffness", to_petsc(K)),
            Term("damping", to_petsc(K / (rate * end))),
        ]
    )


def exact_overdamped(n, end, rate=0.1):
    """Its eigenvalues."""
    kappa = 4 * (n + 1) ** 2 * np.sin(np.arange(1, n + 1) * np.pi / (2 * (n + 1))) ** 2
    drag = kappa / (2 * rate * end)
    return np.concatenate([-drag + s * np.sqrt(drag**2 - kappa + 0j) for s in (1, -1)])


@pytest.mark.parametrize("rate", [0.1, 0.5, *(pytest.param(r, marks=slow) for r in (0.3, 0.7))])
def test_overdamped_modes_that_crowd_shorten_a_window_that_they_lie_in_alone(rate):
    n, end, options = 300, 20.5 * np.pi, KrylovOptions(dense_limit=0)
    modes = solve_modes(overdamped(n, end, rate), end / (2 * np.pi), options=options)
    exact, least = exact_overdamped(n, end, rate), modes.window.min_growth
    asked = exact[(exact.imag >= 0) & (exact.imag <= end) & (exact.real >= least)]
    assert len(asked)
    assert modes.eigenvalues == pytest.approx(asked[np.argsort(asked.imag)], abs=1e-8)
    assert modes.verdict() == "stable"
    if rate == 0.1:
        assert -0.1 * end < least < 0
    else:
        assert least == pytest.approx(-0.1 * end)


@pytest.mark.slow
def test_overdamped_modes_that_crowd_in_the_window_are_refused():
    end = 20.5 * np.pi
    with pytest.raises(ConvergenceError, match="min_growth"):
        solve_modes(overdamped(1200, end), end / (2 * np.pi), min_growth=-0.3 * end)


def test_bounds_of_growth_hold():
    bounds = 0
    for seed in range(30):
        problem = random_quadratic(seed)
        end = 2 * np.pi * problem.max_frequency
        values, errors = dense_quadratic(problem.mass, problem.damping, problem.stiffness, end)
        inside = np.abs(values.imag) < end - errors
        fastest = (values.real - 10 * errors)[inside].max(initial=-np.inf)
        matrices = problem.pencil().at()
        assert largest_growth(matrices, end) >= fastest
        for part in (0.5, 1.5, 6.0):
            if bounded_growth(matrices, part * end, end):
                bounds += 1
                assert fastest <= part * end
    assert bounds > 30


N = 120
WANTED = 6


def matrices(seed=1, *, friction=0.3, turning=0.2, damping=0.02):
    """M, D, K of size N: stiff springs in a row, damped, rotating, with friction."""
    random = np.random.default_rng(seed)
    mass = np.diag(random.uniform(1.0, 2.0, N))
    stiffness = np.diag(np.linspace(1.0, 60.0, N) ** 2)
    coupling = 0.5 * np.diag(random.standard_normal(N - 1), 1)
    stiffness = stiffness + coupling + coupling.T + friction * np.diag(np.ones(N - 2), 2)
    skew = turning * np.diag(random.standard_normal(N - 1), 1)
    return mass, np.diag(damping * np.sqrt(np.diag(stiffness))) + skew - skew.T, stiffness


def in_upper_half(M, D, K, scale):
    values, _ = dense_quadratic(M, D, K, scale)
    return values[values.imag >= -1e-9 * scale]


def assert_nearest(modes, dense, place, wanted=WANTED):
    """As many as were wanted or a few more, each once, and none nearer was passed over."""
    found = modes.eigenvalues
    assert len(found) >= wanted
    expected = dense[np.argsort(np.abs(dense - place))[: len(found)]]
    distance = np.abs(found[:, None] - expected)
    error = 1e-9 * abs(place)
    assert distance.min(axis=0).max() < error
    assert distance.min(axis=1).max() < error


@pytest.mark.parametrize(
    ("low_rank", "place"),
    covering([False, True], [20j, 1 + 20j, -0.5 + 35j, 3 + 3j, 5.0, 1e-3 + 1j], strength=1),
)
def test_those_nearest_to_complex_and_real_places_are_found(place, low_rank):
    M, D, K = matrices()
    piece = None
    if low_rank:
        random = np.random.default_rng(2)
        piece = 0.1 * random.standard_normal((N, 3)), np.array([1.0, 2.0, 0.5])
    whole = D if piece is None else D + (piece[0] * piece[1]) @ piece[0].T
    dense = in_upper_half(M, whole, K, abs(place))
    with EigenSolver(pencil_of(M, D, K, piece)) as driver:
        modes = driver.nearest(-(place**2), WANTED)
        assert (driver.solves, driver.factorisations) == (1, 1)
    assert_nearest(modes, dense, place)
    assert modes.residuals.max() < 1e-11
    assert not modes.window.complete
    assert "nearest to" in modes.window.evidence


def test_overdamped_ones_next_to_a_real_place_are_real():
    M, _, K = matrices(friction=0.0, turning=0.0)
    D = 3 * np.sqrt(np.diag(np.diag(M) * np.diag(K)))  # each decays without swinging
    dense, _ = dense_quadratic(M, D, K, 1.0)
    assert np.abs(dense.imag).max() < 1e-6
    with EigenSolver(pencil_of(M, D, K)) as driver:
        modes = driver.nearest(-1.0, WANTED)
    assert_nearest(modes, dense, 1.0)
    assert (modes.eigenvalues.imag == 0).all()


def test_more_than_there_are_gives_all():
    M, D, K = np.eye(3), 0.1 * np.eye(3), np.diag([1.0, 4.0, 9.0])
    dense = in_upper_half(M, D, K, 1.0)
    with EigenSolver(pencil_of(M, D, K)) as driver:
        found = driver.nearest(2.0, 50).eigenvalues
    assert found == pytest.approx(dense[np.argsort(dense.imag)], rel=1e-12)


def test_what_cannot_be_a_place_is_refused():
    M, D, K = matrices()
    with EigenSolver(pencil_of(M, D, K)) as driver:
        for kappa in (0.0, np.nan, complex(1, np.inf)):
            with pytest.raises(InputError, match="not zero"):
                driver.nearest(kappa, 1)
        with pytest.raises(InputError, match="1 or more"):
            driver.nearest(1.0, 0)
    linear = EigenSolver(Pencil.of(to_petsc(K), to_petsc(M)))
    with linear, pytest.raises(InputError, match="real number"):
        linear.nearest(1 + 1j, 1)
