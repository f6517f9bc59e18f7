"""Matching of eigenvalues and of modes: multiplicities, groups, orders, what is left alone."""

import numpy as np
import pytest
from reference_data import DRUM_BODIES

from cea.eigen.matching import (
    ModeSet,
    assign,
    circumferential_content,
    group,
    match_modes,
    match_spectrum,
    modal_assurance,
    subspace_assurance,
)
from cea.errors import InputError
from scenes import run_scene
from scenes.results.matching import circumferential_orders, match_runs
from scenes.spec.reading import load_scene

RNG = np.random.default_rng(7)


def random_shapes(rows, modes):
    return RNG.standard_normal((rows, modes)) + 1j * RNG.standard_normal((rows, modes))


def test_assignment_leaves_alone_what_costs_more_than_the_limit():
    rows, columns = assign(np.array([[0.1, 5.0, 9.0], [4.0, 3.0, 8.0]]), limit=1.0)
    assert (rows.tolist(), columns.tolist()) == ([0], [0])


def test_groups_are_chains_of_neighbours():
    values = np.array([1j, 1.0005j, 2j, 1.001j, 3j + 1e-4, 3j - 1e-4])
    assert [g.tolist() for g in group(values, 6e-4)] == [[0, 1, 3], [2], [4, 5]]
    assert [g.tolist() for g in group(values, 0.0)] == [[i] for i in range(6)]
    with pytest.raises(InputError, match="tolerance"):
        group(values, -1.0)


def test_spectrum_respects_multiplicities():
    exact = np.array([1j, 2j, 2j, 3j])
    match = match_spectrum(np.array([1.001j, 2.01j, 3.003j]), exact)
    assert match.missing.tolist() == [2j]
    assert not len(match.spurious)
    assert np.isinf(match.errors).sum() == 2  # both copies: their mean is not known
    whole = match_spectrum(np.array([1.001j, 2.01j, 3.003j, 1.99j]), exact)
    assert not len(whole.missing)
    assert whole.errors == pytest.approx([0.001, 0, 0, 0.001])


def test_spectrum_compares_a_coalescence_by_its_mean():
    epsilon = 1e-6
    exact = np.array([2j - epsilon, 2j + epsilon])
    computed = np.array([2.001j - 0.1, 2.001j + 0.1])
    apart = match_spectrum(computed, exact)
    together = match_spectrum(computed, exact, tolerance=1e-3)
    assert apart.errors == pytest.approx([0.05, 0.05], rel=1e-3)
    assert together.errors == pytest.approx([0.0005, 0.0005])


def test_spectrum_reports_all_that_has_no_partner_in_the_band():
    exact = np.array([0, 1j, 2j, 3j, 4j])
    computed = np.array([1e-9j, 1.01j, 2.4j, 2.99j, 3.05j, 4.2j])
    match = match_spectrum(computed, exact, (0.5, 3.5), reach=0.1)
    assert match.missing.tolist() == [2j]
    assert match.spurious.tolist() == [2.4j, 3.05j]
    assert match.found[[0, 2]].tolist() == [1.01j, 2.99j]


def test_spectrum_errors_of_frequency_and_growth_apart():
    match = match_spectrum(np.array([0.11 + 1.02j, -0.2 + 4j]), np.array([0.1 + 1j, -0.2 + 4j]))
    size = abs(0.1 + 1j)
    assert match.frequency_errors == pytest.approx([0.02 / size, 0])
    assert match.growth_errors == pytest.approx([0.01 / 0.2, 0])
    still = match_spectrum(np.array([0.01 + 2j]), np.array([2j]))
    assert still.growth_errors == pytest.approx([0.005])


@pytest.mark.parametrize(("band", "reach"), [((2.0, 1.0), 0.1), ((0.0, 1.0), 0.0)])
def test_spectrum_refuses_wrong_input(band, reach):
    with pytest.raises(InputError):
        match_spectrum(np.array([1j]), np.array([1j]), band, reach=reach)


def test_subspace_assurance_of_a_mixed_pair():
    shapes = random_shapes(30, 3)
    mixed = shapes[:, :2] @ np.array([[0.6, 1.0], [1.5j, -0.2]])
    right = np.column_stack([mixed, shapes[:, 2]])
    part = subspace_assurance(shapes, right, [np.array([0, 1]), np.array([2])])
    assert part[:2, :2] == pytest.approx(np.ones((2, 2)))
    assert part[:, 2] == pytest.approx(modal_assurance(shapes, right)[:, 2])


