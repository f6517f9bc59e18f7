"""What lies around a disc that was searched: it shortens the search for what is missing."""

import numpy as np
import pytest
import scipy.linalg
from mpi import on_ranks
from petsc_matrices import to_petsc
from same_numbers import assert_same
from surrounded_numbers import surrounded_numbers

from cea.eigen.block_krylov import BlockKrylov
from cea.eigen.krylov_run import KrylovRun
from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.pencil import Pencil
from cea.eigen.shifted import Shifted
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.surroundings import nothing_beside
from cea.matrices import scaled_total
from cea.timing import StageTimer

ROWS, RADIUS = 400, 40.5


def pencil_of(rubs):
    """Eigenvalues 1 to 400 in random directions; rubbing turns pairs of them."""
    whole = np.diag(np.arange(1.0, ROWS + 1))
    if rubs:
        first = np.arange(0, ROWS, 4)
        whole[first, first + 1], whole[first + 1, first] = 2.0, -2.0
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(ROWS, ROWS)))[0]
    symmetric = turn @ (0.5 * (whole + whole.T)) @ turn.T
    rest = turn @ (0.5 * (whole - whole.T)) @ turn.T if rubs else None
    return Pencil.of(
        to_petsc(0.5 * (symmetric + symmetric.T)),
        to_petsc(np.eye(ROWS)),
        None if rest is None else to_petsc(-rest),
    )


@pytest.fixture(scope="module", params=[False, True])
def searched(request):
    matrices = pencil_of(request.param).at()
    factors = Shifted(matrices, 50.3)
    krylov = BlockKrylov(matrices, factors, tolerance=1e-13, max_restarts=50, timer=StageTimer())
    nothing = InvariantSubspace.empty(ROWS, symmetric=not request.param)
    found = krylov.search(nothing, RADIUS, 0)
    whole = matrices.operator()
    return krylov, found, krylov.around, whole


def dense(matrix):
    rows, columns, values = matrix.getValuesCSR()
    return scipy.sparse.csr_array((values, columns, rows), shape=matrix.getSize()).toarray()


def test_it_is_an_invariant_subspace_that_holds_what_was_found(searched):
    _, found, around, whole = searched
    assert around.size > found.size + 8
    assert (around.basis[:, : found.size] == found.basis).all()
    gram = around.basis.T @ around.basis
    assert gram == pytest.approx(np.eye(around.size), abs=1e-11)
    defect = dense(whole) @ around.basis - around.basis @ around.projected
    assert np.abs(defect).max() < 1e-3  # kappa up to 1e2, residuals up to 1e-6
    kappa = np.linalg.eigvals(dense(whole))
    distances = np.abs(around.eigenvalues()[:, None] - kappa).min(axis=1)
    assert distances.max() < 1e-4
    inside, expected = (
        np.sort_complex(each.eigenvalues()[np.abs(each.eigenvalues() - 50.3) < RADIUS])
        for each in (around, found)
    )
    assert inside == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 6))]
)
def test_what_is_missing_is_seen(searched, seed):
    krylov, found, around, _ = searched
    assert nothing_beside(krylov, around, 50.3, RADIUS, seed)
    distances = np.abs(around.eigenvalues() - 50.3)
    inside = np.flatnonzero(distances < RADIUS)
    rim = inside[np.argmax(distances[inside])]
    for gone in (around.eigenvalues()[rim], around.eigenvalues()[inside[seed]]):

        def stays(real, imaginary=0.0, gone=gone):
            return abs(abs(complex(real, imaginary) - gone.real) - abs(gone.imag)) > 1e-6

        form, vectors, kept = scipy.linalg.schur(around.projected, output="real", sort=stays)
        rest = InvariantSubspace(
            np.asfortranarray(around.basis @ vectors[:, :kept]), form[:kept, :kept], found.symmetric
        )
        assert kept < around.size
        assert not nothing_beside(krylov, rest, 50.3, RADIUS, seed)


