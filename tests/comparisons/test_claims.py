"""Claims of the paper judged by what is stored: nothing is computed, nothing drawn."""

import csv

import numpy as np

from comparisons.kit.progress import Progress
from comparisons.paper.claims.judge import judge, write_claims
from comparisons.paper.common.store import STORED


def no_step(name):
    """Nothing is left to compute."""
    raise AssertionError(name)


def rows_of(file):
    with file.open() as stream:
        return list(csv.DictReader(stream))


def test_stored_figures_decide_every_claim_and_are_not_drawn(tmp_path):
    every = judge(tmp_path, Progress(step=no_step, stage=no_step))
    assert list(tmp_path.iterdir()) == []
    table, _ = write_claims(every, tmp_path, seconds=0.0)
    stored = rows_of(STORED / "claims.csv")
    found = rows_of(table)
    for name in stored[0]:
        column, expected = ([row[name] for row in rows] for rows in (found, stored))
        if name.endswith("_value"):  # a sum is rounded otherwise where arrays lie otherwise
            numbers = [[float(value or "nan") for value in each] for each in (column, expected)]
            np.testing.assert_allclose(*numbers, rtol=1e-12)
        else:
            assert column == expected
    assert len(found) == len(stored) == len(every) > 10
