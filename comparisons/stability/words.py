"""What the page of stability says, made of the data."""

from collections import Counter

from comparisons.kit.numbers import counted, listed, number
from comparisons.kit.tables import Data
from comparisons.stability.tables import KINDS


def summary(data: Data) -> str:
    """The study in short."""
    runs = data["runs"]
    counts = Counter(run["verdict"] for run in runs)
    told = listed(f"{number(counts[kind])} {kind}" for kind in KINDS)
    return (
        f"{counted(len(runs), 'run')} of {counted(len(data['cases']), 'case')}: {told}. "
        f"{easy(data)} {_unmet(data)}"
    )


def easy(data: Data) -> str:
    """How many easy runs are accurate and free of warnings."""
    chosen = [run for run in data["runs"] if run["easy"]]
    if not chosen:
        return "None of them is easy."
    clean = sum(run["met"] for run in chosen)
    share = "all" if clean == len(chosen) else number(clean)
    return (
        f"Of {counted(len(chosen), 'easy run')}, which must be accurate and free of warnings, "
        f"{share} {'is' if clean == 1 else 'are'}."
    )


def _unmet(data: Data) -> str:
    if not data["failed"]:
        return "Every run came out as the catalogue says beforehand."
    names = dict.fromkeys(run["case"] for run in data["runs"] if not run["met"])
    return (
        f"{counted(data['failed'], 'run')} did not come out as the catalogue says beforehand, in "
        f"{listed(names)}."
    )


def references(data: Data) -> str:
    """Where the true answers come from."""
    counts = Counter(run["reference"] for run in data["runs"] if run["reference"])
    without = sum(run["reference"] is None for run in data["runs"])
    words = {
        "dense": "dense eigenvalues of bodies and contact points (scipy)",
        "at rest": "dense eigenvalues of the body at rest, carried along by its rotation",
        "benign": "dense eigenvalues of the same scene in benign units or at benign parameters",
        "exact": "exact eigenvalues",
        "formula": "closed formulas",
    }
    parts = [f"{words[name]} ({number(count)} runs)" for name, count in counts.items()]
    told = f"References are {listed(parts)}." if parts else ""
    return f"{told} {counted(without, 'run')} can only be refused.".strip()
