"""Bases of reduced models: what they span, at which products, and what is found on smaller ones."""

import numpy as np
import pytest
from reduced_cases import MU, P, blocks_pencil, enrichment, grid

from cea.reduced import greedy
from cea.reduced.model import ReducedModel
from cea.reduced.products import real_times
from cea.reduced.span import Span

TOP = 0.6
RNG = np.random.default_rng(11)


@pytest.fixture(scope="module")
def model():
    made = ReducedModel(blocks_pencil("fe"), {MU: (0.0, 1.0), P: (1.0, 1e4)}, TOP)
    yield made
    made.free()


def graded(rows, columns, decades):
    """Random columns whose singular values fall by so many decades."""
    left, _ = np.linalg.qr(RNG.standard_normal((rows, columns)))
    right, _ = np.linalg.qr(RNG.standard_normal((columns, columns)))
    return left @ np.diag(np.logspace(0, -decades, columns)) @ right


@pytest.mark.parametrize("decades", [0, 5, 11, 16])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_a_span_is_orthonormal_and_leaves_out_what_it_says(model, decades, tolerance):
    norm, span = model.norm, Span(model.norm, tolerance)
    for scale in (1.0, 1e9):
        block = scale * norm.solve(graded(norm.rows, 12, decades))
        mixed = np.hstack([block, span.vectors @ RNG.standard_normal((span.size, 3))])
        coordinates, lost = span.add(mixed, norm.image(mixed))
        longest = norm.lengths(mixed).max()
        gram = span.vectors.T @ norm.image(span.vectors)
        assert np.abs(gram - np.eye(span.size)).max() < 1e-12
        assert lost <= tolerance * longest
        rest = norm.lengths(mixed - span.vectors @ coordinates)
        assert rest.max() <= lost + 1e-13 * longest
    assert span.size <= 24


def test_products_of_real_matrices_are_those_in_complex_arithmetic():
    matrix, vectors = RNG.standard_normal((5, 7)), RNG.standard_normal((7, 6)).astype(complex)
    vectors[:, [1, 4]] += 1j * RNG.standard_normal((7, 2))
    np.testing.assert_allclose(real_times(matrix, vectors), matrix @ vectors, rtol=1e-13)
    assert (real_times(matrix, vectors[:, [0, 2]]).imag == 0).all()


@pytest.mark.slow
def test_bounds_are_looked_at_a_few_times_for_each_solve_and_all_are_small(monkeypatch):
    points = grid(mu=np.linspace(0, 1, 6), P=np.geomspace(1, 1e4, 12))
    made = enrichment(blocks_pencil("iga"), {MU: (0.0, 1.0), P: (1.0, 1e4)}, TOP)
    looks, worst = [], greedy.Enrichment.worst
    monkeypatch.setattr(greedy, "_LOOKS", 4)
    monkeypatch.setattr(
        greedy.Enrichment, "worst", lambda built, point: looks.append(1) or worst(built, point)
    )
    assert made.cover(points, 5e-9) == 0.0
    assert len(made.solves) >= 3
    assert len(looks) <= len(points) + 4 * len(made.solves)
    assert max(made.at(point).worst for point in points) <= 2 * 5e-9
