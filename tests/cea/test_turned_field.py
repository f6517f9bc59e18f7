"""Wedges by turned test functions: dense matrices say the same, and no eigenvalue lies outside."""

import numpy as np
import pytest
import scipy.linalg
from blocks import assemble, coarse, two_blocks
from covering import covering
from mpi import on_ranks
from petsc_matrices import to_numpy, to_petsc
from same_numbers import assert_same
from turned_numbers import turned_numbers

from cea.eigen.field_of_values import field_of_values
from cea.eigen.pencil import Pencil
from cea.eigen.turned_field import TurnedField
from scenes import load_scene, run_modes

TOP = 1.0
GPTS, MORTAR = {"method": "gpts", "points": 3}, {"method": "mortar"}
SMALL = [
    "bodies.pad.mesh.iga.elements=[3,5,1]",
    "bodies.disc.mesh.iga.elements=[4,30,1]",
    "bodies.disc.mesh.fe.elements=[3,24,1]",
    "bodies.pad.mesh.fe.elements=[3,5,1]",
]


def dense(matrices):
    """K with contact forces eliminated, and M."""
    K, M = to_numpy(matrices.operator()), to_numpy(matrices.mass)
    if (forces := matrices.multipliers) is not None:
        J, L, C = (to_numpy(m) for m in (forces.closure, forces.reaction, forces.compliance))
        K = K + L.T @ np.linalg.solve(C, J)
    return K, M


def dense_tests(tests):
    """S + N Z."""
    S, N = to_numpy(tests.turn.matrix), to_numpy(tests.turn.normals)
    Q, W = to_numpy(tests.inner), to_numpy(tests.outer)
    return S + N @ np.linalg.solve(Q, W)[: N.shape[1]]


def symmetric(matrix):
    return 0.5 * (matrix + matrix.T)


def scene(backend, formulation, P, mu, form=None):
    data = coarse(two_blocks(backend, formulation, held=True, mu=mu, P=P))
    if form is not None:
        data["contacts"]["interface"]["form"] = form
    return assemble(data).pencil().at()


CONTACTS = [
    (GPTS, 1e4, 1.5, "penalty"),
    (GPTS, 3.0, 0.4, "saddle"),
    (MORTAR, 1e9, 0.7, None),
    ({"method": "segments", "points": 3}, 1e9, 0.7, "penalty"),
]


@pytest.mark.parametrize(("backend", "contact"), covering(["iga", "fe"], CONTACTS, strength=1))
def test_the_wedge_is_that_of_dense_matrices(backend, contact):
    """X flips where the least eigenvalue of the symmetric parts is, and tau has half as much room.

    Every eigenvalue of the pencil lies in the wedge, though nothing here knew of eigenvalues.
    """
    matrices = scene(backend, *contact)
    field = TurnedField.of(matrices)
    assert field is not None
    K, M = dense(matrices)
    T = dense_tests(field.tests)
    A, B = T.T @ K, T.T @ M
    least = scipy.linalg.eigvalsh(symmetric(A), symmetric(B))[0]
    room = 1e-3 * max(abs(least), 1.0)
    assert field.holds(-least + room)
    assert not field.holds(-least - room)
    tau = scipy.linalg.eigvalsh(0.5j * (B.T - B), symmetric(B))[-1]
    assert 1.4 * tau <= field.slope <= 1.5 * tau * (1 + 1e-6)
    kappa = scipy.linalg.eigvals(K, M)
    within = kappa.real >= least - tau * np.abs(kappa.imag) - 1e-6 * np.abs(kappa)
    assert within.all()
    field.free()


@pytest.mark.parametrize("slope", [0.0, 0.1, 0.6, 2.0, 9.0])
@pytest.mark.parametrize("depth", [0.3, 2.4, 20.0, 150.0])
def test_the_depth_is_where_wedge_and_window_part(slope, depth):
    """Nothing of the parabola that lies left of -depth is in the wedge, and hardly more may be."""
    field = TurnedField(None, None, slope)
    within = field.depth_within(TOP, depth)
    real = -np.geomspace(depth, 1e4 * depth, 20_000)
    height = 2 * np.sqrt(TOP * (TOP - real))
    reaches = real + slope * height  # the largest of Re kappa + tau abs(Im kappa) at each place
    if within is None:
        deepest = -reaches.max()
        assert deepest < 0.05 * (1 + slope) * (TOP + depth)
    else:
        assert (reaches <= -within * (1 - 1e-12)).all()
        assert reaches.max() > -within - 0.05 * (1 + slope) * (TOP + depth)


@pytest.mark.parametrize(
    ("backend", "formulation", "P"), covering(["fe", "iga"], [GPTS, MORTAR], [1e8, 1e14])
)
def test_stiff_contact_moves_nothing_farther(backend, formulation, P):
    """The plain bound grows with P; this one hardly."""
    matrices = scene(backend, formulation, P, 0.7)
    field = TurnedField.of(matrices)
    assert field.bounds(TOP, 20.0)
    assert not field_of_values(matrices, 20.0).bounded
    field.free()


def test_tied_sides_with_friction_are_bounded(backend):
    """P = infinity, of which the plain bound says nothing."""
    data = coarse(two_blocks(backend, MORTAR, held=True, mu=0.7, P=float("inf")))
    matrices = assemble(data).pencil().at()
    field = TurnedField.of(matrices)
    assert field.bounds(TOP, 20.0)
    assert not field_of_values(matrices, 1e9).bounded
    field.free()


def test_without_friction_or_nodes_there_is_none():
    assert TurnedField.of(scene("fe", GPTS, 3.0, 0.0)) is None
    rng = np.random.default_rng(3)
    friction = to_petsc(rng.normal(size=(6, 6)))
    pencil = Pencil.of(to_petsc(np.eye(6)), to_petsc(np.eye(6)), friction)
    assert TurnedField.of(pencil.at()) is None


STIFF, STIFFEST = ["P=1e12"], ["P=1e16", 'formulation={method="mortar"}', "mu=1.5"]


@pytest.mark.parametrize(
    ("backend", "changes"),
    [
        ("fe", STIFF),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (("iga", STIFF), ("fe", STIFFEST), ("iga", STIFFEST))
        ),
    ],
)
def test_windows_of_stiff_contact_are_complete(backend, changes, monkeypatch):
    """As large systems are searched, with few discs: all modes of many discs, and complete."""
    overrides = SMALL + [f"contacts.pad_disc.{change}" for change in changes]
    disc_pad = load_scene("disc_pad", overrides, backend)
    many = run_modes(disc_pad).modes
    few = run_modes(disc_pad).modes
    assert few.window.complete
    assert many.window.complete
    assert few.window.discs <= 4
    assert len(few) == len(many)
    np.testing.assert_allclose(few.eigenvalues, many.eigenvalues, rtol=1e-6, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [["P=1e12"], ["P=1e13"], ["P=1e16", 'formulation={method="mortar"}']]
)
def test_large_windows_of_stiff_contact_are_complete(backend, changes):
    """The meshes of the scene itself, with as few discs as large systems get."""
    overrides = [f"contacts.pad_disc.{change}" for change in changes]
    modes = run_modes(load_scene("disc_pad", overrides, backend)).modes
    assert modes.window.complete
    assert modes.window.discs <= 3


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("backend", "ranks"),
    [
        ("iga", 2),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (("fe", 2), ("fe", 3), ("iga", 3))
        ),
    ],
)
def test_ranks_agree(backend, ranks):
    found = on_ranks(ranks, "turned_numbers.turned_numbers", backend)
    assert_same(found, turned_numbers(backend), rel=1e-6)
