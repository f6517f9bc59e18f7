"""The page of `cea bench contact`."""

from statistics import median

from comparisons.bench.contact.study import COMMAND
from comparisons.bench.report import Report
from comparisons.kit.numbers import number, shown
from comparisons.kit.tables import Column, Data, Table

_STAGES = ("rule", "search", "assembly")
_NAMES = {"fe": "Lagrange", "iga": "NURBS"}


def over_basis(run: Data) -> float:
    """Search and assembly over evaluating the bases at the points, median of all repeats."""
    return median((c["search"] + c["assembly"]) / c["basis"] for c in run["costs"])


def costs_table(data: Data) -> Table:
    """A row for each mesh and backend."""
    return Table(
        "contact",
        "A block on a block with friction, quadratic elements that do not match, 4 x 4 Gauss "
        "points on each face above: processor time by stage, and search and assembly over that of "
        "the basis.",
        (
            Column("backend", "functions"),
            Column("points", "points", number),
            Column("basis", "basis", shown(3), "s"),
            *(Column(stage, stage, shown(3), "s") for stage in _STAGES),
            Column("ratio", "over basis", shown(3)),
        ),
        [
            (
                _NAMES[run["backend"]],
                run["costs"][0]["points"],
                *(median(c[part] for c in run["costs"]) for part in ("basis", *_STAGES)),
                over_basis(run),
            )
            for run in data["runs"]
        ],
    )


def summary(data: Data) -> str:
    """What the finest meshes say."""
    finest = {run["backend"]: run for run in data["runs"]}  # the last of each
    told = (
        f"{_NAMES[backend]}: {number(over_basis(run), 3)} times as long as evaluating the bases at "
        f"{number(run['costs'][0]['points'])} points"
        for backend, run in finest.items()
    )
    return f"Search and assembly take, {'; '.join(told)}."


REPORT = Report(COMMAND, "Search and assembly of a contact", summary, (costs_table,), {})
