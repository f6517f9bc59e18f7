"""The table of a race."""

from statistics import median

from comparisons.kit.numbers import shown
from comparisons.kit.tables import Column, Data, Table


def race_table(data: Data) -> Table:
    """A row for each entrant: medians of seconds, and how many modes it found."""
    first = median(data["entrants"][0]["processor"])
    return Table(
        "race",
        f"Seconds for {data['scene']}, medians of {len(data['entrants'][0]['seconds'])} runs "
        "in one process.",
        (
            Column("name", "way"),
            Column("seconds", "clock", shown(3), "s"),
            Column("processor", "processor", shown(3), "s"),
            Column("relative", "of ours", shown(3)),
            Column("found", "modes found", shown(3)),
            Column("modes", "of", shown(3)),
        ),
        [
            (
                entrant["name"],
                median(entrant["seconds"]),
                median(entrant["processor"]),
                median(entrant["processor"]) / first,
                entrant["found"],
                data["modes"],
            )
            for entrant in data["entrants"]
        ],
    )