def test_a_mode_that_the_first_search_missed_is_found(monkeypatch):
    """It is missing in what is known around the disc too."""
    search, missed = BlockKrylov.search, []

    def poor(self, known, radius, seed, **options):
        found = search(self, known, radius, seed, **options)
        if not missed and self.around is not None:
            kappa = found.eigenvalues().real
            missed.append(np.sort(kappa)[found.size // 2])
            low, high = missed[0] - 0.25, missed[0] + 0.25
            both = [each.between(-np.inf, low) for each in (found, self.around)]
            assert high > low
            assert both[0].size < found.size
            found, self.around = both
        return found

    with KrylovSchur(pencil_of(True)) as driver:
        whole = driver.solve(np.sqrt(60.5) / (2 * np.pi))
        monkeypatch.setattr(BlockKrylov, "search", poor)
        again = driver.solve(np.sqrt(60.5) / (2 * np.pi), {"friction": 1.0})
    assert missed
    assert again.eigenvalues == pytest.approx(whole.eigenvalues, rel=1e-10)
    assert again.window.complete


@pytest.mark.mpi
@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_several_ranks_see_the_same(backend):
    ranks = {"fe": 2, "iga": 3}[backend]
    alone = surrounded_numbers(backend)
    assert alone["window"][:-1] == [True, True]
    assert_same(on_ranks(ranks, "surrounded_numbers.surrounded_numbers", backend), alone, rel=1e-8)


def test_sums_keep_a_pattern_that_holds_the_others():
    rng = np.random.default_rng(0)
    whole, part = np.diag(np.arange(1.0, 7)), np.zeros((6, 6))
    whole[rng.random((6, 6)) < 0.5] = 2.0
    part[2, 2], part[4, 4] = 3.0, -5.0
    for second in (part, part + np.eye(6, k=5), -whole):
        total = scaled_total([(2.0, to_petsc(whole)), (0.5, to_petsc(second))])
        assert dense(total) == pytest.approx(2 * whole + 0.5 * second, abs=0)
        assert total.getInfo()["nz_used"] == np.count_nonzero((whole != 0) | (second != 0))


class Blind(BlockKrylov):
    """Blocks of eight are blind to an eigenvector; wider ones, with fresh vectors, see it."""

    hidden = np.empty((0, 0))

    def apply(self, block, image):
        """OP on a block."""
        result = super().apply(block, image)
        if block.shape[1] <= 8:
            result -= self.hidden @ (self.hidden.T @ result)
        return result


@pytest.mark.parametrize(
    ("value", "rubs"),
    [
        (11, False),
        *(pytest.param(v, False, marks=pytest.mark.slow) for v in (30, 50, 87)),
        *(pytest.param(v, True, marks=pytest.mark.slow) for v in (11, 30, 50, 87)),
    ],
)
def test_fresh_vectors_of_the_last_steps_see_what_all_others_missed(value, rubs):
    """At both rims of the disc, and next to the shift."""
    matrices = pencil_of(rubs).at()
    krylov = Blind(
        matrices, Shifted(matrices, 50.3), tolerance=1e-13, max_restarts=50, timer=StageTimer()
    )
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(ROWS, ROWS)))[0]
    nothing = InvariantSubspace.empty(ROWS, symmetric=not rubs)
    krylov.hidden = turn[:, [value]]  # rubbing turns but those that leave a rest of 1 or 2
    inside = (np.abs(np.linalg.eigvals(dense(matrices.operator())) - 50.3) < RADIUS).sum()
    for seed in range(3):
        sees = krylov.search(nothing, RADIUS, seed, fresh=True)
        assert krylov.confirmed
        blind = krylov.search(nothing, RADIUS, seed)
        assert not krylov.confirmed
        found = [np.abs(each.eigenvalues() - (value + 1)).min() < 0.1 for each in (sees, blind)]
        assert found == [True, False]
        assert (np.abs(sees.eigenvalues() - 50.3) < RADIUS).sum() == inside


def test_what_was_searched_in_part_is_not_confirmed(searched):
    """Fresh vectors took part, but the search ended with the eigenvalues nearest to the shift."""
    krylov, found, _, _ = searched
    nothing = InvariantSubspace.empty(ROWS, symmetric=found.symmetric)
    run = KrylovRun(krylov, nothing, RADIUS, 0, both_ends=False, fresh=True)
    assert not run.confirmed
    assert run.complete().size >= found.size
    assert run.confirmed
    run.reached = 20.0
    assert not run.confirmed
