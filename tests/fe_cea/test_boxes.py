"""Boxes near points: all of them and no others, against a look at every pair."""

import numpy as np
import pytest

from cea.location import Boxes


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("reach", [0.0, 0.07])
def test_boxes_of_any_size_are_those_found_one_by_one(dim, reach):
    rng = np.random.default_rng(3)
    centre, x = rng.uniform(size=(80, dim)), rng.uniform(-0.2, 1.2, size=(120, dim))
    half = 10.0 ** rng.uniform(-3, -0.5, size=(80, dim))
    low, high = centre - half, centre + half
    point, box = Boxes(low, high).within(x, reach)
    beside = np.maximum(low - x[:, None], x[:, None] - high).max(axis=2)
    found = np.zeros(beside.shape, dtype=bool)
    found[point, box] = True
    assert len(point) == found.sum()  # none twice
    np.testing.assert_array_equal(found, beside <= reach)
    assert 0 < found.sum() < found.size
