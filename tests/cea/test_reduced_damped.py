"""Reduced models of damped and rotating pencils: bounds that full and dense solves never pass."""

from itertools import product

import numpy as np
import pytest
from reduced_cases import (
    ALPHA,
    MU,
    RATIO,
    P,
    damped_blocks_pencil,
    dense_damped,
    enrichment,
    model_line,
    random_damped_pencil,
)

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.pencil import FRICTION
from cea.reduced.greedy import largest_ratio
from cea.reduced.model import Snapshot
from cea.reduced.pieces import Pieces
from cea.reduced.thresholds import thresholds_along
from cea.reduced.window import MARGIN

TOP = 0.6
RNG = np.random.default_rng(13)
BOX = {MU: (0.0, 1.0), P: (5.0, 50.0), ALPHA: (0.0, 0.1), RATIO: (0.0, 0.04)}
ON_NURBS = pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
"""The maps of finite elements, which take as long again, are among the slow tests."""


@pytest.fixture(scope="module")
def maps():
    """A map over friction, stiffness, Rayleigh and modal damping for each backend, made once."""
    made = {}

    def of(backend):
        if backend not in made:
            built = enrichment(damped_blocks_pencil(backend), BOX, TOP)
            values = product((0.0, 0.6, 1.0), (5.0, 50.0), (0.0, 0.1), (0.0, 0.04))
            points = [dict(zip(BOX, map(float, each), strict=True)) for each in values]
            assert built.cover(points) <= built.tolerance
            made[backend] = built
        return made[backend]

    return of


def apart(found, modes):
    """Distances of eigenvalues of a window from those of a full solve, and which these are."""
    window = found.window
    rows, columns = assign(np.abs(window.eigenvalues[:, None] - modes.eigenvalues))
    assert len(rows) == len(window)
    return np.abs(window.eigenvalues[rows] - modes.eigenvalues[columns]), columns


@ON_NURBS
def test_values_between_full_solves_are_those_of_full_solves(maps, backend):
    built = maps(backend)
    assert len(built.solves) < 12
    tested = [e.error_over_bound for e in built.solves if e.error_over_bound is not None]
    assert tested
    assert max(tested) <= 1
    full, reach = EigenSolver(built.model.pencil), built.model.small.settings.reach
    for _ in range(4):
        point = dict(zip(BOX, (RNG.uniform(*ends) for ends in BOX.values()), strict=True))
        modes = full.solve(MARGIN * TOP, point, min_growth=-reach, left=True)
        found = built.at(point)
        distances, columns = apart(found, modes)
        assert (distances / found.window.speeds).max() < 1e-8
        assert largest_ratio(found, Snapshot.of(point, modes)) <= 1
        assert (distances <= found.window.uncertainties + modes.growth_uncertainties[columns]).all()
        assert found.window.eigenvalues.real.max() < 0 or point[MU] > 0


@pytest.mark.parametrize("seed", [0, *(pytest.param(s, marks=pytest.mark.slow) for s in (1, 2))])
def test_no_bound_is_passed_wherever_the_basis_is_poor(seed):
    """From bases that know far too little to such as know all: dense eigenvalues are the judge."""
    pencil, matrices = random_damped_pencil(seed)
    built = enrichment(pencil, {FRICTION: (0.0, 1.0), "Omega": (0.0, 0.3)}, 5.0 / (2 * np.pi))
    told = 0
    for s, turning in ((0.8, 0.1), (0.1, 0.3), (0.45, 0.0)):
        built.solve({FRICTION: s, "Omega": turning})
        for point in RNG.uniform(0, (1.0, 0.3), (10, 2)):
            found = built.at(dict(zip((FRICTION, "Omega"), point, strict=True))).window
            values = dense_damped(matrices, *point)
            rows, columns = assign(np.abs(found.eigenvalues[:, None] - values))
            difference = np.abs(found.eigenvalues[rows] - values[columns])
            certain = found.uncertainties < 0.01 * found.speeds
            assert (difference <= found.uncertainties + 1e-11)[certain].all()
            told += certain.sum()
    assert told > 45


def test_near_a_coalescence_members_and_means_keep_their_bounds():
    """Two modes of equal damping that coalesce at s = 1 exactly, in a dense system of forty."""
    pencil, matrices = random_damped_pencil(0, equal=True)
    built = enrichment(pencil, {FRICTION: (0.0, 1.5)}, 5.0 / (2 * np.pi))
    for s in (0.0, 0.7, 1.5):
        built.solve({FRICTION: s})
    for distance, side in product((1e-2, 1e-4, 1e-6, 1e-8), (-1, 1)):
        s = 1 + side * distance
        found, values = built.at({FRICTION: s}).window, dense_damped(matrices, s, 0.0)
        pair = np.argsort(np.abs(found.eigenvalues - (1.5j - 0.02)))[:2]
        theirs = values[np.argsort(np.abs(values - (1.5j - 0.02)))[:2]]
        mean = abs(found.eigenvalues[pair].mean() - theirs.mean())
        speed = found.speeds[pair].max()
        assert mean <= found.means[pair].max() + 1e-11
        rows, columns = assign(np.abs(found.eigenvalues[pair][:, None] - theirs))
        difference = np.abs(found.eigenvalues[pair][rows] - theirs[columns])
        assert (difference <= found.uncertainties[pair][rows] + 1e-7).all()
        assert found.means[pair].max() / speed < 1e-6


@ON_NURBS
def test_a_threshold_of_growth_is_that_of_full_solves(maps, backend):
    built = maps(backend)
    point = {P: 40.0, ALPHA: 0.01, RATIO: 0.005}
    line = thresholds_along(model_line(built, MU, point), np.linspace(0.5, 1, 9).tolist())
    found = line.thresholds[0]
    assert found.begins
    assert not line.unresolved
    with EigenSolver(damped_blocks_pencil(backend, point)) as driver:
        modes = driver.solve(TOP, {MU: found.value})
    own = int(np.argmin(np.abs(modes.eigenvalues - found.eigenvalue)))
    off = abs(modes.growth_rates[own] / found.slope)
    assert off < 1e-8 * found.value
    assert off <= found.error + 1e-11
    others = np.delete(modes.growth_rates, own)
    assert others.max() < 0, "it is where the first begins to grow"


def test_derivatives_of_coefficients_are_those_of_differences(backend):
    """Of every piece, forces that were unknowns included."""
    pencil = damped_blocks_pencil(backend, form="saddle")
    pieces = Pieces(pencil, (P, MU, ALPHA, RATIO))
    values, names = pencil.values({P: 7.0, MU: 0.3, ALPHA: 0.02}), {P, MU, ALPHA, RATIO}
    seen = set()
    for coefficient in (piece.coefficient for piece in pieces.all):
        for name in coefficient.names & names:
            seen.add(name)
            step = 1e-6 * max(values[name], 1e-3)
            ends = [coefficient.at(values | {name: values[name] + d}) for d in (-step, step)]
            slope = coefficient.derivative(name, values)
            assert slope == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-6, abs=1e-12)
    assert seen == names
    pieces.free()
