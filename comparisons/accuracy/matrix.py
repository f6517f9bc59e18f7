"""The matrix that opens the page: for every formulation and stiffness whether it may be used."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from comparisons.accuracy.analysis import Use, uses
from comparisons.accuracy.study import RULES, Method
from comparisons.kit.numbers import MISSING, number, shown
from comparisons.kit.tables import Column, Data, Table

JUDGED = (
    "node",
    "node_tributary",
    "greville",
    "greville_area",
    "botella",
    "botella_area",
    "grid",
    "gpts",
    "gpts_lumped",
    "full_pass",
)
"""Contact rules that are judged: those that users choose among."""

_DEGREE = 2
_LOST = "modes lost"


@dataclass(frozen=True)
class Cell:
    """A formulation at one stiffness, over all problems it was run on.

    Parameters
    ----------
    method
        Bodies and contact rule.
    stiffness
        Contact stiffness p relative to the unit of each problem.
    found
        What was found on each problem.
    """

    method: Method
    stiffness: float
    found: tuple[Use, ...]

    @property
    def usable(self) -> bool:
        """Whether it is in every problem."""
        return bool(self.found) and all(use.usable for use in self.found)

    @property
    def lost(self) -> list[str]:
        """Problems in which modes were missing."""
        return [use.problem for use in self.found if use.error is None]

    @property
    def worst(self) -> float | None:
        """Worst error of the growth rate over the problems that lost no modes."""
        return max((use.error for use in self.found if use.error is not None), default=None)

    @property
    def floor(self) -> float | None:
        """Worst error of the growth rate of the yardsticks."""
        return max((use.floor for use in self.found), default=None)

    @property
    def text(self) -> str:
        """Verdict and worst error, as the matrix shows them."""
        if not self.found:
            return MISSING
        return f"{'✓' if self.usable else '✗'} {_LOST if self.lost else number(self.worst, 2)}"


def cells(data: Data) -> list[list[Cell]]:
    """Rows of the matrix: contact rules on each backend; columns: stiffnesses that rise."""
    found = [use for use in uses(data["runs"]) if use.method.degree == _DEGREE]
    tried = sorted({use.stiffness for use in found})
    return [row for row in _rows(found, tried) if any(cell.found for cell in row)]


def _rows(found: list[Use], tried: list[float]) -> Iterator[list[Cell]]:
    for rule in JUDGED:
        for backend in RULES[rule].backends:
            method = Method(backend, _DEGREE, rule)
            own = [use for use in found if use.method == method]
            yield [Cell(method, p, tuple(use for use in own if use.stiffness == p)) for p in tried]


def matrix_table(data: Data) -> Table:
    """A row for each cell of the matrix."""
    rows: list[tuple[Any, ...]] = [
        (
            cell.method.label,
            cell.stiffness,
            "yes" if cell.usable else "no",
            cell.worst,
            ", ".join(cell.lost),
            cell.floor,
            ", ".join(dict.fromkeys(use.problem for use in cell.found)),
        )
        for row in cells(data)
        for cell in row
        if cell.found
    ]
    return Table(
        "matrix",
        "For every formulation on bodies of degree 2 and every p whether it may be used, and its "
        "worst error of the growth rate over the problems.",
        (
            Column("method", "formulation"),
            Column("stiffness", "p", shown(3)),
            Column("usable", "usable"),
            Column("growth_worst", "worst error of growth", shown(2)),
            Column("lost", "modes lost in"),
            Column("yardstick_growth_worst", "that of the yardstick", shown(2)),
            Column("problems", "problems"),
        ),
        rows,
    )


def matrix_lines(data: Data) -> list[str]:
    """The matrix in Markdown, and under it what the yardsticks reach."""
    rows = cells(data)
    if not rows:
        return ["No formulation could be judged: no yardstick was run beside one.", ""]
    heads = ["formulation", *(f"p = {cell.stiffness:g}" for cell in rows[0])]
    body = [[row[0].method.label, *(cell.text for cell in row)] for row in rows]
    body += list(_yardsticks(rows))
    lines = [heads, ["---", *("---:" for _ in rows[0])], *body]
    return [*("| " + " | ".join(line) + " |" for line in lines), ""]


def _yardsticks(rows: list[list[Cell]]) -> Iterator[list[str]]:
    """For each discretisation the worst error of the yardsticks beside its formulations."""
    for name in dict.fromkeys(row[0].method.discretisation for row in rows):
        own = [row for row in rows if row[0].method.discretisation == name]
        floors = [
            max((cell.floor for cell in column if cell.floor is not None), default=None)
            for column in zip(*own, strict=True)
        ]
        yield [f"*{name}, yardstick*", *(f"*{number(floor, 2)}*" for floor in floors)]
