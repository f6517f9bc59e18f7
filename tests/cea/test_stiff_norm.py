"""Norms of residuals where a contact is stiffer than in the energy norm of a map."""

import numpy as np
import pytest
from reduced_cases import MU, P, blocks_pencil, enrichment, errors_of_means, grid

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.reduced.greedy import largest_ratio
from cea.reduced.rows import in_parts
from cea.reduced.spectrum import MARGIN

TOP = 0.6
RNG = np.random.default_rng(5)


@pytest.fixture(scope="module", params=[pytest.param("fe", marks=pytest.mark.slow), "iga"])
def built(request):
    made = enrichment(blocks_pencil(request.param), {MU: (0.0, 1.0), P: (1.0, 1e8)}, TOP)
    made.cover(grid(mu=[0.0, 0.5, 1.0], P=np.geomspace(1, 1e8, 9)))
    return made


def stiff_piece(model):
    """The piece of the contact, in full and on the basis."""
    pairs = zip(model._pieces.all, model.small.pieces, strict=True)
    return next((piece, small) for piece, small in pairs if small.stiff)


@pytest.mark.parametrize("p", [1e2, 1e5, 1e8])
def test_it_is_between_the_norm_there_and_that_of_the_map(built, p):
    """Dense inverses are the judge; forces of the contact on the basis are measured as they are."""
    model = built.model
    piece, small = stiff_piece(model)
    values = model.pencil.values({MU: 0.3, P: p})
    norm = model.small.where(model.small.stiffness(values)).norm
    rows = model.norm.rows
    X, A = model.norm.image(np.eye(rows)), piece.times(np.eye(rows))
    stiffer = X + (piece.coefficient.at(values) - small.least) * A
    q, v = model._residuals.vectors, model._basis.vectors

    def in_full(coordinates):
        forces = X @ q @ coordinates
        return np.sqrt(np.einsum("ij,ij->j", forces, np.linalg.solve(stiffer, forces)))

    weights = RNG.standard_normal((model.size, 4))
    for residuals in (RNG.standard_normal((len(q.T), 4)), small.right @ weights):
        measured = np.linalg.norm(norm(residuals), axis=0)
        assert (measured >= in_full(residuals) * (1 - 1e-8)).all()
        assert (measured <= np.linalg.norm(residuals, axis=0) * (1 + 1e-12)).all()
        np.testing.assert_allclose(norm.real(residuals), norm(residuals).real, atol=1e-12)
    assert np.abs(v.T @ A @ v - small.square).max() < 1e-10 * np.abs(small.square).max()
    forces = small.right @ weights
    bent = np.linalg.norm(norm(forces), axis=0)
    assert (bent < 0.5 * np.linalg.norm(forces, axis=0)).all()


def test_bounds_are_smaller_where_a_contact_is_stiff_and_full_solves_keep_them(built):
    model, full = built.model, EigenSolver(built.model.pencil)
    for p in (1e5, 1e8):
        point = {MU: 0.37, P: p}
        values = model.pencil.values(point)
        found, soft = built.at(point), model.small.at(values)
        np.testing.assert_array_equal(found.kappa, soft.kappa)
        assert found.worst <= soft.worst
        modes = full.solve(MARGIN * TOP, point)
        assert largest_ratio(found, modes) <= 1
        assert errors_of_means(found, -(modes.eigenvalues**2)).max() < 1e-8


def means_beside_bounds(found, whole):
    """Largest distance of means of clusters relative to what both are bounded by, with rounding."""
    rows, columns = assign(np.abs(found.kappa[:, None] - whole.kappa))
    clusters, means = found.certificate.clusters[rows], found.certificate.means[rows]
    bounds, apart = means + whole.certificate.means[columns], found.kappa[rows]
    apart = apart - whole.kappa[columns]
    members = [clusters == each for each in np.unique(clusters)]
    return max(abs(apart[each].mean()) / bounds[each].max() for each in members)


@pytest.mark.parametrize("p", [*(pytest.param(p, marks=pytest.mark.slow) for p in (1.0, 1e4)), 1e8])
def test_parts_of_a_line_are_those_of_the_whole_basis(built, p):
    small, pencil = built.model.small, built.model.pencil
    line = [pencil.values({MU: mu, P: p}) for mu in np.linspace(0, 1, 61)]
    small = small.where(small.stiffness(line[0]))
    parts = in_parts(small, line, 1e-7)
    spectra = [*parts[0].spectra[:1], *(each for part in parts for each in part.spectra[1:])]
    assert len(spectra) == len(line)
    for values, found in zip(line, spectra, strict=True):
        whole = small.at(values)
        assert found.worst <= max(1e-7, whole.worst)
        assert len(found.window) == len(whole.window)
        assert means_beside_bounds(found.window, whole) <= 1.0
