"""Lagrange bodies on 2 and 3 ranks: the same numbers as on one."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

PROGRAM = Path(__file__).parents[1] / "helpers" / "fe_parallel_numbers.py"
EVERYTHING = ("tetrahedron", "hexahedron", "triangle", "quadrilateral", "contact")


@cache
def numbers(ranks, names=EVERYTHING):
    """Numbers of the cases by name, on so many ranks."""
    mpiexec = Path(sys.executable).with_name("mpiexec")
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(PROGRAM.parents[1])}
    command = [mpiexec, "-n", str(ranks), sys.executable, PROGRAM, *names]
    run = subprocess.run(
        command, capture_output=True, text=True, timeout=300, env=environment, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return json.loads(run.stdout)


@pytest.mark.parametrize(
    ("ranks", "names"), [(2, EVERYTHING), (3, ("triangle",))], ids=["2 ranks", "3 ranks"]
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
