"""Lagrange bodies on 2 and 3 ranks: the same numbers as on one."""

import numpy as np
import pytest
from mpi import on_ranks

pytestmark = pytest.mark.mpi
EVERYTHING = ("tetrahedron", "hexahedron", "triangle", "quadrilateral", "contact")


def numbers(ranks, names=EVERYTHING):
    """Numbers of the cases by name, on so many ranks."""
    return on_ranks(ranks, "fe_parallel_numbers.of_cases", *names)


@pytest.mark.parametrize(
    ("ranks", "names"),
    [(2, EVERYTHING), pytest.param(3, EVERYTHING, marks=pytest.mark.slow)],
    ids=["2 ranks", "3 ranks"],
)
def test_numbers_do_not_depend_on_the_ranks(ranks, names):
    alone, together = numbers(1), numbers(ranks, names)
    assert set(together) == set(names)
    for name, found in together.items():
        assert len(found["frequencies"]) > 1
        for quantity, value in found.items():
            expected = np.asarray(alone[name][quantity])
            allowed = 1e-9 * np.abs(expected).max()
            np.testing.assert_allclose(
                value, expected, rtol=1e-9, atol=allowed, err_msg=f"{name}: {quantity}"
            )
