"""Grids of cases, of which the quick tests run a covering array and the slow tests all."""

from collections import defaultdict

import pytest


def mark_slow_cases(items):
    """Mark as slow what the quick tests leave out of the grids of tests marked ``grid``.

    ``@pytest.mark.grid`` keeps cases that hold every value of each parameter at least once,
    ``@pytest.mark.grid(quick=n)`` keeps n cases, spread evenly over the grid.
    """
    grids = defaultdict(list)
    for item in items:
        if item.get_closest_marker("grid") and not item.get_closest_marker("slow"):
            grids[item.nodeid.partition("[")[0]].append(item)
    for cases in grids.values():
        count = cases[0].get_closest_marker("grid").kwargs.get("quick")
        rows = [tuple((k, repr(v)) for k, v in item.callspec.params.items()) for item in cases]
        quick = _covering(rows) if count is None else _spread(len(rows), count)
        for number, item in enumerate(cases):
            if number not in quick:
                item.add_marker(pytest.mark.slow)


def _covering(rows):
    """Numbers of rows that hold every value of all rows, chosen greedily in their order."""
    chosen, missing = set(), {value for row in rows for value in row}
    while missing:
        best = max(range(len(rows)), key=lambda number: len(missing.intersection(rows[number])))
        chosen.add(best)
        missing.difference_update(rows[best])
    return chosen


def _spread(size, count):
    """So many numbers below a size, the first among them, evenly spread."""
    return {number * size // count for number in range(min(count, size))}
