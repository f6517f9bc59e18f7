"""Answers of stability that are planted, to see what is made of them."""

import numpy as np

from comparisons.stability.parts.case import ACCURATE, Run
from comparisons.stability.parts.problems import ModesAnswer
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.ways import ALONE
from comparisons.stability.verdicts import judged

TRUE = np.array([1j, 2j, 0.2 + 3j, -0.2 + 3j, 8j])
"""Eigenvalues up to and beyond a window of 4 rad/s, one pair fluttering."""
SAID = ("stable", "stable", "unstable", "stable")


def answer(values=TRUE[:4], verdicts=SAID, **fields):
    """A claim of modes in a window of 4 rad/s."""
    values = np.asarray(values, dtype=complex)
    told = {
        "eigenvalues": values,
        "verdicts": tuple(verdicts),
        "verdict": "unstable" if "unstable" in verdicts else "stable",
        "thresholds": np.full(len(values), 1e-3),
        "uncertainties": np.zeros(len(values)),
        "complete": True,
        "max_frequency": 4 / (2 * np.pi),
        "residual": 1e-12,
        "condition": 1.0,
        "warnings": (),
        "dofs": 10,
    }
    return ModesAnswer(**{**told, **fields})


class Planted:
    """A problem that answers, or fails, as it is told."""

    def __init__(self, outcome):
        self.outcome = outcome

    def solve(self, max_frequency):
        """Answer or raise."""
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome


def verdict_of(outcome, expected=ACCURATE, true=TRUE, **fields):
    reference = None if true is None else formula(list(true))
    run = Run("planted", ALONE[0], Planted(outcome), reference, expected, 1e-6, **fields)
    return judged(run)
