"""Table of the machine and versions that made a record."""

from comparisons.kit.tables import Column, Data, Table


def machine(data: Data) -> Table:
    """Machine, versions, and the commit of the program."""
    rows = [
        *((name, str(value)) for name, value in data["machine"].items()),
        *((name, value) for name, value in data["versions"].items()),
        ("commit", data["commit"]),
    ]
    return Table("machine", "", (Column("name", "name"), Column("value", "value")), rows)
