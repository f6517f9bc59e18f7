"""Table of the converged modes of ``disc_pad``."""

from typing import Any

from comparisons.kit.numbers import number, shown
from comparisons.kit.tables import Column, Table

_CAPTION = (
    "Converged modes of disc_pad (mortar, P = 1e9 N/m, mu = 0.7): means of near-coalescing groups. "
    "Digits are those both backends share; changes are those of the last refinement."
)


def reference_table(data: dict[str, Any]) -> Table:
    """Frequencies and growth rates of both backends, the digits they share, the last changes."""
    columns = (
        Column("frequency", "NURBS", shown(7), "Hz"),
        Column("frequency_fe", "Lagrange", shown(7), "Hz"),
        Column("digits_frequency", "digits", number),
        Column("growth", "NURBS growth", shown(5), "1/s"),
        Column("growth_fe", "Lagrange growth", shown(5), "1/s"),
        Column("digits_growth", "digits", number),
    )
    names = [column.name for column in columns]
    changes = (
        Column("change_iga", "change, NURBS", shown(1)),
        Column("change_fe", "change, Lagrange", shown(1)),
    )
    rows = [
        (*(mode[name] for name in names), mode["change_iga"][0], mode["change_fe"][0])
        for mode in data["modes"]
    ]
    return Table("disc_pad_reference", _CAPTION, (*columns, *changes), rows)
