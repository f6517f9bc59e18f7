"""Grids of cases, of which the quick tests run a part that meets every pair of values."""

from itertools import combinations, product

import pytest


def covering(*axes, strength=2):
    """Rows of a grid for `pytest.mark.parametrize`; those outside a covering array are slow.

    The covering array holds every combination of the values of any two axes (``strength`` axes)
    at least once. It is chosen greedily, in the order of the grid, and is the same every time.
    """
    rows = list(product(*(range(len(axis)) for axis in axes)))
    wanted = {meets for row in rows for meets in _combinations(row, strength)}
    quick = set()
    while wanted:
        best = max(rows, key=lambda row: len(wanted.intersection(_combinations(row, strength))))
        quick.add(best)
        wanted.difference_update(_combinations(best, strength))
    return [
        pytest.param(
            *(axis[i] for axis, i in zip(axes, row, strict=True)),
            marks=() if row in quick else pytest.mark.slow,
        )
        for row in rows
    ]


def _combinations(row, strength):
    """Values of every so many axes that a row meets, by the numbers of the axes."""
    chosen = combinations(enumerate(row), min(strength, len(row)))
    return [tuple(pairs) for pairs in chosen]
