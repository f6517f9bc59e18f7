"""What each study leaves behind: result.json, tables, figures and a page in Markdown."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cea.files import write_whole
from comparisons.kit.provenance import machine
from comparisons.kit.records import RESULT, read_result
from comparisons.kit.tables import Data, Table
from scenes.results.record import write_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Report:
    """How the record of a study is shown.

    Parameters
    ----------
    command
        The command that the record is of.
    title
        Title of the page.
    summary
        The finding in short.
    tables, figures
        What is made of the record, figures by name.
    notes
        What a reader must know, a paragraph each.
    """

    command: str
    title: str
    summary: Callable[[Data], str]
    tables: Sequence[Callable[[Data], Table]]
    figures: Mapping[str, "Callable[[Data], Figure]"]
    notes: Sequence[str] = ()

    def read(self, out: Path) -> dict[str, Any]:
        """Record in a folder.

        Raises
        ------
        InputError
            When the folder holds none of this study.
        """
        return read_result(out, self.command)

    def write(self, data: dict[str, Any], out: Path) -> Path:
        """Write record, tables, figures and the page.

        Returns
        -------
        Path
            The page.
        """
        from comparisons.kit.plots import save

        write_record(data, out / RESULT)
        tables = [*(make(data) for make in self.tables), machine(data)]
        for table in tables:
            table.write_csv(out)
        for name, draw in self.figures.items():
            save(draw(data), out / f"{name}.png")
        page = out / "report.md"
        write_whole(("\n".join(self._lines(data, tables)) + "\n").encode(), page)
        return page

    def _lines(self, data: Data, tables: Iterable[Table]) -> list[str]:
        lines = [f"# {self.title}", "", self.summary(data), ""]
        for note in self.notes:
            lines += [note, ""]
        for name in self.figures:
            lines += [f"![{name}]({name}.png)", ""]
        for table in tables:
            if table.rows:
                lines += [f"## {table.name.replace('_', ' ').capitalize()}", ""]
                lines += [table.caption, ""] if table.caption else []
                lines += [*_in_markdown(table), ""]
        return lines[:-1]


def _in_markdown(table: Table) -> list[str]:
    """Lines of a table."""
    heads = [f"{c.title} ({c.unit})" if c.unit else c.title for c in table.columns]
    sides = ["---:" if c.show else "---" for c in table.columns]
    rows = (" | ".join(cell.replace("|", "/") for cell in row) for row in table.cells())
    return [f"| {' | '.join(heads)} |", f"|{'|'.join(sides)}|", *(f"| {row} |" for row in rows)]
