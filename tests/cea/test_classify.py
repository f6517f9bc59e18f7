"""The words of modes and runs, row by row of their definition."""

import numpy as np
import pytest

from cea.eigen.classify import cannot_grow, classify, classify_run, counted_words


@pytest.mark.parametrize(
    ("growth", "error", "threshold", "bounded", "rigid", "word"),
    [
        (2.0, 0.5, 1.0, False, False, "unstable"),
        (1.1, 1.05, 1.0, False, False, "unstable"),  # above both, though not by their sum
        (1.0, 0.5, 1.0, False, False, "grows slowly"),  # at the threshold
        (1.17, 2e-7, 5.0, False, False, "grows slowly"),
        (2.0, 3.0, 1.0, False, False, "undecided"),
        (0.5, 0.5, 1.0, False, False, "undecided"),
        (-1.0, 0.5, 1.0, False, False, "stable"),
        (-0.5, 0.5, 1.0, False, False, "stable"),
        (-0.4, 0.5, 1.0, False, False, "undecided"),
        (0.0, 0.5, 1.0, False, False, "undecided"),
        (0.0, 0.5, 1.0, True, False, "stable"),
        (0.0, 0.0, 0.0, False, False, "stable"),
        (5.0, np.inf, 1.0, False, False, "undecided"),
        (-5.0, np.inf, 1.0, False, False, "undecided"),
        (1e-9, 1e-8, 0.0, False, True, "rigid"),
    ],
)
def test_word_of_a_mode(growth, error, threshold, bounded, rigid, word):
    assert classify([growth], [error], [threshold], [bounded], [rigid]) == [word]


def test_real_kappa_apart_from_all_others_cannot_grow():
    kappa = np.array([1.0, 2.0, 2.1, 5.0, -1.0, 0.01, 3 + 1j, 3 - 1j])
    errors = np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
    free = [True, False, False, True, False, False, False, False]
    assert cannot_grow(kappa, errors, symmetric=False).tolist() == free


def test_copies_with_fine_conditions_cannot_grow_and_a_coalescence_may():
    kappa = np.array([2.0, 2.0 + 1e-13j, 2.0 - 1e-13j, 3.0, 3.0])
    errors = np.array([3e-13, 3e-13, 3e-13, 1e-8, 1e-8])
    found = cannot_grow(kappa, errors, symmetric=False)
    assert found.tolist() == [True, True, True, False, False]


def test_without_friction_equal_kappa_cannot_grow_either():
    kappa = np.array([1.0, 1.0, -1.0, 0.01])
    found = cannot_grow(kappa, np.full(4, 0.1), symmetric=True)
    assert found.tolist() == [True, True, False, False]


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
        ([], False, False, "no modes"),
    ],
)
def test_word_of_a_run(words, complete, missing, word):
    assert classify_run(words, complete=complete, missing=missing) == word


def test_counts_name_the_fastest_and_the_threshold():
    words = ["grows slowly"] * 11 + ["stable", "rigid", "unstable"]
    growth = [1e-4] * 10 + [1.3e-4, 0.0, 0.0, 2.0]
    said = counted_words(words, growth, None)
    for part in (
        "11 modes grow slowly (fastest +0.00013 1/s)",
        "1 rigid",
        "1 unstable (fastest +2 1/s)",
        "threshold 1e-4 |lambda|",
    ):
        assert part in said
    assert "threshold 50 1/s" in counted_words(words, growth, 50.0)
