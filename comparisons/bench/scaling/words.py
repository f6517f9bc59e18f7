"""What the runs show, in sentences made of the data."""

from statistics import median

from comparisons.bench.scaling.model import RANKS, UNKNOWNS, needs, stage
from comparisons.bench.scaling.tables import ran
from comparisons.kit.numbers import number
from comparisons.kit.tables import Data

TITLE = "More ranks, more unknowns, higher degrees"


def summary(data: Data) -> str:
    """How much faster more ranks are, and what limits larger problems."""
    return " ".join(part for part in (_strong(data), limit(data)) if part)


def _strong(data: Data) -> str:
    runs = sorted((r for r in ran(data) if r["kind"] == "strong"), key=lambda run: run["ranks"])
    if len(runs) < 2:
        return ""
    first, last = runs[0], runs[-1]
    whole = [median(answer["longest"] for answer in run["answers"]) for run in (first, last)]
    assembly = [stage(run, "assembly", "busiest") for run in (first, last)]
    return (
        f"{last['ranks']} ranks run {number(last['answers'][0]['unknowns'])} unknowns "
        f"{number(whole[0] / whole[1], 3)} times as fast as {first['ranks']}, and assemble "
        f"{number(assembly[0] / assembly[1], 3)} times as fast."
    )


def limit(data: Data) -> str:
    """What would limit a run on many ranks, by the model."""
    found = list(needs(data))
    memory = {need.part: need.gigabytes for need in found if need.gigabytes is not None}
    hours = [need for need in found if need.hours is not None]
    if not memory or not hours:
        return ""
    slowest = max(hours, key=lambda need: need.hours or 0.0)
    told = ", ".join(f"{part} {number(size, 2)} GB" for part, size in memory.items())
    return (
        f"By the model, {number(UNKNOWNS)} unknowns on {RANKS} ranks would need of each: {told}; "
        f"most time would go to {slowest.part}, {number(slowest.hours, 2)} h."
    )
