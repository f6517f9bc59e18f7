"""Tables that fit the terminal: text is wrapped at words, columns move below, no number is cut."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from textwrap import wrap

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import JustifyMethod
from rich.table import Table

_NARROWEST = 12
"""Width to which a column of text may shrink, where its words do."""
_GAP, _EDGE = 2, 1
"""Places between two columns of a table, and before the first."""
_PADDING = (0, _GAP - 1, 0, 0)
"""About the cells, above first: a box has a place of its own between columns."""


@dataclass(frozen=True)
class ShownColumn:
    """A column as it is printed.

    Parameters
    ----------
    title
        Its heading.
    cells
        Its texts.
    number
        Whether they are numbers: set to the right, never wrapped.
    """

    title: str
    cells: Sequence[str]
    number: bool

    @property
    def natural(self) -> int:
        """Width of its widest text, and of the longest word of its heading."""
        return max([_longest_word(self.title), *map(cell_len, self.cells)])

    @property
    def least(self) -> int:
        """Width below which a number, or a word, would be cut."""
        if self.number:
            return self.natural
        words = max([_longest_word(text) for text in (self.title, *self.cells)])
        return min(self.natural, max(words, _NARROWEST))


@dataclass
class Block:
    """Columns that stand beside each other.

    Parameters
    ----------
    columns
        The columns.
    widths
        Their widths.
    """

    columns: list[ShownColumn]
    widths: list[int] = field(default_factory=list)

    def table(self, title: str = "", styles: Sequence[str | None] = ()) -> Table:
        """The block for a terminal.

        Parameters
        ----------
        title
            What stands above.
        styles
            Styles of its rows; none by default.
        """
        shown = Table(title=title or None, title_justify="left", box=SIMPLE_HEAD, padding=_PADDING)
        for column, width in zip(self.columns, self.widths, strict=True):
            heading = "\n".join(_wrapped(column.title, width))
            side: JustifyMethod = "right" if column.number else "left"
            shown.add_column(heading, width=width, no_wrap=True, justify=side)
        for i in range(len(self.columns[0].cells)):
            cells = zip(self.columns, self.widths, strict=True)
            texts = ["\n".join(_wrapped(column.cells[i], width)) for column, width in cells]
            shown.add_row(*texts, style=styles[i] if styles else None)
        return shown


def total(widths: Sequence[int]) -> int:
    """Width of a block whose columns have these widths."""
    return sum(widths) + _GAP * len(widths) + _EDGE


def blocks(columns: Sequence[ShownColumn], width: int | None) -> list[Block]:
    """Columns in as few blocks as fit, each with the columns that name its rows.

    Parameters
    ----------
    columns
        The columns; those of text before the first number name the rows.
    width
        Width of the terminal; None where nothing bounds it.
    """
    every = list(columns)
    if width is None:
        return [Block(every, [column.natural for column in every])]
    keys = every[: next((i for i, column in enumerate(every) if column.number), 1)][:2] or every[:1]
    if total([column.least for column in keys]) > width // 2:
        keys = keys[:1]
    made: list[Block] = []
    rest = every
    while rest:
        chosen = rest[:1] if not made else [*keys, rest[0]]
        rest = rest[1:]
        while rest and total([column.least for column in (*chosen, rest[0])]) <= width:
            chosen, rest = [*chosen, rest[0]], rest[1:]
        made.append(Block(chosen, _widths(chosen, width)))
    return made


def _widths(columns: Sequence[ShownColumn], width: int) -> list[int]:
    """Widths of columns side by side: those of text shrink, the widest first."""
    widths = [column.natural for column in columns]
    while (excess := total(widths) - width) > 0:
        room = [w - column.least for w, column in zip(widths, columns, strict=True)]
        widest = max(range(len(widths)), key=lambda i: (room[i] > 0, widths[i]))
        if not room[widest]:
            break  # a single number wider than the terminal is left whole
        widths[widest] -= min(excess, room[widest], max(1, excess // len(widths)))
    return widths


def _wrapped(text: str, width: int) -> list[str]:
    """Lines of a text, broken at words; what has none is left as it is."""
    if cell_len(text) <= width:
        return [text]
    return wrap(text, width, break_long_words=False, break_on_hyphens=False) or [text]


def _longest_word(text: str) -> int:
    return max((cell_len(word) for word in text.split(" ")), default=0)
