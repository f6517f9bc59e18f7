"""Wedges by corrected test functions: dense matrices say the same, no eigenvalue lies outside."""

from itertools import product

import numpy as np
import pytest
import scipy.linalg
from blocks import assemble, coarse, two_blocks
from eigen_numbers import wedges
from mpi import on_ranks
from petsc_matrices import dense_pencil, to_numpy, to_petsc
from same_numbers import assert_same

from cea.eigen.corrected_tests import CorrectedTests
from cea.eigen.field_of_values import field_of_values
from cea.eigen.pencil import Pencil
from scenes import load_scene, run_modes

TOP = 1.0
SLOW = pytest.mark.slow
GPTS, MORTAR = {"method": "gpts", "points": 3}, {"method": "mortar"}


def scene(backend, formulation, P, mu, form=None):
    data = coarse(two_blocks(backend, formulation, held=True, mu=mu, P=P, form=form))
    return assemble(data).pencil().at()


@pytest.mark.grid
@pytest.mark.parametrize(
    "contact",
    [
        (GPTS, 1e4, 1.5, "penalty"),
        (GPTS, 3.0, 0.4, "saddle"),
        (MORTAR, 1e9, 0.7, None),
        ({"method": "segments", "points": 3}, 1e9, 0.7, "penalty"),
    ],
    ids=str,
)
def test_the_wedge_is_that_of_dense_matrices(backend, contact):
    """X flips where the least eigenvalue of the symmetric parts is, and tau has half as much room.

    Every eigenvalue of the pencil lies in the wedge, though nothing here knew of eigenvalues.
    """
    matrices = scene(backend, *contact)
    tests = CorrectedTests.of(matrices)
    assert tests is not None
    M, _, K = dense_pencil(matrices)
    N, Q, W = (to_numpy(each) for each in (tests.normals, tests.inner, tests.outer))
    T = np.eye(len(M)) + N @ np.linalg.solve(Q, W)[: N.shape[1]]
    A, B = T.T @ K, T.T @ M
    least = scipy.linalg.eigvalsh(0.5 * (A + A.T), 0.5 * (B + B.T))[0]
    room = 1e-3 * max(abs(least), 1.0)
    assert tests.holds(-least + room)
    assert not tests.holds(-least - room)
    tau = scipy.linalg.eigvalsh(0.5j * (B.T - B), 0.5 * (B + B.T))[-1]
    assert 1.4 * tau <= tests.slope <= 1.5 * tau * (1 + 1e-6)
    kappa = scipy.linalg.eigvals(K, M)
    assert (kappa.real >= least - tau * np.abs(kappa.imag) - 1e-6 * np.abs(kappa)).all()
    tests.free()


@pytest.mark.parametrize("slope", [0.0, 0.6, 9.0])
@pytest.mark.parametrize("depth", [0.3, 20.0])
def test_the_depth_is_where_wedge_and_window_part(slope, depth):
    """Nothing of the parabola that lies left of -depth is in the wedge, and hardly more may be."""
    within = CorrectedTests(*[None] * 4, slope).depth_within(TOP, depth)
    real = -np.geomspace(depth, 1e4 * depth, 20_000)
    height = 2 * np.sqrt(TOP * (TOP - real))
    # The largest of Re kappa + tau abs(Im kappa), and as much room as may be given away.
    reaches, room = (real + slope * height).max(), 0.05 * (1 + slope) * (TOP + depth)
    if within is None:
        assert -reaches < room
    else:
        assert reaches <= -within * (1 - 1e-12)
        assert reaches > -within - room


@pytest.mark.grid
@pytest.mark.parametrize(
    ("formulation", "P"), [*product([GPTS, MORTAR], [1e8, 1e14]), (MORTAR, np.inf)]
)
def test_stiff_contact_moves_nothing_farther(backend, formulation, P):
    """The plain bound grows with P, and says nothing of P = infinity; this one hardly does."""
    matrices = scene(backend, formulation, P, 0.7, "saddle" if np.isinf(P) else None)
    tests = CorrectedTests.of(matrices)
    assert tests.bounds(TOP, 20.0)
    assert field_of_values(matrices, 20.0) is None
    tests.free()


def test_without_friction_or_nodes_there_is_none():
    assert CorrectedTests.of(scene("fe", GPTS, 3.0, 0.0)) is None
    friction = np.random.default_rng(3).normal(size=(6, 6))
    pencil = Pencil.of(*map(to_petsc, (np.eye(6), np.eye(6), friction)))
    assert CorrectedTests.of(pencil.at()) is None


SMALL = {"pad": {"iga": [3, 5, 1], "fe": [3, 5, 1]}, "disc": {"iga": [4, 30, 1], "fe": [3, 24, 1]}}
STIFFEST = ["P=1e16", 'formulation={method="mortar"}', "mu=1.5"]
UP_TO_A_GROWTH = pytest.mark.xfail(strict=True, reason="complete up to a growth that is told")


@pytest.mark.parametrize(
    ("backend", "changes"),
    [
        ("fe", ["P=1e12"]),
        pytest.param("iga", ["P=1e12"], marks=SLOW),
        pytest.param("fe", STIFFEST, marks=SLOW),
        pytest.param("iga", STIFFEST, marks=[SLOW, UP_TO_A_GROWTH]),
    ],
)
def test_windows_of_stiff_contact_are_complete(backend, changes):
    overrides = [f"bodies.{b}.mesh.{backend}.elements={n[backend]}" for b, n in SMALL.items()]
    overrides += [f"contacts.pad_disc.{change}" for change in changes]
    modes = run_modes(load_scene("disc_pad", overrides, backend)).modes
    assert modes.window.complete
    assert modes.window.discs <= 4


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("backend", "ranks"),
    [("iga", 2), *(pytest.param("fe", ranks, marks=SLOW) for ranks in (2, 3))],
)
def test_ranks_agree(backend, ranks):
    found = on_ranks(ranks, "eigen_numbers.wedges", backend)
    assert_same(found, wedges(backend), rel=1e-6)
