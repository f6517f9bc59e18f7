"""Bases of reduced models: what they span, at which products, and what is found on smaller ones."""

import numpy as np
import pytest
from reduced_cases import MU, P, blocks_pencil

from cea.eigen.driver import EigenSolver
from cea.reduced.basis import Span
from cea.reduced.greedy import full_solve
from cea.reduced.model import ReducedModel

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
    norm = model.norms.states
    span = Span(norm)
    for scale in (1.0, 1e9):
        block = scale * model.norms.solve(graded(norm.rows, 12, decades))
        mixed = np.hstack([block, span.vectors @ RNG.standard_normal((span.size, 3))])
        longest = norm.lengths(mixed).max()
        coordinates, lost = span.add(mixed, norm.image(mixed), tolerance * longest)
        gram = span.vectors.T @ norm.image(span.vectors)
        assert np.abs(gram - np.eye(span.size)).max() < 1e-12
        assert lost <= tolerance * longest
        rest = norm.lengths(mixed - span.vectors @ coordinates)
        assert rest.max() <= lost + 1e-13 * longest
    assert span.size <= 24


@pytest.mark.parametrize("relative", [1e-2, 1e2])
def test_forces_add_displacements_where_a_contact_is_stiffer_than_its_bodies(relative):
    pencil = blocks_pencil("fe", form="saddle")
    (contact,) = pencil.forces
    stiff = relative * contact.body_stiffness[0]
    made = ReducedModel(pencil, {MU: (0.0, 1.0), P: (0.1 * stiff, stiff)}, TOP)
    solved = full_solve(made, EigenSolver(pencil), {MU: 0.5, P: stiff})
    made.take(solved)
    vectors = solved.real_vectors(made.norms.states, damped=False).shape[1]
    forces = made.size - made.small.displacements
    assert made.small.displacements <= vectors + (forces if relative > 1 else 0)
    made.free()
