"""What the data of a study say: orders of convergence, Pareto fronts, where rules may be used."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from comparisons.accuracy.study import RULES, Method

Run = Mapping[str, Any]

TOLERABLE = 0.01
"""Error of growth, relative to the largest growth rate, up to which a rule is called usable."""
_TOO_COARSE = 0.1
"""Error of growth of a yardstick from which on a mesh says nothing of contact rules."""
_ROUNDING = 1e-9
"""Errors below this say nothing of the order: exact lists and Krylov iteration end here."""
_FITTED = 3
"""Finest meshes that an order is fitted to."""
_YARDSTICKS = ("mortar", "segments", "gpts")
"""Rules that show the error of the bodies alone, the best first."""


def method_of(run: Run) -> Method:
    """Method of a run or an omission."""
    return Method(**run["method"])


def seconds_of(run: Run) -> float:
    """Median run time (s)."""
    return float(np.median(run["seconds"]))


@dataclass(frozen=True)
class Line:
    """Runs of one method on one problem at one stiffness, by rising refinement."""

    problem: str
    method: Method
    stiffness: float
    runs: tuple[Run, ...]

    def errors(self, quantity: str = "lambda", which: str = "worst") -> list[float]:
        """Errors of a quantity; NaN where modes were missing."""
        values = (run[quantity][which] for run in self.runs)
        return [float("nan") if value is None else value for value in values]

    @property
    def order(self) -> float | None:
        """Observed order of the worst error of lambda in the mesh size; None of one mesh.

        Slope of a least-squares line through the finest meshes whose error is above rounding.
        """
        pairs = [
            (run["refinement"], error)
            for run, error in zip(self.runs, self.errors(), strict=True)
            if error > _ROUNDING
        ][-_FITTED:]
        return observed_order([n for n, _ in pairs], [error for _, error in pairs])

    def theory(self, highest: float | None) -> float | None:
        """Order of a smooth solution integrated exactly, capped by a singularity; else None."""
        if not RULES[self.method.rule].integrates:
            return None
        order = 2.0 * self.method.degree
        return order if highest is None else min(order, highest)


def observed_order(refinements: Iterable[float], errors: Iterable[float]) -> float | None:
    """Exponent q of ``error ~ refinement^-q`` by least squares; None of fewer than two."""
    n, error = np.array(list(refinements), float), np.array(list(errors), float)
    if len(n) < 2:
        return None
    return -float(np.polyfit(np.log(n), np.log(error), 1)[0])


def lines(runs: Iterable[Run]) -> list[Line]:
    """Runs by problem, method and stiffness, in the order in which each first appears."""

    def key(run: Run) -> tuple[str, Method, float]:
        return run["problem"], method_of(run), run["stiffness"]

    listed = list(runs)
    place = {k: i for i, k in enumerate(dict.fromkeys(map(key, listed)))}
    ordered = sorted(listed, key=lambda run: (place[key(run)], run["refinement"]))
    return [Line(*k, tuple(group)) for k, group in groupby(ordered, key)]


def pareto(runs: Iterable[Run]) -> list[Run]:
    """Runs that none beats in both run time and worst error of lambda, by rising run time."""
    front: list[Run] = []
    whole = [run for run in runs if run["lambda"]["worst"] is not None]
    for run in sorted(whole, key=lambda run: (seconds_of(run), run["lambda"]["worst"])):
        if not front or run["lambda"]["worst"] < front[-1]["lambda"]["worst"]:
            front.append(run)
    return front


@dataclass(frozen=True)
class Use:
    """Growth error of a rule beside that of a yardstick on the same mesh.

    Parameters
    ----------
    problem, method, stiffness, refinement
        The case.
    error
        Worst error of the growth rate; None where modes were missing.
    yardstick
        Rule it is measured against.
    floor
        Worst error of the growth rate of the yardstick.
    """

    problem: str
    method: Method
    stiffness: float
    refinement: int
    error: float | None
    yardstick: str
    floor: float

    @property
    def usable(self) -> bool:
        """Whether the error is tolerable, or no worse than twice that of the yardstick."""
        if self.error is None:
            return False
        return self.error <= max(TOLERABLE, 2 * self.floor)


def uses(runs: Iterable[Run]) -> list[Use]:
    """Growth errors of every rule on the finest mesh that a yardstick was run on too.

    By problem, method and stiffness; lines without a yardstick at their degree are left out, and
    meshes on which the yardstick itself lost modes or is far off.
    """
    table = {
        (run["problem"], method_of(run), run["stiffness"], run["refinement"]): run for run in runs
    }
    found: dict[tuple[str, Method, float], Use] = {}
    for (problem, method, p, n), run in sorted(table.items(), key=lambda item: item[0][3]):
        for rule in _YARDSTICKS:
            beside = table.get((problem, Method(method.backend, method.degree, rule), p, n))
            if beside is not None and rule != method.rule:
                floor = beside["growth"]["worst"]
                if floor is None or floor > _TOO_COARSE:
                    break
                found[problem, method, p] = Use(
                    *(problem, method, p, n),
                    run["growth"]["worst"],
                    rule,
                    floor,
                )
                break
    return [found[key] for key in dict.fromkeys(_keys(table)) if key in found]


def _keys(table: Mapping[tuple[str, Method, float, int], Run]) -> list[tuple[str, Method, float]]:
    rules = list(RULES)
    return sorted(
        (key[:3] for key in table),
        key=lambda k: (k[0], k[1].backend, k[1].degree, rules.index(k[1].rule), k[2]),
    )


def grouped_omissions(omissions: Iterable[Run]) -> dict[tuple[str, str], list[Run]]:
    """Omissions by problem and reason, in the order in which each first appears."""
    grouped: dict[tuple[str, str], list[Run]] = {}
    for omission in omissions:
        grouped.setdefault((omission["problem"], omission["reason"]), []).append(omission)
    return grouped


def incomplete(runs: Iterable[Run]) -> list[Run]:
    """Runs that missed modes of the band, or found modes that are none."""
    return [run for run in runs if run["missing"] or run["spurious"]]
