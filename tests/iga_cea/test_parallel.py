"""NURBS bodies on 2 and 3 ranks: the same numbers as on one."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

PROGRAM = Path(__file__).parents[1] / "helpers" / "iga_parallel_numbers.py"
CASES = {1: ("ring", "disc", "hub", "odd"), 2: ("ring", "disc", "hub", "odd"), 3: ("disc", "odd")}
"""By number of ranks; three of them wait for each other on two cores."""


@cache
def numbers(ranks: int) -> dict:
    mpiexec = Path(sys.executable).with_name("mpiexec")
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(PROGRAM.parents[1])}
    command = [mpiexec, "-n", str(ranks), sys.executable, PROGRAM, *CASES[ranks]]
    run = subprocess.run(
        command, capture_output=True, text=True, timeout=300, env=environment, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return json.loads(run.stdout)


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
