"""Memory that is freed stays with the process until it is given back."""

import subprocess
import sys

import pytest

LARGE = 300_000_000
HELD = f"""
import numpy as np
import cea.petsc
from cea.heap import give_back, kept, plain_heap
from contextlib import nullcontext
def resident():
    lines = open("/proc/self/status").read().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmRSS"))
with {{heap}}():
    before = resident()
    np.ones({LARGE} // 8)
    freed, told = resident() - before, kept()
    give_back()
    print(freed, resident() - before, int(told), int(kept()))
"""


@pytest.mark.parametrize("heap", ["nullcontext", "plain_heap"])
def test_freed_memory_stays_until_it_is_given_back(heap):
    """By default it stays; as the C library does it by itself it does not."""
    code = HELD.format(heap=heap)
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    freed, left, known, known_left = map(int, told.stdout.split())
    assert left < 0.1 * LARGE
    assert known_left < 0.1 * LARGE
    if heap == "nullcontext":
        assert freed > 0.9 * LARGE
        assert 0.9 * LARGE < known < 1.1 * LARGE
    else:
        assert freed < 0.1 * LARGE
