"""Scenes that are not solved themselves: a reduced model of them answers, made over a map."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from cea.eigen.classify import classify_run, thresholds
from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.pencil import Pencil
from cea.reduced.greedy import TOLERANCE, Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.words import words_of
from comparisons.stability.parts.answers import ModesAnswer
from scenes.read import read_scene
from scenes.run import coupled


@dataclass(frozen=True)
class OfMap:
    """A scene as one value of a map.

    Parameters
    ----------
    data
        What a scene file holds; the map is asked for its values of the parameters.
    axes
        Values of parameters of its pencil between which full solves are made; the scene's own are
        not among them.
    """

    data: Mapping[str, Any]
    axes: Mapping[str, Sequence[float]]

    def solve(self, max_frequency: float | None) -> ModesAnswer:
        """The reduced model at the values of the scene."""
        data = deepcopy(dict(self.data))
        top = data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
        system, _, _ = coupled(read_scene(data), leave_out=False)
        pencil = system.pencil(leave_out=False)
        built = _built(pencil, self.axes, top, data["analysis"].get("min_growth"))
        found = built.at({}).window
        eigenvalues, errors = found.eigenvalues, found.uncertainties
        verdicts = words_of(found, None)
        complete = all(each.complete for each in built.snapshots)
        certified = found.bound <= TOLERANCE
        return ModesAnswer(
            eigenvalues=eigenvalues,
            verdicts=tuple(verdicts),
            verdict=classify_run(verdicts, complete=complete),
            thresholds=thresholds(eigenvalues),
            uncertainties=errors,
            complete=complete,
            max_frequency=top,
            residual=found.bound,
            condition=float(found.certificate.conditions.max(initial=1.0)),
            warnings=() if certified else ("not-certified",),
            dofs=system.size,
        )


def _built(
    pencil: Pencil, axes: Mapping[str, Sequence[float]], top: float, min_growth: float | None
) -> Enrichment:
    """A reduced model with full solves where its bounds were worst."""
    box = {name: (float(np.min(each)), float(np.max(each))) for name, each in axes.items()}
    built = Enrichment(ReducedModel(pencil, box, top, min_growth), KrylovSchur(pencil), top)
    points = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    built.cover(points)
    return built