def test_modes_that_nearly_coalesce_are_matched_as_a_group():
    shapes = random_shapes(40, 4)
    first = ModeSet(np.array([1j, 2j - 1e-4, 2j + 1e-4, 3j]), shapes)
    mixed = shapes[:, 1:3] @ np.array([[1.0, 1.0], [0.9j, -0.8]])
    second = ModeSet(
        np.array([2.0001j, 1.001j, 2.0003j, 7j]),
        np.column_stack([mixed[:, 0], shapes[:, 0], mixed[:, 1], shapes[:, 3]]),
    )
    match = match_modes(first, second)
    pairs = {tuple(g.first.tolist()): g for g in match.groups}
    assert pairs[0,].second.tolist() == [1]
    assert pairs[1, 2].second.tolist() == [0, 2]
    assert pairs[1, 2].assurance == pytest.approx(1, abs=1e-8)
    assert pairs[1, 2].distance == pytest.approx(1e-4, rel=1e-3)
    # The same shape far away in frequency is not the same mode.
    assert match.only_first.tolist() == match.only_second.tolist() == [3]


def travelling(content):
    """1 where all of the order of a mode is e^{+i m theta}, -1 where all is e^{-i m theta}."""
    top, modes = len(content.energy) // 2, np.arange(content.energy.shape[1])
    forward, backward = (content.energy[top + s * content.orders, modes] for s in (1, -1))
    return (forward - backward) / (forward + backward)


def test_circumferential_content_tells_order_share_and_sense():
    theta = 2 * np.pi * np.arange(16) / 16
    waves = [
        np.exp(3j * theta),
        np.exp(-3j * theta),
        np.cos(2 * theta) + 0.5 * np.cos(5 * theta),
        np.ones(16),
    ]
    u = np.stack(waves, axis=-1)[None, :, None, :] * np.array([1.0, 2j])[:, None]
    content = circumferential_content(u.reshape(1, 16, 2, 4))
    assert content.orders.tolist() == [3, 3, 2, 0]
    assert content.shares == pytest.approx([1, 1, 0.8, 1])
    assert travelling(content) == pytest.approx([1, -1, 0, 0], abs=1e-12)
    with pytest.raises(InputError, match="angles"):
        circumferential_content(u[:, :2].reshape(1, 2, 2, 4))


@pytest.fixture(scope="module")
def drums():
    """Runs of a drum on both backends."""
    meshes = {"fe": [3, 28], "iga": [3, 24]}
    return [
        run_scene(
            load_scene(
                "drum",
                [f"bodies.{body}.mesh.{backend}.elements={elements}" for body in DRUM_BODIES]
                + ["analysis.max_frequency=0.33"],
                backend,
            )
        )
        for backend, elements in meshes.items()
    ]


def test_drum_modes_have_their_exact_orders(drums):
    # One axisymmetric pair and a doublet of every order; friction sends each of the doublet's
    # members round one way.
    for result in drums:
        content = circumferential_orders(result)
        orders = content.orders.tolist()
        assert {m: orders.count(m) for m in sorted(set(orders))} == {0: 2, 1: 4, 2: 2, 3: 2}
        assert (content.shares > 0.99).all()
        growing = np.abs(result.modes.growth_rates) > 1e-3
        assert (np.abs(travelling(content)[growing]) > 0.99).all()
        assert (content.orders[~growing] == 0).all()
        # Exact eigenvalues e^{+i m theta} of these orders grow, and their mirror images decay.
        first = growing & (content.orders <= 3)
        sense = np.sign(result.modes.growth_rates[first])
        assert (np.sign(travelling(content)[first]) == sense).all()


def test_drum_modes_match_across_backends(drums):
    match = match_runs(*drums)
    assert not len(match.only_first)
    assert not len(match.only_second)
    assert all(g.assurance > 0.99 and g.distance < 5e-3 for g in match.groups)
    assert sum(len(g.first) for g in match.groups) == len(drums[0].modes.eigenvalues)
