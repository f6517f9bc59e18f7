"""Reduced models, damped and not: bounds that neither full nor dense solves ever pass."""

from functools import cache
from itertools import product

import numpy as np
import pytest
from blocks import assemble, coarse, two_blocks
from petsc_matrices import to_petsc
from scipy.linalg import eig

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.pencil import FRICTION, Pencil, Term
from cea.reduced.basis import Span
from cea.reduced.greedy import Enrichment, largest_ratio
from cea.reduced.model import ReducedModel, Snapshot
from cea.reduced.window import MARGIN

MU, P = "contacts.interface.mu", "contacts.interface.P"
ALPHA, RATIO = "bodies.upper.damping.alpha", "bodies.lower.damping.modal.ratio"
TOP = 0.6
BOX = {MU: (0.0, 1.0), P: (5.0, 50.0), ALPHA: (0.0, 0.1), RATIO: (0.0, 0.04)}
TRAINING = ((0.0, 0.6, 1.0), (5.0, 50.0), (0.0, 0.1), (0.0, 0.04))
ON_NURBS = pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
"""The maps of finite elements, which take as long again, are among the slow tests."""
RNG = np.random.default_rng(7)


def enrichment(pencil, box, top):
    """A reduced model of a pencil with nothing in it yet, and what fills it."""
    return Enrichment(ReducedModel(pencil, box, top), EigenSolver(pencil))


def errors_of_means(found, z):
    """Errors of the means of clusters of a damped window relative to speeds."""
    window, errors = found.window, []
    rows, columns = assign(np.abs(window.z[:, None] - z))
    assert len(rows) == len(window)
    for number in np.unique(window.clusters):
        own = window.clusters[rows] == number
        speed = window.speeds[rows][own].max()
        errors.append(abs((window.z[rows] - z[columns])[own].mean()) / speed)
    return np.array(errors)


def blocks_pencil(backend):
    """Two small blocks that rub, held at bottom and top; one Rayleigh, one modally damped."""
    scene = coarse(two_blocks(backend, {"method": "gpts", "points": 3}, held=True, P=3.0))
    scene["bodies"]["upper"]["damping"] = {"alpha": 0.05, "beta": 0.0}
    modal = {"ratio": 0.02, "max_frequency": 0.7}
    scene["bodies"]["lower"]["damping"] = {"modal": modal}
    return assemble(scene, leave_out=False).pencil()


def random_pencil(seed, *, damped=False, equal=False, lowered=0.0):
    """A dense pencil S - s F of friction s whose lowest modes flutter below one.

    And its eigenvalues: kappa at s, or lambda with Im lambda >= 0 at s and Omega where it is
    ``damped`` and turns with Omega. Where modes are ``equal`` its damping is 0.04 M, its friction
    between two modes alone: lambda is known then, and the two coalesce at s = 1. Where kappa is
    ``lowered`` the stiffness is not positive.
    """
    rng, n = np.random.default_rng(seed), 40 if damped else 90
    axes, _ = np.linalg.qr(rng.standard_normal((n, n)))
    kappa = np.arange(1.0, n + 1) ** 1.5
    coupling = rng.standard_normal((n, n)) / (1 + 0.05 * np.add.outer(kappa, kappa) ** 0.5)
    if equal:  # kappa^2 - (a + b) kappa + a b + c^2 s^2 has a double root at s = 1
        kappa[:2], coupling = (1.5**2 - 0.3, 1.5**2 + 0.3), np.zeros((n, n))
        coupling[0, 1], coupling[1, 0] = 0.3, -0.3
    root = np.diag(rng.uniform(0.7, 1.4, n))
    S = root @ axes @ np.diag(kappa - lowered) @ axes.T @ root
    F = root @ axes @ coupling @ axes.T @ root
    S, M = 0.5 * (S + S.T), root @ root
    if not damped:
        return Pencil.of(to_petsc(S), to_petsc(M), to_petsc(F)), lambda s: eig(S - s * F, M)[0]
    part = rng.standard_normal((n, n)) / n
    C, G = (0.04 * M, 0 * M) if equal else (0.02 * M + part @ part.T, part - part.T)
    s, turning = Coefficient({FRICTION: (1.0, 1.0)}, -1.0), Coefficient({"Omega": (1.0, 1.0)})
    terms = [
        Term("stiffness", to_petsc(S)),
        Term("mass", to_petsc(M)),
        Term("stiffness", to_petsc(F), s, symmetric=False),
        Term("damping", to_petsc(C)),
        Term("damping", to_petsc(G), turning, symmetric=False),
    ]

    def dense(s, turning=0.0):
        nothing, one = np.zeros_like(M), np.eye(n)
        first = np.block([[nothing, one], [-(S - s * F), -(C + turning * G)]])
        values = eig(first, np.block([[one, nothing], [nothing, M]]), right=False)
        return values[values.imag >= 0]

    return Pencil(terms, [Parameter(FRICTION, 1.0), Parameter("Omega", 0.0)]), dense


@pytest.fixture(scope="module")
def maps():
    """Maps over friction, stiffness and damping, made once."""

    @cache
    def of(backend):
        built = enrichment(blocks_pencil(backend), BOX, TOP)
        points = [dict(zip(BOX, map(float, each), strict=True)) for each in product(*TRAINING)]
        assert built.cover(points) <= built.tolerance
        return built

    return of


