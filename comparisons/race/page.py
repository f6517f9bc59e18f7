"""What a race leaves behind: result.json and its table."""

from pathlib import Path
from typing import Any

from comparisons.kit.records import RESULT
from comparisons.race.tables import race_table
from scenes.results.record import write_record


def write_race(data: dict[str, Any], out: Path) -> Path:
    """Write the record and the table; the file of the record."""
    race_table(data).write_csv(out)
    return write_record(data, out / RESULT)
