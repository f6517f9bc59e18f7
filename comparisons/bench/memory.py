"""Memory of this process, as the system tells it."""

import resource
from pathlib import Path

from cea.heap import give_back

_STATUS = Path("/proc/self/status")
_FORGET = "5"
"""What tells the system to count the largest memory of a process anew."""


def held() -> int:
    """Memory held now (bytes); what was freed is given back first."""
    give_back()
    return resident()


def resident() -> int:
    """Memory that the system counts to this process (bytes), freed or not."""
    return _field("VmRSS")


def largest() -> int:
    """Largest memory held so far (bytes)."""
    return _field("VmHWM")


def forget_largest() -> None:
    """Count the largest memory anew from here on; what was freed is given back first."""
    give_back()
    Path("/proc/self/clear_refs").write_text(_FORGET, encoding="ascii")


def limit(size: int) -> None:
    """Refuse this process more than so many bytes of addresses: what needs more fails."""
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size, most))


def _field(name: str) -> int:
    lines = _STATUS.read_text(encoding="utf-8").splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith(f"{name}:"))
