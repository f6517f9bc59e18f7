"""Windows in slices: what several shifts find together is what one finds."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg
from blocks import assemble, two_blocks
from mpi import on_ranks
from petsc_matrices import to_petsc
from same_numbers import assert_same
from sliced_numbers import FEW, sliced_numbers

from cea.eigen import disc_searches
from cea.eigen.found import Disc
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.slices import Slice, covered, plan_of
from cea.eigen.subspace import InvariantSubspace

HERTZ = 1 / (2 * np.pi)


def line(values, symmetric=True):
    """The invariant subspace of a diagonal matrix."""
    return InvariantSubspace(np.eye(len(values)), np.diag(values), symmetric)


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("part", [1.0, 0.6])
def test_slices_cover_an_interval(power, part):
    """Whatever the density, and where less is found than was asked for."""
    every = 100.0 * np.linspace(0, 1, 900) ** power

    def found(shift, radius):
        radius *= part
        return Slice(Disc(shift, radius), line(every[np.abs(every - shift) <= radius]))

    first = found(62.0, 8.0 / part)
    slices = covered(first, -1.0, 101.0, found)
    centres = [each.disc.centre for each in slices]
    assert centres == sorted(centres)
    assert slices[0].low <= -1.0
    assert slices[-1].high >= 101.0
    assert all(left.high >= right.low for left, right in pairwise(slices))
    counts = [each.found.size for each in slices]
    assert 3 < len(counts) < 60
    assert max(counts) < 3 * first.found.size


def test_a_search_of_few_eigenvalues_is_never_parted():
    assert np.isinf(plan_of(4_000, 1e6, 3e8).many)
    assert np.isfinite(plan_of(40_000, 2e7, 7e11).many)


def test_a_part_holds_the_eigenvalues_between_two_ends():
    rng = np.random.default_rng(4)
    blocks = [[[1.0]], [[2.0, 3.0], [-3.0, 2.0]], [[4.0]], [[5.0, 0.5], [-0.5, 5.0]]]
    turn = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    matrix = turn @ (scipy.linalg.block_diag(*blocks) + np.triu(np.ones((6, 6)), 2)) @ turn.T
    part = InvariantSubspace(np.eye(6), matrix, symmetric=False).between(1.5, 4.5)
    assert np.abs(matrix @ part.basis - part.basis @ part.projected).max() < 1e-13
    expected = np.sort_complex([2 + 3j, 2 - 3j, 4])
    assert np.sort_complex(part.eigenvalues()) == pytest.approx(expected)


def test_copies_are_all_found(monkeypatch):
    """Eigenvalues with copies, pairs near the axis and one far from it, in a random basis."""
    monkeypatch.setattr(disc_searches, "plan_of", lambda *_: FEW)
    values = [*np.linspace(0.01, 0.99, 120), *np.repeat(np.linspace(0.05, 0.95, 7), 5)]
    far = np.linspace(1.3, 900.0, 240)
    pairs = [np.array([[x, y], [-y, x]]) for x, y in ((0.3, 0.01), (0.31, 0.4), (0.72, 0.02))]
    whole = scipy.linalg.block_diag(np.diag([*values, *far]), *pairs)
    n = len(whole)
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(n, n)))[0]
    S, N = 0.5 * (whole + whole.T), 0.5 * (whole - whole.T)
    S, N = (turn @ part @ turn.T for part in (S, N))
    pencil = Pencil.of(to_petsc(0.5 * (S + S.T)), to_petsc(np.eye(n)), to_petsc(-N))
    modes = solve_modes(pencil, HERTZ)
    assert modes.window.slices > 2
    assert f"found from {modes.window.slices} shifts" in modes.window.evidence
    assert modes.window.complete
    lam = np.sqrt(-np.concatenate([values, [0.3 + 0.01j, 0.31 + 0.4j, 0.72 + 0.02j]]) + 0j)
    lam = np.concatenate([lam, -lam[-3:].conj()])
    lam = np.where(lam.imag < 0, -lam, lam)
    expected = lam[np.lexsort((lam.real.round(8), lam.imag.round(8)))]
    found = modes.eigenvalues
    found = found[np.lexsort((found.real.round(8), found.imag.round(8)))]
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert modes.residuals.max() < 1e-9


@pytest.mark.parametrize("mu", [0.0, pytest.param(0.4, marks=pytest.mark.slow)])
def test_modes_are_those_of_one_search(backend, mu, monkeypatch):
    """With left vectors; and inertia counts them where nothing rubs."""
    end = 1.4
    pencil = assemble(two_blocks(backend, {"method": "gpts", "points": 3}, mu=mu)).pencil()
    whole = solve_modes(pencil, end, left=True)
    monkeypatch.setattr(disc_searches, "plan_of", lambda *_: FEW)
    sliced = solve_modes(pencil, end, left=True)
    assert whole.window.slices == 0
    assert sliced.window.slices > 1
    assert sliced.window.complete == whole.window.complete
    assert len(sliced) == len(whole) > 40
    moving = ~whole.rigid
    np.testing.assert_allclose(sliced.frequencies[moving], whole.frequencies[moving], rtol=1e-8)
    assert sliced.residuals[moving].max() < 100 * whole.residuals[moving].max()
    (name,) = (each for each in pencil.parameters if each.endswith(".P"))
    simple = moving & (whole.conditions < 10)
    slopes = [np.sort_complex(m.sensitivity(name)[simple]) for m in (sliced, whole)]
    np.testing.assert_allclose(slopes[0], slopes[1], atol=1e-6 * np.abs(slopes[1]).max())


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("backend", "ranks"),
    [
        ("iga", 2),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in (("fe", 2), ("iga", 3))),
    ],
)
def test_slices_on_several_ranks(backend, ranks):
    alone = sliced_numbers(backend)
    assert alone["window"][:2] == [True, True]
    assert_same(on_ranks(ranks, "sliced_numbers.sliced_numbers", backend), alone, rel=1e-8)
