"""What 64 ranks and 10^8 unknowns would need, from what was measured.

In space a direct factorisation by nested dissection takes n^2 operations, its factors n^(4/3)
numbers, and so does a solve (George, SIAM J. Numer. Anal. 10, 1973). Assembly, and a step of GMRES
with multigrid, take n. The largest run that was measured fixes the factors, and work is taken to
spread evenly over the ranks: what is told is the least that would be needed. Steps of GMRES are
taken to stay as they are.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import log
from statistics import median
from typing import Any

from comparisons.kit.tables import Data

UNKNOWNS = 1e8
RANKS = 64
MODES = 100
"""Modes that are asked for: solves are those of the measured run, for so many."""

_SOLVE, _FACTORISE = 4 / 3, 2.0


@dataclass(frozen=True)
class Need:
    """What one part of a run would need.

    Parameters
    ----------
    part
        What it is.
    exponent
        Power of the unknowns by which it grows.
    measured
        Unknowns of the largest run, and seconds or bytes there.
    hours
        Of each rank; None for memory.
    gigabytes
        Of each rank; None for time.
    """

    part: str
    exponent: float
    unknowns: int
    measured: float
    hours: float | None
    gigabytes: float | None


def needs(data: Data) -> Iterator[Need]:
    """What each part would need, of the direct inverse and of the iterative one."""
    runs = [run for run in by_kind(data, "size") if not run["failed"]]
    if runs:
        largest = max(runs, key=_unknowns)
        seconds = sum(stage(largest, name) for name in ("meshing", "search", "assembly"))
        yield _time("meshing, search, assembly", 1.0, _unknowns(largest), seconds)
    for way, name in (("mumps", "MUMPS"), ("gamg", "GMRES, multigrid")):
        found = [i for i in data["inverses"] if solved(i) and i["way"] == way and not i["shift"]]
        if not found:
            continue
        best = max(found, key=lambda inverse: inverse["unknowns"])
        n, direct = best["unknowns"], way == "mumps"
        solves = best["solves"] * MODES / data["inputs"]["wanted"]
        yield _time(f"{name}: setup", _FACTORISE if direct else 1.0, n, best["setup"])
        growth = _SOLVE if direct else 1.0
        yield _time(f"{name}: solves for {MODES} modes", growth, n, best["solve"] * solves)
        yield _memory(f"{name}: memory", growth, n, best["memory"])


def _time(part: str, exponent: float, unknowns: int, seconds: float) -> Need:
    hours = seconds * (UNKNOWNS / unknowns) ** exponent / RANKS / 3600
    return Need(part, exponent, unknowns, seconds, hours, None)


def _memory(part: str, exponent: float, unknowns: int, size: float) -> Need:
    gigabytes = size * (UNKNOWNS / unknowns) ** exponent / RANKS / 1e9
    return Need(part, exponent, unknowns, size, None, gigabytes)


def solved(inverse: Data) -> bool:
    """Whether an inverse found what it was asked for."""
    return not inverse["failed"]


def by_kind(data: Data, kind: str) -> list[Data]:
    """Runs of a row."""
    return [run for run in data["runs"] if run["kind"] == kind]


def stage(run: Data, name: str, what: str = "processor") -> float:
    """Seconds of a stage, median of the repeats."""
    return median(answer[what].get(name, 0.0) for answer in run["answers"])


def total(run: Data, what: str = "processor") -> float:
    """Seconds of all stages, median of the repeats."""
    return median(sum(answer[what].values()) for answer in run["answers"])


def exponents(runs: list[Data], name: str) -> list[float]:
    """Powers of the unknowns by which a stage grew from each run to the next."""
    rising = sorted(runs, key=_unknowns)
    return [
        log(stage(b, name) / stage(a, name)) / log(_unknowns(b) / _unknowns(a))
        for a, b in pairwise(rising)
        if stage(a, name) > 0 and stage(b, name) > 0 and _unknowns(a) < _unknowns(b)
    ]


def _unknowns(run: Data) -> Any:
    return run["answers"][0]["unknowns"]
