"""The catalogue: every file of the folder of cases is one."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from cea.errors import InputError
from comparisons.stability import cases
from comparisons.stability.parts.case import Case, Run
from comparisons.stability.parts.ways import QUICK


@cache
def catalogue() -> dict[str, Case]:
    """Every case by the name of its file.

    Raises
    ------
    InputError
        When a file holds no case, or several.
    """
    found = {}
    for module in iter_modules(cases.__path__, f"{cases.__name__}."):
        made = [v for v in vars(import_module(module.name)).values() if isinstance(v, Case)]
        name = module.name.rpartition(".")[2]
        if len(made) != 1:
            raise InputError("case", name, f"one function marked with @case, not {len(made)}")
        found[name] = made[0]
    return found


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

    These are the ways of :data:`comparisons.stability.parts.ways.QUICK` on one backend each, in
    turn from row to row; a row without them keeps its first run.
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
