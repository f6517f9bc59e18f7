"""What the programs that assemble show, in sentences made of the data."""

from comparisons.bench.assembly.catalogue import OURS, PLAIN
from comparisons.bench.assembly.tables import ran, seconds
from comparisons.kit.numbers import number
from comparisons.kit.tables import Data

TITLE = "Assembly of stiffness and mass beside other programs"


def summary(data: Data) -> str:
    """Of every discretisation, this program over plain dolfinx or over the best of the others."""
    told = []
    for name in dict.fromkeys(run["discretisation"] for run in data["runs"]):
        runs = {run["program"]: run for run in ran(data) if run["discretisation"] == name}
        ours = runs.pop(OURS, None)
        if ours is None or not runs:
            continue
        other = PLAIN if PLAIN in runs else min(runs, key=lambda each: seconds(runs[each]))
        factor = number(seconds(ours) / seconds(runs[other]), 2)
        told.append(f"{name}: {factor} of {other}")
    return f"Processor time of this program. {'; '.join(told)}." if told else "Nothing to compare."
