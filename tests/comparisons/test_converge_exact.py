"""Error bars of ``cea converge`` against exact eigenvalues, at parameters drawn at random."""

from math import pi

import numpy as np
import pytest
from exact_scenes import ExactScene, random_scenes

from cea.eigen.eigenvalue_matching import assign
from comparisons.converge.request import Request
from comparisons.converge.study import run_converge
from comparisons.kit.progress import Progress

SILENT = Progress(step=lambda _: None, stage=lambda _: None)
COUNT = 20
SLOW = 1e-5
"""Lambda of rigid motions, which is exactly zero, relative to the fastest mode at most."""


def shares(case, digits, backends):
    """Errors of lambda over their bars, one for each mode."""
    request = Request(case.name, digits=digits, backends=backends, overrides=case.overrides)
    data = run_converge(request, SILENT)
    assert all(of["held"] for of in data["backends"].values())
    values = np.array([m["growth"] + 2j * pi * m["frequency"] for m in data["modes"]])
    bars = np.array([np.hypot(2 * pi * m["frequency_bar"], m["growth_bar"]) for m in data["modes"]])
    exact = case.exact()
    slow = SLOW * np.abs(exact).max()
    rows, columns = assign(np.abs(values[:, None] - exact) / np.maximum(np.abs(exact), slow))
    assert len(rows) == len(values)
    errors = np.abs(values[rows] - exact[columns])
    moving = exact[columns] != 0
    assert (errors <= 0.5 * 10.0 ** -(digits - 1) * np.abs(exact[columns]))[moving].all()
    assert (errors <= slow)[~moving].all()
    rigid = np.array([mode["rigid"] for mode in data["modes"]])[rows]
    assert (rigid == ~moving).all()
    return errors / bars[rows]


@pytest.mark.slow
def test_bars_are_honest_and_not_wide():
    """95 of 100 modes within their bars, all within three; ten times the error in the median."""
    found = []
    for i, case in enumerate(random_scenes(COUNT)):
        backends = ("iga",) if case.name == "ring" else ("iga", "fe")
        digits = 3 if case.name == "ring" else (2, 3, 4, 5)[i % 4]
        found.append(shares(case, digits, backends))
    every = np.concatenate(found)
    assert (every <= 1).mean() >= 0.95
    assert (every <= 3).all()
    assert np.median(1 / np.maximum(every, 1e-12)) <= 10


@pytest.mark.slow
@pytest.mark.parametrize("name", ["drum", "blocks"])
@pytest.mark.parametrize(
    ("backend", "digits"),
    [*(("iga", n) for n in (2, 3, 5, 8)), *(("fe", n) for n in (2, 3, 4, 5, 6))],
)
def test_digits_asked_for_are_reached(name, backend, digits):
    found = shares(ExactScene(name), digits, (backend,))
    assert (found <= 3).all()
    assert (found <= 1).mean() >= 0.9


@pytest.mark.slow
@pytest.mark.parametrize("digits", [2, 3])
def test_the_ring_in_space_reaches_its_digits(backend, digits):
    """With a rigid rotation of its disc, and curved cells."""
    found = shares(ExactScene("ring"), digits, (backend,))
    assert (found <= 3).all()
    assert (found <= 1).mean() >= 0.9
