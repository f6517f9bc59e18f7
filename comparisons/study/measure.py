"""Seconds and memory of a block of work in this process."""

import gc
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

from cea.petsc import give_back

_PROCESS = Path("/proc/self")
_RESET_PEAK = "5"  # what clears the high-water mark of resident memory: proc(5), clear_refs


@dataclass
class Cost:
    """What a block of work took on this rank."""

    clock: float = 0.0  # seconds
    processor: float = 0.0  # seconds: other work does not lengthen these
    memory: float | None = None  # peak above what was held before (MB); None: not told


@contextmanager
def measured() -> Iterator[Cost]:
    """Measure the block: its cost is known when it ends."""
    gc.collect()
    give_back()
    try:
        (_PROCESS / "clear_refs").write_text(_RESET_PEAK, encoding="ascii")
        before = _memory("VmRSS")
    except OSError:
        before = None
    cost, clock, processor = Cost(), perf_counter(), process_time()
    yield cost
    cost.clock, cost.processor = perf_counter() - clock, process_time() - processor
    cost.memory = None if before is None else (_memory("VmHWM") - before) / 1e6


def _memory(field: str) -> float:
    """A field of the status of this process (bytes)."""
    status = (_PROCESS / "status").read_text(encoding="utf-8")
    found = re.search(rf"^{field}:\s+(\d+)", status, re.MULTILINE)
    return 1024.0 * int(found.group(1)) if found else 0.0
