"""NURBS bodies on 2 and 3 ranks: the same numbers as on one."""

import numpy as np
import pytest
from mpi import on_ranks

pytestmark = pytest.mark.mpi
EVERY = ("ring", "disc", "hub", "odd", "sector")
CASES = {1: EVERY, 2: EVERY, 3: ("disc", "odd", "sector")}
"""By number of ranks; three of them wait for each other on two cores."""


def numbers(ranks: int) -> dict:
    """Numbers of the cases by name, on so many ranks."""
    return on_ranks(ranks, "iga_parallel_numbers.of_cases", *CASES[ranks])


@pytest.mark.parametrize(
    ("ranks", "case"), [(ranks, case) for ranks in (2, 3) for case in CASES[ranks]]
)
def test_numbers_do_not_depend_on_the_ranks(ranks: int, case: str) -> None:
    alone, together = numbers(1)[case], numbers(ranks)[case]
    assert len(alone["same"]["frequencies"]) >= 4
    assert together["same"].keys() == alone["same"].keys()
    for quantity, expected in alone["same"].items():
        allowed = 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(
            together["same"][quantity], expected, rtol=1e-9, atol=allowed, err_msg=quantity
        )
    assert alone["asymmetry"] == together["asymmetry"] == 0