@ON_NURBS
def test_values_between_full_solves_are_those_of_full_solves(maps, backend):
    built = maps(backend)
    assert len(built.solves) < 12
    tested = [e["tested"] for e in built.solves if e["tested"] is not None]
    assert 0 < max(tested) <= 1
    full, window = EigenSolver(built.model.pencil), built.model.small.window
    for _ in range(4):
        point = {name: RNG.uniform(*ends) for name, ends in BOX.items()}
        modes = full.solve(MARGIN * TOP, point, min_growth=-window.reach, left=True)
        found = built.at(point)
        assert errors_of_means(found, modes.eigenvalues).max() < 1e-8
        assert largest_ratio(found, Snapshot.of(point, modes)) <= 1
        assert found.worst < 1e-7
        own = found.window
        rows, columns = assign(np.abs(own.eigenvalues[:, None] - modes.eigenvalues))
        off = np.abs(own.eigenvalues[rows] - modes.eigenvalues[columns])
        assert (off <= own.uncertainties[rows] + modes.growth_uncertainties[columns]).all()
        assert (off / own.speeds[rows]).max() < 1e-8


@pytest.mark.parametrize(
    ("damped", "seed", "lowered"),
    [
        (False, 0, 0.0),
        (False, 1, 0.0),
        (False, 2, 0.0),
        (False, 3, 4.0),
        (True, 0, 0.0),
        (True, 3, 4.0),
        pytest.param(True, 1, 0.0, marks=pytest.mark.slow),
        pytest.param(True, 2, 0.0, marks=pytest.mark.slow),
    ],
)
def test_no_bound_is_passed_wherever_the_basis_is_poor(damped, seed, lowered):
    """From bases that know far too little to such as know all: dense eigenvalues are the judge.

    Lowered by 4 the first two modes diverge.
    """
    pencil, dense = random_pencil(seed, damped=damped, lowered=lowered)
    ends = {FRICTION: 1.0, "Omega": 0.3} if damped else {FRICTION: 1.0}
    built = enrichment(pencil, {name: (0.0, end) for name, end in ends.items()}, 5 / (2 * np.pi))
    told = 0
    for solved in ((0.8, 0.1), (0.1, 0.3), (0.45, 0.0)):
        built.solve(dict(zip(ends, solved, strict=False)))
        for point in RNG.uniform(0, list(ends.values()), (10, len(ends))):
            found = built.at(dict(zip(ends, point, strict=True))).window
            z = dense(*point)
            rows, columns = assign(np.abs(found.z[:, None] - z))
            difference = np.abs(found.z[rows] - z[columns])
            certain = found.errors < (0.01 * found.speeds if damped else 0.02 * found.speeds**2)
            assert (difference <= found.errors + 1e-11)[certain].all()
            told += certain.sum()
    assert told > 45


def test_near_a_coalescence_members_and_means_keep_their_bounds():
    """Two modes of equal damping that coalesce at s = 1 exactly, in a dense system of forty."""
    pencil, dense = random_pencil(0, damped=True, equal=True)
    built = enrichment(pencil, {FRICTION: (0.0, 1.5)}, 5.0 / (2 * np.pi))
    for s in (0.0, 0.7, 1.5):
        built.solve({FRICTION: s})
    for distance, side in product((1e-2, 1e-4, 1e-6, 1e-8), (-1, 1)):
        s = 1 + side * distance
        found, values = built.at({FRICTION: s}).window, dense(s)
        pair = np.argsort(np.abs(found.eigenvalues - (1.5j - 0.02)))[:2]
        theirs = values[np.argsort(np.abs(values - (1.5j - 0.02)))[:2]]
        mean = abs(found.eigenvalues[pair].mean() - theirs.mean())
        speed = found.speeds[pair].max()
        assert mean <= found.means[pair].max() + 1e-11
        rows, columns = assign(np.abs(found.eigenvalues[pair][:, None] - theirs))
        difference = np.abs(found.eigenvalues[pair][rows] - theirs[columns])
        assert (difference <= found.uncertainties[pair][rows] + 1e-7).all()
        assert found.means[pair].max() / speed < 1e-6


@pytest.mark.parametrize("decades", [0, 5, 11, 16])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_a_span_is_orthonormal_and_leaves_out_what_it_says(maps, decades, tolerance):
    """Of blocks whose singular values fall by so many decades, and what is known of them."""
    norms = maps("iga").model.norms
    norm, span = norms.states, Span(norms.states)
    for scale in (1.0, 1e9):
        left, right = (np.linalg.qr(RNG.standard_normal((n, 12)))[0] for n in (norm.rows, 12))
        block = scale * norms.solve((left * np.logspace(0, -decades, 12)) @ right)
        mixed = np.hstack([block, span.vectors @ RNG.standard_normal((span.size, 3))])
        longest = norm.lengths(mixed).max()
        coordinates, lost = span.add(mixed, norm.image(mixed), tolerance * longest)
        gram = span.vectors.T @ norm.image(span.vectors)
        assert np.abs(gram - np.eye(span.size)).max() < 1e-12
        assert lost <= tolerance * longest
        rest = norm.lengths(mixed - span.vectors @ coordinates)
        assert rest.max() <= lost + 1e-13 * longest
    assert span.size <= 24
