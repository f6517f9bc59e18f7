"""What `cea bench calculix` leaves behind: result.json, tables, and a page that holds them."""

from pathlib import Path
from typing import Any

from comparisons.kit.page import write_page
from comparisons.kit.provenance import machine
from comparisons.kit.records import read_result
from comparisons.kit.tables import Data, Table
from comparisons.peers import words
from comparisons.peers.study import COMMAND
from comparisons.peers.tables import differences_table, modes_table, times_table, unstable_table

TEMPLATE = Path(__file__).with_name("page.html")


def read_peers(out: Path) -> dict[str, Any]:
    """Data that :func:`write_peers` wrote.

    Raises
    ------
    InputError
        When the folder holds none.
    """
    return read_result(out, COMMAND)


def write_peers(data: dict[str, Any], out: Path) -> Path:
    """Write data, tables and the page.

    Returns
    -------
    Path
        The page: one file that needs no other.
    """
    return write_page(TEMPLATE, data, tables_of(data), out, words=words)


def tables_of(data: Data) -> list[Table]:
    """Every table of the page."""
    made = (differences_table, unstable_table, times_table, modes_table)
    return [*(make(data) for make in made), machine(data)]
