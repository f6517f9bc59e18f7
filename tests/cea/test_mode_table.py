"""Words of modes and runs, row by row of their definition; tables of modes."""

from math import inf

import numpy as np
import pytest
from blocks import two_blocks

from cea.eigen.classify import cannot_grow, classify, classify_run
from cea.eigen.spectrum import Spectrum, Window
from cea.mode_table import shown_cells
from scenes import read_scene, run_modes


@pytest.mark.parametrize(
    ("growth", "error", "threshold", "bounded", "rigid", "word"),
    [
        (2.0, 0.5, 1.0, False, False, "unstable"),
        (1.1, 1.05, 1.0, False, False, "unstable"),  # above both, though not by their sum
        (1.0, 0.5, 1.0, False, False, "grows slowly"),  # at the threshold
        (2.0, 3.0, 1.0, False, False, "undecided"),
        (0.5, 0.5, 1.0, False, False, "undecided"),
        (-0.5, 0.5, 1.0, False, False, "stable"),
        (-0.4, 0.5, 1.0, False, False, "undecided"),
        (0.0, 0.5, 1.0, True, False, "stable"),
        (5.0, np.inf, 1.0, False, False, "undecided"),
        (1e-9, 1e-8, 0.0, False, True, "rigid"),
    ],
)
def test_word_of_a_mode(growth, error, threshold, bounded, rigid, word):
    assert classify([growth], [error], [threshold], [bounded], [rigid]) == [word]


@pytest.mark.parametrize(
    ("kappa", "error", "symmetric", "free"),
    [
        ([1.0, 2.0, 2.1, 5.0, -1.0, 0.01, 3 + 1j, 3 - 1j], 0.1, False, [0, 3]),  # real and apart
        ([2.0, 2.0 + 1e-13j, 2.0 - 1e-13j], 3e-13, False, [0, 1, 2]),  # multiple
        ([3.0, 3.0], 1e-8, False, []),  # may be a coalescence
        ([1.0, 1.0, -1.0, 0.01], 0.1, True, [0, 1]),  # which there is none of without friction
    ],
)
def test_kappa_that_cannot_grow(kappa, error, symmetric, free):
    errors = np.full(len(kappa), error)
    found = cannot_grow(np.array(kappa), errors, symmetric=symmetric)
    assert np.flatnonzero(found).tolist() == free


@pytest.mark.parametrize(
    ("words", "complete", "missing", "word"),
    [
        (["stable", "unstable", "undecided", "grows slowly"], True, False, "unstable"),
        (["stable", "undecided", "grows slowly"], False, False, "grows slowly"),
        (["stable", "undecided"], True, False, "undecided"),
        (["stable", "rigid"], True, False, "stable"),
        (["stable", "rigid"], False, False, "no unstable mode found"),
        (["stable"], False, True, "undecided"),
        ([], True, False, "no modes"),
    ],
)
def test_word_of_a_run(words, complete, missing, word):
    assert classify_run(words, complete=complete, missing=missing) == word


WINDOW = Window(100.0, 1e5, inf, 5, 1, inf, True, False, 4e5, 5, None)


def spectrum(values, uncertainties):
    n = len(values)
    return Spectrum(np.array(values), np.zeros(n), np.ones(n), np.array(uncertainties), WINDOW)


def test_damping_ratios_are_those_of_an_oscillator():
    """X'' + 2 zeta omega x' + omega^2 x = 0, of both signs, and beyond critical damping."""
    zetas, omega = np.array([0.05, -0.05, 1e-5]), 200.0
    values = omega * (-zetas + 1j * np.sqrt(1 - zetas**2))
    modes = spectrum([*values, -30.0 + 0j], np.full(4, 1e-9))
    np.testing.assert_allclose(modes.damping_ratios, [*zetas, 1.0], rtol=1e-12)
    assert [row["damping_ratio"] for row in modes.table()] == modes.damping_ratios.tolist()
    assert modes.verdicts() == ["stable", "unstable", "stable", "stable"]


def test_what_nothing_holds_is_rigid_and_has_no_damping_ratio():
    modes = spectrum([0j, 1e-6 + 0j, 1e-3 + 0j, 50j, 60j], [1e-9, 2e-6, 1e-6, 1e-6, 70.0])
    assert modes.rigid.tolist() == [True, True, False, False, False]
    assert np.isnan(modes.damping_ratios[:2]).all()
    assert np.isnan(modes.table().column("damping_ratio")[:2]).all()
    assert modes.verdicts() == ["rigid", "rigid", "unstable", "undecided", "undecided"]


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_two_free_blocks_in_contact_have_nine_rigid_motions(backend, mu):
    """Twelve rigid motions, of which the contact holds one displacement and two tilts."""
    data = two_blocks(backend, {"method": "gpts", "points": 3}, mu=mu)
    data["analysis"]["max_frequency"] = 0.4
    result = run_modes(read_scene(data))
    assert np.flatnonzero(result.modes.rigid).tolist() == list(range(9))
    assert "9 rigid" in result.summary
    cells = shown_cells(result.table())
    assert {cell["verdict"] for cell in cells[:9]} == {"rigid"}
    assert {cell["damping_ratio"] for cell in cells[:9]} == {"-"}
    assert cells[9]["verdict"] == "stable"
