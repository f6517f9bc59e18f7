"""Bases of reduced models: what they span, at which products, and what is found on smaller ones."""

from dataclasses import replace

import numpy as np
import pytest
from reduced_cases import MU, P, blocks_pencil, enrichment, grid, model_line

from cea.reduced import greedy
from cea.reduced.model import ReducedModel
from cea.reduced.products import real_times
from cea.reduced.rows import along
from cea.reduced.small import SmallPencil
from cea.reduced.span import Span
from cea.reduced.thresholds import thresholds_along

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


@pytest.fixture(scope="module")
def built():
    pencil = blocks_pencil("iga")
    made = enrichment(pencil, {MU: (0.0, 1.0), P: (1.0, 1e8)}, TOP)
    assert made.cover(grid(mu=[0.0, 0.5, 1.0], P=np.geomspace(1, 1e8, 9))) <= made.tolerance
    return made


@pytest.mark.slow
def test_a_row_keeps_its_tolerance_at_values_that_were_not_looked_at_first(built):
    small, pencil = built.model.small, built.model.pencil
    line = [pencil.values({MU: mu, P: 300.0}) for mu in np.linspace(0, 1, 61)]
    spectra = along(small, line, 1e-8, least=10).spectra
    whole = [small.at(values) for values in line]
    for found, other in zip(spectra, whole, strict=True):
        assert found.worst <= max(1e-8, other.worst)
        assert len(found.window) == len(other.window)


def test_a_row_that_no_local_basis_holds_is_solved_on_the_whole_one(built):
    small, pencil = built.model.small, built.model.pencil
    points = [
        pencil.values({MU: mu, P: p}) for p in np.geomspace(1, 1e4, 4) for mu in (0.1, 0.5, 0.9)
    ]
    line = along(small, points, 1e-14, least=10)
    assert line.basis is small
    for values, found in zip(points, line.spectra, strict=True):
        np.testing.assert_array_equal(found.kappa, small.at(values).kappa)


@pytest.fixture
def sizes(monkeypatch):
    """Sizes of the bases on which spectra were made."""
    made, at = [], SmallPencil.at

    def counted(small, values):
        made.append(small.size)
        return at(small, values)

    monkeypatch.setattr(SmallPencil, "at", counted)
    return made


@pytest.mark.parametrize("p", [*(pytest.param(p, marks=pytest.mark.slow) for p in (1.0, 1e4)), 1e8])
def test_a_row_rests_on_few_values_of_the_whole_basis_however_stiff(built, sizes, p):
    """What a local basis leaves out is small in the energy norm there, not in that of soft ones."""
    small, pencil = built.model.small, built.model.pencil
    row = [pencil.values({MU: mu, P: p}) for mu in np.linspace(0, 1, 41)]
    # The stiffest contact leaves rounding of 1e-7, more or less, to the whole basis too.
    tolerance = max(1e-7, 2 * max(small.at(values).worst for values in row))
    assert tolerance < 1e-6
    sizes.clear()
    line = along(small, row, tolerance)
    assert small.size > 1.5 * line.basis.size
    assert max(found.worst for found in line.spectra) <= tolerance
    assert sizes.count(small.size) <= 8
    assert not line.whole


def test_thresholds_on_a_smaller_basis_are_those_on_the_whole_one(built, sizes):
    small, pencil, values = built.model.small, built.model.pencil, np.linspace(0, 1, 11).tolist()
    points = [pencil.values({MU: mu, P: 30.0}) for mu in values]
    part = along(small, points, 1e-9, least=10)
    whole = model_line(built, MU, {P: 30.0})
    assert part.basis.size < small.size
    sizes.clear()
    found = thresholds_along(replace(whole, bases=[(0.0, 1.0, part.basis)]), values)
    assert sizes.count(small.size) < found.spectra / 2
    slow = thresholds_along(whole, values)
    assert found.thresholds
    for mine, theirs in zip(found.thresholds, slow.thresholds, strict=True):
        assert abs(mine.value - theirs.value) <= mine.error + theirs.error
        assert mine.slope == pytest.approx(theirs.slope, rel=1e-3)
        assert (mine.change, mine.kind) == (theirs.change, theirs.kind)


@pytest.mark.slow
def test_bounds_are_looked_at_a_few_times_for_each_solve_and_all_are_small(monkeypatch):
    points = grid(mu=np.linspace(0, 1, 6), P=np.geomspace(1, 1e4, 12))
    made = enrichment(blocks_pencil("iga"), {MU: (0.0, 1.0), P: (1.0, 1e4)}, TOP)
    looks, worst = [], greedy.Enrichment._worst
    monkeypatch.setattr(greedy, "_LOOKS", 4)
    monkeypatch.setattr(
        greedy.Enrichment, "_worst", lambda built, point: looks.append(1) or worst(built, point)
    )
    assert made.cover(points, 5e-9) == 0.0
    assert len(made.snapshots) >= 3
    assert len(looks) <= len(points) + 4 * len(made.snapshots)
    assert max(made.at(point).worst for point in points) <= 2 * 5e-9
