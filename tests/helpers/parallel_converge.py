"""``cea converge`` on several ranks, for tests."""

from comparisons.converge.request import Request
from comparisons.converge.study import run_converge
from comparisons.kit.progress import Progress


def blocks_to_three_digits():
    """Frequencies with their bars, growth rates with theirs, and whether all digits are held."""
    data = run_converge(Request("blocks"), Progress(step=lambda _: None, stage=lambda _: None))
    modes = data["modes"]
    return {
        "frequencies": [[mode["frequency"], mode["frequency_bar"]] for mode in modes],
        "growths": [[mode["growth"], mode["growth_bar"]] for mode in modes],
        "held": all(of["held"] for of in data["backends"].values()),
        "verdicts": [mode["verdict"] for mode in modes],
    }
