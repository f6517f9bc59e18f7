"""Reduced models, damped and not: bounds that dense eigenvalues never pass."""

from itertools import product

import numpy as np
import pytest
from covering import covering
from petsc_matrices import FRICTION, quadratic_eigenvalues, sliding_pencil, to_petsc
from scipy.linalg import eig

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.pencil import Pencil, Term
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel

RNG = np.random.default_rng(7)


def enrichment(pencil, box, top):
    """A reduced model of a pencil with nothing in it yet, and what fills it."""
    return Enrichment(ReducedModel(pencil, box, top), EigenSolver(pencil))


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
        return sliding_pencil(S, M, F), lambda s: eig(S - s * F, M)[0]
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
        values = quadratic_eigenvalues(M, C + turning * G, S - s * F)
        return values[values.imag >= 0]

    return Pencil(terms, [Parameter(FRICTION, 1.0), Parameter("Omega", 0.0)]), dense


@pytest.mark.parametrize(
    ("damped", "drawn"), covering([True, False], [(0, 0.0), (3, 4.0)], strength=1)
)
def test_no_bound_is_passed_wherever_the_basis_is_poor(damped, drawn):
    """From bases that know far too little to such as know all: dense eigenvalues are the judge.

    Lowered by 4 the first two modes diverge.
    """
    seed, lowered = drawn
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
