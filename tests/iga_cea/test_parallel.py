"""NURBS bodies on 2 and 3 ranks: the same numbers as on one."""

from itertools import product

import numpy as np
import pytest
from mpi import on_ranks

pytestmark = pytest.mark.mpi
CASES = ("ring", "closed", "disc", "hub", "odd", "sector")
QUICK = ("ring", "closed", "disc", "odd")
"""Cases of the quick tests, on 2 ranks: plane, closed, collapsed, joined in another order."""


@pytest.mark.parametrize(
    ("ranks", "case"),
    [
        pytest.param(*row, marks=() if row in product((2,), QUICK) else pytest.mark.slow)
        for row in product((2, 3), CASES)
    ],
)
def test_numbers_do_not_depend_on_the_ranks(ranks: int, case: str) -> None:
    alone, together = (on_ranks(n, "iga_parallel_numbers.numbers", case) for n in (1, ranks))
    assert len(alone["same"]["frequencies"]) >= 4
    assert together["same"].keys() == alone["same"].keys()
    for quantity, expected in alone["same"].items():
        allowed = 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(
            together["same"][quantity], expected, rtol=1e-9, atol=allowed, err_msg=quantity
        )
    assert alone["asymmetry"] == together["asymmetry"] == 0
