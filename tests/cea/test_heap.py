"""Memory that is freed stays with the process until it is given back."""

import subprocess
import sys

import pytest

LARGE = 300_000_000
HELD = f"""
import numpy as np
import cea.petsc
from cea.heap import give_back, plain_heap
from contextlib import nullcontext
from comparisons.bench.memory import resident
with {{heap}}():
    before = resident()
    np.ones({LARGE} // 8)
    kept = resident() - before
    give_back()
    print(kept, resident() - before)
"""


@pytest.mark.parametrize("heap", ["nullcontext", "plain_heap"])
def test_freed_memory_stays_until_it_is_given_back(heap):
    """By default it stays; as the C library does it by itself it does not."""
    code = HELD.format(heap=heap)
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    kept, left = map(int, told.stdout.split())
    assert left < 0.1 * LARGE
    assert (kept > 0.9 * LARGE) if heap == "nullcontext" else (kept < 0.1 * LARGE)
