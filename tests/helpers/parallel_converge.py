"""``cea converge`` on several ranks, for tests."""

from comparisons.converge.request import Request
from comparisons.converge.study import run_converge
from comparisons.study.session import Progress


def blocks_to_three_digits():
    """What is held, and frequencies and growth rates with their bars."""
    data = run_converge(Request("blocks"), Progress())
    names = ("frequency", "frequency_bar", "growth", "growth_bar")
    return {"first": data["first"], "values": [[m[name] for name in names] for m in data["modes"]]}
