"""The catalogue of cases, and the runs of each."""

from functools import cache

from cea.errors import InputError
from comparisons.stability.cases import (
    contact,
    damping,
    elements,
    friction,
    geometry,
    loads,
    materials,
    matrices,
)
from comparisons.stability.parts.case import Case, Run
from comparisons.stability.parts.ways import QUICK

_MODULES = (contact, damping, elements, friction, geometry, loads, materials, matrices)


@cache
def catalogue() -> dict[str, Case]:
    """Every case by its name."""
    found = {name: case.of(m.SUBJECT) for m in _MODULES for name, case in m.CASES.items()}
    return dict(sorted(found.items()))


@cache
def runs_of(name: str) -> tuple[Run, ...]:
    """Runs of a case.

    Raises
    ------
    InputError
        When there is no such case.
    """
    if name not in catalogue():
        raise InputError("case", name, f"one of {', '.join(catalogue())}")
    return tuple(catalogue()[name].runs())


def numbers_of(name: str, *, quick: bool) -> list[int]:
    """Numbers of the runs of a case, from 0; a quick study takes a few of each row.

    These are the ways of :data:`comparisons.stability.parts.ways.QUICK`, on one backend each, which
    alternates from row to row; a row without them keeps its first run.
    """
    runs = runs_of(name)
    if not quick:
        return list(range(len(runs)))
    rows = list(dict.fromkeys(run.row for run in runs))
    numbers = []
    for r, row in enumerate(rows):
        own = [i for i, run in enumerate(runs) if run.row == row]
        turn = {name: ("fe", "iga")[(r + k) % 2] for k, name in enumerate(QUICK)}
        picked = [i for i in own if turn.get(runs[i].way.name) == runs[i].way.backend]
        numbers += picked or own[:1]
    return numbers
