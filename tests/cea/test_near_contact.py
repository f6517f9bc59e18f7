"""Bounds by what lies near the contacts hold for the whole, and give the same modes."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from blocks import assemble
from covering import covering
from mpi import on_ranks
from near_contact_cases import near_numbers, on_a_bar
from petsc_matrices import to_numpy
from same_numbers import assert_same

from cea.eigen import window
from cea.eigen.driver import EigenSolver
from cea.eigen.field_of_values import field_of_values
from cea.eigen.krylov_schur import KrylovOptions
from cea.errors import InputError
from cea.rotation import Rotation
from cea.system import near_contact
from cea.system.body_terms import Motion

PARAMETERS = {
    "bodies.lower.material.E": 5.0,
    "bodies.upper.material.rho": 0.3,
    "contacts.interface.mu": 0.8,
}
CONTACTS = [
    ({"method": "gpts", "points": 3}, "penalty"),
    ({"method": "gpts", "points": 3}, "saddle"),
    ({"method": "mortar"}, None),
    ({"method": "gpts", "points": 3, "lumped": True}, None),
]


@pytest.fixture
def kept(monkeypatch):
    """Unknowns of what lies near, as it is told apart."""
    found, original = [], near_contact._kept

    def noted(*arguments):
        chosen = original(*arguments)
        found.append(None if chosen is None else chosen.array.copy())
        return chosen

    monkeypatch.setattr(near_contact, "_kept", noted)
    return found


def dense(matrices):
    """H, N and M, contact forces eliminated."""
    K, M = to_numpy(matrices.operator()), to_numpy(matrices.mass)
    if (forces := matrices.multipliers) is not None:
        J, L, C = (to_numpy(m) for m in (forces.closure, forces.reaction, forces.compliance))
        K = K + L.T @ np.linalg.solve(C, J)
    return 0.5 * (K + K.T), 0.5 * (K - K.T), M


@pytest.mark.parametrize(
    ("contact", "upper", "turned"), covering(CONTACTS, ["iga", "fe"], [False, True])
)
def test_what_is_left_out_is_positive_semidefinite(kept, contact, upper, turned):
    """All of friction is near, and K and M of the rest have no negative eigenvalue."""
    method, form = contact
    data = on_a_bar(upper, method, form=form, turned=turned)
    pencil = assemble(data).pencil(parted_from=0)
    near = pencil.near_contact
    for changes in ({}, PARAMETERS):
        H, N, M = dense(pencil.at(changes))
        parts = [np.zeros_like(H) for _ in range(3)]
        for whole, part in zip(parts, dense(near.at(changes)), strict=True):
            whole[np.ix_(kept[0], kept[0])] = part
        assert len(kept[0]) < 0.5 * len(H)
        assert np.abs(N).max() > 0
        assert np.abs(parts[1] - N).max() <= 1e-12 * np.abs(H).max()
        for every, part in ((H, parts[0]), (M, parts[2])):
            left = np.linalg.eigvalsh(every - part)
            assert left[0] > -1e-12 * left[-1]
            assert left[len(kept[0]) + 1] > 1e-6 * left[-1]


@pytest.mark.parametrize(("contact", "mu"), covering(CONTACTS, [1e-3, 0.4, 2.0], strength=1))
def test_its_bounds_hold_for_the_whole(kept, contact, mu):
    method, form = contact
    pencil = assemble(on_a_bar(method=method, form=form, mu=mu)).pencil(parted_from=0)
    H, N, M = dense(pencil.at())
    depth = 1.0 + max(0.0, -3 * scipy.linalg.eigvalsh(H, M)[0])
    field = field_of_values(pencil.near_contact.at(), depth, cone=True)
    own = field_of_values(pencil.at(), depth, cone=True)
    assert field.bounded
    assert own.slope * (1 - 1e-2) <= field.slope < np.inf
    steepest = scipy.linalg.eigvalsh(1j * N, H + depth * M)[-1]
    assert steepest <= field.slope


def test_where_it_says_too_little_the_whole_is_asked(kept, monkeypatch):
    """Friction so strong that the part has no bound, though the whole has one."""
    pencil = assemble(on_a_bar(mu=8.0)).pencil(parted_from=0)
    sizes, original = [], window.field_of_values

    def noted(matrices, *arguments, **options):
        sizes.append(matrices.size)
        return original(matrices, *arguments, **options)

    monkeypatch.setattr(window, "field_of_values", noted)
    with EigenSolver(pencil, KrylovOptions(dense_limit=0)) as driver:
        modes = driver.solve(0.3)
    assert sizes[0] == len(kept[0])
    assert sizes[1] == pencil.at().size
    assert modes.window.complete


def test_where_nothing_is_told_apart():
    """Small systems, NURBS alone, contact everywhere, and stiffness that is not of elasticity."""
    nurbs = assemble(on_a_bar("iga", lower="iga"))
    assert nurbs.pencil(parted_from=0).near_contact is None
    everywhere = on_a_bar()
    everywhere["bodies"]["lower"]["geometry"]["size"] = [1.0, 1.1, 0.4]
    everywhere["bodies"]["lower"]["mesh"]["fe"]["elements"] = [3, 3, 1]
    assert assemble(everywhere).pencil(parted_from=0).near_contact is None
    motion = Motion(rotation=Rotation(1.0, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)))
    system = assemble(on_a_bar())
    turning = replace(system, pieces=replace(system.pieces, motions={"lower": motion}))
    assert turning.pencil(parted_from=0).near_contact is None
    assert assemble(on_a_bar()).pencil().near_contact is None


def test_a_nurbs_body_has_no_parts():
    body = assemble(on_a_bar("iga")).bodies["upper"]
    assert body.node_positions is None
    with pytest.raises(InputError, match="finite elements"):
        body.part(np.ones(body.num_scalar_dofs, dtype=bool))


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_several_ranks_see_the_same(ranks):
    alone = near_numbers()
    assert alone["complete"] == [True, True]
    assert_same(on_ranks(ranks, "near_contact_cases.near_numbers"), alone, rel=1e-8)
