"""Time and memory of a block of work in this process."""

import gc
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

from cea.petsc import give_back

_PROCESS = Path("/proc/self")
_RESET_PEAK = "5"  # resets the peak of resident memory: proc(5), clear_refs


@dataclass
class Cost:
    """Time and memory of a block of work on this rank."""

    clock: float = 0.0  # wall-clock time (s)
    processor: float = 0.0  # processor time (s), independent of other processes
    memory: float | None = None  # peak increase of resident memory (MB); None: unknown


@contextmanager
def measured() -> Iterator[Cost]:
    """Measure a block; its cost is set when it ends."""
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
