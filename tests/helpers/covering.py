"""Grids of cases, of which the quick tests run a covering array and the slow tests all.

A covering array holds every value of each parameter at least once, or every combination of the
values of any two.
"""

from collections import defaultdict
from itertools import combinations, product

import pytest


def covering(*axes, strength=2):
    """Rows of a grid for `pytest.mark.parametrize`; those outside a covering array are slow.

    The array holds every combination of the values of any two axes (``strength`` axes).
    """
    rows = list(product(*(range(len(axis)) for axis in axes)))
    quick = _covering_array(rows, strength)
    return [
        pytest.param(
            *(axis[i] for axis, i in zip(axes, row, strict=True)),
            marks=() if number in quick else pytest.mark.slow,
        )
        for number, row in enumerate(rows)
    ]


def mark_slow_cases(items):
    """Mark as slow what the quick tests leave out of tests marked ``grid``.

    ``@pytest.mark.grid`` keeps cases that hold every value of each parameter, fixtures among them;
    ``@pytest.mark.grid(quick=n)`` keeps n cases, spread evenly over the grid.
    """
    grids = defaultdict(list)
    for item in items:
        if item.get_closest_marker("grid") and not item.get_closest_marker("slow"):
            grids[item.nodeid.partition("[")[0]].append(item)
    for cases in grids.values():
        count = cases[0].get_closest_marker("grid").kwargs.get("quick")
        if count is None:
            rows = [tuple(map(repr, item.callspec.params.values())) for item in cases]
            quick = _covering_array(rows, 1)
        else:
            quick = {number * len(cases) // count for number in range(count)}
        for number, item in enumerate(cases):
            if number not in quick:
                item.add_marker(pytest.mark.slow)


def _covering_array(rows, strength):
    """Numbers of rows, chosen greedily in their order, the same every time."""
    held = [set(combinations(enumerate(row), min(strength, len(row)))) for row in rows]
    chosen, missing = set(), set().union(*held)
    while missing:
        best = max(range(len(rows)), key=lambda number: len(missing & held[number]))
        chosen.add(best)
        missing -= held[best]
    return chosen
