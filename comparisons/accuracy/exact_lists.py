"""Exact lists of the study, stored beside it: they cost more than what is measured with them.

python -m comparisons.accuracy.exact_lists     # computes all of them anew
"""

import json
from functools import cache
from pathlib import Path

import numpy as np

from cea.arrays import Complexes
from cea.files import write_whole
from comparisons.accuracy.problems import PROBLEMS, Problem

STIFFNESSES = (0.1, 1.0, 10.0, 1000.0)
"""Contact stiffnesses p of the lists, in units of each problem."""
FILE = Path(__file__).with_name("exact.json")


@cache
def exact(name: str, stiffness: float) -> Complexes:
    """Exact eigenvalues of a problem, p in its unit: as stored, or computed where they are not."""
    chosen, entry = PROBLEMS[name], json.loads(FILE.read_text()).get(name, {})
    found = entry.get("lists", {}).get(f"{stiffness:g}")
    if found is None or entry["parameters"] != _parameters(chosen):
        return chosen.exact(stiffness)
    return np.array([complex(re, im) for re, im in found])


def _parameters(chosen: Problem) -> dict[str, float]:
    """What a list depends on, beside the materials and sizes of the reference problems."""
    return {"unit": chosen.unit, "mu": chosen.mu, "highest": chosen.highest_exact}


if __name__ == "__main__":
    data = {
        name: {
            "parameters": _parameters(chosen),
            "lists": {f"{p:g}": [[v.real, v.imag] for v in chosen.exact(p)] for p in STIFFNESSES},
        }
        for name, chosen in PROBLEMS.items()
    }
    # A line for each list: changes can be read.
    lines = json.dumps(data).replace('": [[', '":\n[[').replace("]], ", "]],\n") + "\n"
    write_whole(lines.encode(), FILE)
