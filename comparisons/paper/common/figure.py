"""What a figure of the paper must offer, and a number of its text beside ours."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from comparisons.kit.numbers import number
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from scenes.spec.body import Backend

Data = dict[str, Any]
"""Plain data, ready for JSON."""


def as_lists(values: Any) -> list[Any]:
    """Numbers of an array as nested lists, None for NaN."""
    return np.asarray(np.where(np.isfinite(values), values, None)).tolist()


@dataclass(frozen=True)
class Number:
    """A number of the paper beside the one computed here.

    Parameters
    ----------
    what
        What it is.
    paper
        Value in the paper; words where it has only those, None where it says nothing.
    ours
        Value computed here.
    unit
        Unit of both.
    remark
        What a reader must know to compare them, in a few words.
    """

    what: str
    paper: float | str | None
    ours: float
    unit: str = ""
    remark: str = ""


class PaperFigure(Protocol):
    """A figure of the paper, or a study beside it."""

    @property
    def name(self) -> str:
        """Number of the figure; a word for a study."""
        ...

    @property
    def title(self) -> str:
        """What it shows."""
        ...

    def inputs(self, backend: Backend) -> Data:
        """Everything that determines the computation; stored data with equal inputs are reused."""
        ...

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Compute the figure; the same on every rank."""
        ...

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw computed data to files whose names begin with ``stem``, and return them."""
        ...

    def numbers(self, data: Data) -> list[Number]:
        """Every number of the paper's text about this figure, beside ours."""
        ...

    def note(self, data: Data) -> str:
        """What a reader must know to compare the numbers, below their table."""
        ...

    def tables(self, data: Data, stem: str) -> list[Table]:
        """Curves and maps as tables, for CSV files whose names begin with ``stem``."""
        ...


def numbers_table(numbers: Sequence[Number], stem: str, caption: str) -> Table:
    """Numbers of the paper beside ours, as a table."""
    return Table(
        f"{stem}_numbers",
        caption,
        (
            Column("what", "what"),
            Column("paper", "paper", _quoted),
            Column("ours", "ours", number),
            Column("unit", "unit"),
            Column("remark", "remark"),
        ),
        [(n.what, n.paper, n.ours, n.unit, n.remark) for n in numbers],
    )


def _quoted(value: float | str) -> str:
    return value if isinstance(value, str) else number(value)
