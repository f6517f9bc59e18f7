"""Reduced models: eigenvalues between full solves, and bounds that none of them passes."""

import numpy as np
import pytest
from mpi import on_ranks
from reduced_cases import (
    MU,
    P,
    blocks_pencil,
    dense,
    enrichment,
    errors_of_means,
    grid,
    map_numbers,
    random_pencil,
)
from same_numbers import assert_same

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.pencil import FRICTION
from cea.errors import InputError
from cea.reduced.greedy import largest_ratio
from cea.reduced.model import Snapshot
from cea.reduced.window import MARGIN

TOP = 0.6
ON_NURBS = pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
"""The maps of finite elements, which take as long again, are among the slow tests."""
RNG = np.random.default_rng(7)


@pytest.fixture(scope="module")
def maps():
    """A map over mu and six decades of P for each backend, made once."""
    made = {}

    def of(backend):
        if backend not in made:
            pencil = blocks_pencil(backend)
            built = enrichment(pencil, {MU: (0.0, 1.0), P: (0.1, 1e5)}, TOP)
            left = built.cover(grid(mu=np.linspace(0, 1, 3), P=np.geomspace(0.1, 1e5, 7)))
            assert left <= built.tolerance
            made[backend] = built
        return made[backend]

    return of


@ON_NURBS
def test_values_between_full_solves_are_those_of_full_solves(maps, backend):
    built = maps(backend)
    assert len(built.solves) < 12
    tested = [e.error_over_bound for e in built.solves if e.error_over_bound is not None]
    assert 0 < max(tested) <= 1
    full = EigenSolver(built.model.pencil)
    for mu, decade in zip(RNG.uniform(0, 1, 4), RNG.uniform(-1, 5, 4), strict=True):
        point = {MU: mu, P: 10**decade}
        modes = full.solve(MARGIN * TOP, point, left=True)
        found = built.at(point)
        assert errors_of_means(found, -(modes.eigenvalues**2)).max() < 1e-8
        assert largest_ratio(found, Snapshot.of(point, modes)) <= 1
        assert found.worst < 1e-7


@pytest.mark.parametrize("seed", range(3))
def test_no_bound_is_passed_wherever_the_basis_is_poor(seed):
    """From bases that know far too little to such as know all: dense eigenvalues are the judge."""
    pencil, matrices = random_pencil(seed)
    top = 5.0 / (2 * np.pi)
    built = enrichment(pencil, {FRICTION: (0.0, 1.0)}, top)
    told = 0
    for solved in (0.8, 0.1, 0.45):
        built.solve({FRICTION: solved})
        for s in RNG.uniform(0, 1, 10):
            found, kappa = built.at({FRICTION: s}).window, dense(matrices, s)
            rows, columns = assign(np.abs(found.z[:, None] - kappa))
            difference = np.abs(found.z[rows] - kappa[columns])
            certain = found.errors < 0.02 * found.speeds**2
            assert (difference <= found.errors + 1e-11)[certain].all()
            told += certain.sum()
    assert told > 45


@ON_NURBS
def test_materials_are_parameters_too(backend):
    pencil = blocks_pencil(backend)
    E, rho = "bodies.upper.material.E", "bodies.lower.material.rho"
    built = enrichment(pencil, {E: (1.0, 3.0), rho: (1.0, 2.0)}, TOP)
    built.cover([{E: e, rho: r} for e in (1.0, 1.7, 3.0) for r in (1.0, 1.5, 2.0)])
    point = {E: 1.37, rho: 1.81}
    modes = EigenSolver(pencil).solve(MARGIN * TOP, point)
    assert errors_of_means(built.at(point), -(modes.eigenvalues**2)).max() < 1e-8


def test_tied_sides_that_rub_have_a_reduced_model(backend):
    """P = inf along the normal, friction alive: beside fresh solves."""
    pencil = blocks_pencil(backend, P=np.inf, form="saddle")
    built = enrichment(pencil, {MU: (0.0, 1.0)}, TOP)
    assert built.cover([{MU: mu} for mu in np.linspace(0, 1, 5).tolist()]) <= built.tolerance
    modes = EigenSolver(pencil).solve(MARGIN * TOP, {MU: 0.63}, left=True)
    found = built.at({MU: 0.63})
    assert errors_of_means(found, -(modes.eigenvalues**2)).max() < 1e-8
    assert largest_ratio(found, Snapshot.of({MU: 0.63}, modes)) <= 1


def test_what_is_no_parameter_is_refused():
    pencil, _ = random_pencil(0)
    with pytest.raises(InputError, match="one of"):
        enrichment(pencil, {"speed": (0.0, 1.0)}, TOP)


@pytest.mark.mpi
@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_maps_are_the_same_on_several_ranks(backend):
    ranks = {"fe": 3, "iga": 2}[backend]
    found = on_ranks(ranks, "reduced_cases.map_numbers", backend)
    assert_same(found, map_numbers(backend), rel=1e-8)
