"""The friction at which a damped mass between four walls begins to flutter, against its damping."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from math import sqrt
from time import perf_counter
from typing import Any

import numpy as np

from comparisons.damping.scene import K1, K2, MODULUS, hulten_scene
from scenes.assembled import AssembledScene
from scenes.read import read_scene
from scenes.spec.body import Backend
from scenes.stored import record

COMMAND = "damping"
"""Command that a result is marked with."""

SHARES = (1.0, 3.0, 10.0)
"""Damping ratio of the second mode over that of the first."""

_RATIOS = tuple(float(f"{ratio:.4g}") for ratio in np.geomspace(1e-3, 0.3, 8))
_LOWEST, _HIGHEST = 0.005, 2.0
"""Friction below and above every threshold of these systems."""
_EXACT = 24


@dataclass(frozen=True)
class DampingStudy:
    """What is run.

    Parameters
    ----------
    backends
        Backends of the bodies.
    shares
        Damping ratio of the second mode over that of the first.
    ratios
        Means of both damping ratios.
    """

    backends: tuple[Backend, ...] = ("fe", "iga")
    shares: tuple[float, ...] = SHARES
    ratios: tuple[float, ...] = _RATIOS


def dampings(share: float, ratio: float) -> tuple[float, float]:
    """Damping c1, c2 (N s/m) of unit mass for a mean damping ratio and how it is shared out."""
    first = 2 * ratio / (1 + share)
    return 2 * sqrt(K1) * first, 2 * sqrt(K2) * (2 * ratio - first)


def exact_threshold(c1: float, c2: float) -> float:
    """Friction at which the lumped system begins to flutter, by its closed formula."""
    from exact_cea.lumped import hulten_threshold

    mu, _ = hulten_threshold(K1, str(K2), repr(c1), repr(c2), digits=_EXACT)
    return float(mu)


def computed_threshold(backend: Backend, c1: float, c2: float) -> float:
    """Friction at which the elastic bodies begin to flutter: where the largest growth rate is 0.

    Raises
    ------
    InputError
        When no friction between the lowest and the highest makes the first mode grow.
    """
    assembled = AssembledScene(read_scene(hulten_scene(backend, c1, c2)))
    try:
        return assembled.threshold("contacts.*.mu", _LOWEST, _HIGHEST).value
    finally:
        assembled.free()


DEFAULT = DampingStudy()


def run_damping(begin: Callable[[str], None], study: DampingStudy = DEFAULT) -> dict[str, Any]:
    """Run the study.

    Parameters
    ----------
    begin
        Called with each system in words as it begins.
    study
        What is run.

    Returns
    -------
    dict
        Record: ``undamped``, the exact threshold without damping, and ``rows`` with ``share``,
        ``ratio``, ``exact`` and a threshold for each backend.
    """
    start, rows = perf_counter(), []
    for share in study.shares:
        for ratio in study.ratios:
            c1, c2 = dampings(share, ratio)
            row: dict[str, Any] = {"share": share, "ratio": ratio}
            row["exact"] = exact_threshold(c1, c2)
            for backend in study.backends:
                begin(f"{backend}, damping ratio {ratio:g}")
                row[backend] = computed_threshold(backend, c1, c2)
            rows.append(row)
    data = {"undamped": exact_threshold(0.0, 0.0), "rows": rows, "E": MODULUS}
    return record(COMMAND, data, inputs=asdict(study), seconds=perf_counter() - start)
