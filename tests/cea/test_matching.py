"""Matching of eigenvalues and of modes: multiplicities, groups, orders, what is left alone."""

import numpy as np
import pytest
from reference_data import DRUM_BODIES

from comparisons.study.matching import match_spectrum
from scenes import run_scene
from scenes.results.matching import ModeSet, match_modes, match_runs
from scenes.spec.reading import load_scene

RNG = np.random.default_rng(7)


def matched(computed, exact, *arguments, **options):
    return match_spectrum(np.array(computed), np.array(exact), *arguments, **options)


def test_spectrum_respects_multiplicities():
    exact = [1j, 2j, 2j, 3j]
    match = matched([1.001j, 2.01j, 3.003j], exact)
    assert match.missing.tolist() == [2j]
    assert not len(match.spurious)
    assert np.isinf(match.errors).sum() == 2  # both copies: their mean is not known
    whole = matched([1.001j, 2.01j, 3.003j, 1.99j], exact)
    assert not len(whole.missing)
    assert whole.errors == pytest.approx([0.001, 0, 0, 0.001])


def test_spectrum_compares_a_coalescence_by_its_mean():
    pair = [2.001j - 0.1, 2.001j + 0.1], [2j - 1e-6, 2j + 1e-6]
    assert matched(*pair).errors == pytest.approx([0.05, 0.05], rel=1e-3)
    assert matched(*pair, tolerance=1e-3).errors == pytest.approx([0.0005, 0.0005])


def test_spectrum_reports_all_that_has_no_partner_in_the_band():
    computed = [1e-9j, 1.01j, 2.4j, 2.99j, 3.05j, 4.2j]
    match = matched(computed, [0, 1j, 2j, 3j, 4j], (0.5, 3.5), reach=0.1)
    assert match.missing.tolist() == [2j]
    assert match.spurious.tolist() == [2.4j, 3.05j]
    assert match.found[[0, 2]].tolist() == [1.01j, 2.99j]


def test_spectrum_errors_of_frequency_and_growth_apart():
    match = matched([0.11 + 1.02j, -0.2 + 4j], [0.1 + 1j, -0.2 + 4j])
    assert match.frequency_errors == pytest.approx([0.02 / abs(0.1 + 1j), 0])
    assert match.growth_errors == pytest.approx([0.01 / 0.2, 0])
    assert matched([0.01 + 2j], [2j]).growth_errors == pytest.approx([0.005])


def test_modes_that_nearly_coalesce_are_matched_as_a_group():
    """The same shape far away in frequency is not the same mode."""
    shapes = RNG.standard_normal((40, 4)) + 1j * RNG.standard_normal((40, 4))
    first = ModeSet(np.array([1j, 2j - 1e-4, 2j + 1e-4, 3j]), shapes)
    mixed = shapes[:, 1:3] @ np.array([[1.0, 1.0], [0.9j, -0.8]])
    others = np.column_stack([mixed[:, 0], shapes[:, 0], mixed[:, 1], shapes[:, 3]])
    match = match_modes(first, ModeSet(np.array([2.0001j, 1.001j, 2.0003j, 7j]), others))
    single, pair = sorted(match.groups, key=lambda g: len(g.first))
    assert (single.first.tolist(), single.second.tolist()) == ([0], [1])
    assert (pair.first.tolist(), pair.second.tolist()) == ([1, 2], [0, 2])
    assert pair.assurance == pytest.approx(1, abs=1e-8)
    assert pair.distance == pytest.approx(1e-4, rel=1e-3)
    assert match.only_first.tolist() == match.only_second.tolist() == [3]


def test_drum_modes_match_across_backends():
    drums = []
    for backend, elements in (("fe", [3, 28]), ("iga", [3, 24])):
        overrides = [f"bodies.{name}.mesh.{backend}.elements={elements}" for name in DRUM_BODIES]
        overrides.append("analysis.max_frequency=0.33")
        drums.append(run_scene(load_scene("drum", overrides, backend)))
    match = match_runs(*drums)
    assert not len(match.only_first)
    assert not len(match.only_second)
    assert all(g.assurance > 0.99 and g.distance < 5e-3 for g in match.groups)
    assert sum(len(g.first) for g in match.groups) == len(drums[0].modes.eigenvalues)
