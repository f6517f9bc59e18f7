"""References of stability: windows, dense eigenvalues, limits and other units."""

import numpy as np
import pytest

from comparisons.stability.dense import dense_eigenvalues, dense_kappas, lambdas
from comparisons.stability.scenes import in_units, layers, moved, sprag
from comparisons.stability.verdicts import window_end
from comparisons.stability.ways import WAYS, chosen
from scenes import run_modes
from scenes.spec.reading import read_scene


def test_a_window_ends_in_a_gap_and_never_cuts_copies():
    true = np.array([1j, 1j, 1j, 1.01j, 5j, 5j])
    assert 1.01 < 2 * np.pi * window_end(true, 3) < 5
    assert all(2 * np.pi * window_end(true, lowest) > 5 for lowest in (6, 100))


def test_dense_kappas_of_given_matrices():
    K = np.array([[2.0, -1.5], [1.5, 2.0]])
    assert np.allclose(np.sort_complex(dense_kappas(K, np.eye(2), [])), [2 - 1.5j, 2 + 1.5j])
    constraint = (np.array([[1.0, -1.0]]), np.array([[1.0, -1.0]]), np.zeros((1, 1)))
    assert np.allclose(dense_kappas(np.diag([1.0, 3.0]), np.eye(2), [constraint]), [2.0])
    values = lambdas(np.array([4.0, -9.0, 1 + 1j]))  # growing where kappa is negative
    assert (values.imag >= 0).all()
    assert np.allclose(values[0], 3)


def test_dense_kappas_are_right_from_the_lowest_to_the_farthest():
    """The far ones too: stiff contact may diverge where its points are lumped."""
    true = np.sort([1.9, 3.3, 7.6e3, -2.3e3, -4.2e9, -1.1e15, -4.7e15, *range(4, 34)])
    upper = np.diag(true) + np.diag(np.full(len(true) - 1, 1e-3), 1)  # unsymmetric, nothing rounded
    kappa = np.sort(dense_kappas(upper, np.eye(len(true)), []).real)
    assert kappa == pytest.approx(true, rel=1e-7)


@pytest.mark.parametrize("way", WAYS, ids=lambda way: f"{way.backend} {way.name}")
def test_dense_eigenvalues_are_those_of_the_scene(way):
    data = way.of(layers(p=10.0)) | {"analysis": {"kind": "cea", "max_frequency": 0.4}}
    found = run_modes(read_scene(data)).modes.eigenvalues
    true = dense_eigenvalues(data)
    assert np.abs(found - true[: len(found)]).max() < 1e-9 * np.abs(true[len(found)])


@pytest.mark.parametrize("way", chosen(WAYS, "GPTS, saddle", "mortar, saddle"))
def test_a_tie_is_the_limit_of_stiff_contact(way):
    stiff, tied = (dense_eigenvalues(way.of(layers(P=P)))[:8] for P in (1e11, np.inf))
    assert np.abs(stiff - tied).max() < 1e-8


def test_other_units_and_places_have_the_same_eigenvalues():
    scene = WAYS[0].of(layers())
    true = dense_eigenvalues(scene)[:8]
    for other in (in_units(scene, metre=1e3, kilogram=1e-3), moved(scene, (10.0, -3.0))):
        assert np.abs(dense_eigenvalues(other)[:8] - true).max() < 1e-9


def test_a_sprag_diverges_above_the_cotangent_of_its_angle(backend):
    (way,) = chosen(WAYS, "mortar, penalty", backend=backend)
    values = [dense_eigenvalues(way.of(sprag(60.0, mu))) for mu in (0.3, 1.5)]
    assert [np.sum((v.imag < 1e-9) & (v.real > 1e-3)) for v in values] == [0, 1]
