"""Effect of damping on the friction at which flutter begins: a mass between four walls.

The model of Hulten, built from elastic bodies. A stiff square of mass 1 kg slides along a wall on
each of its sides, with friction directed around the square; penalty contacts give it the stiffness
k1 along x and k2 along y. Opposite walls carry half of each, so that neither normal forces nor
friction rotate the square. Two degrees of freedom remain,

    x'' + c1 x' + k1 x - mu k2 y = 0,     y'' + c2 y' + mu k1 x + k2 y = 0

up to terms of the order k / E. Mass damping alpha = c1 acts along x and y; the rest of c2 comes
from friction that rises with the sliding speed on the walls normal to x.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import sqrt
from typing import Annotated, Any

import numpy as np
import pandas as pd

from comparisons.study.numbers import number, plain, shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Session, Study, StudyResult
from exact_cea.lumped import hulten_threshold
from scenes.running.assembled import AssembledScene
from scenes.spec.reading import Scene, read_scene

K1, K2 = 1.0, 1.44
"""Stiffness along x and y (N/m)."""
MODULUS = 1e6  # Young's modulus of all bodies (N/m^2)
_TOP = 0.3  # upper end of the window (Hz); the modes of the mass are at 0.16 and 0.19
_LOWEST, _HIGHEST = 0.005, 2.0
"""Friction coefficients below and above every threshold."""
_WALLS = {
    "left": ("x_min", "x_max", (-0.2, 0.0), (0.2, 1.0), (0.0, 1.0), K1),
    "right": ("x_max", "x_min", (1.0, 0.0), (0.2, 1.0), (0.0, -1.0), K1),
    "lower": ("y_min", "y_max", (0.0, -0.2), (1.0, 0.2), (-1.0, 0.0), K2),
    "upper": ("y_max", "y_min", (0.0, 1.0), (1.0, 0.2), (1.0, 0.0), K2),
}
"""Sides of the square and of the wall, corner and size of the wall, direction of friction on the
square, normal stiffness of the wall and the opposite one together."""
_RATIOS = tuple(float(f"{r:.4g}") for r in np.geomspace(1e-3, 0.3, 8))


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    backends: Annotated[tuple[str, ...], "Backends of the bodies."] = ("fe", "iga")
    shares: Annotated[tuple[float, ...], "Second damping ratio over the first."] = (1.0, 3.0, 10.0)
    ratios: Annotated[tuple[float, ...], "Means of both damping ratios."] = _RATIOS


def cases(options: Options) -> Iterator[Case]:
    """Yield a case for each backend and damping."""
    for share, ratio, backend in product(options.shares, options.ratios, options.backends):
        yield {"share": share, "ratio": ratio, "backend": backend}


def dampings(share: float, ratio: float) -> tuple[float, float]:
    """Damping c1, c2 (N s/m) of the mean damping ratio ``ratio``, with zeta2 / zeta1 = share."""
    first = 2 * ratio / (1 + share)
    return 2 * sqrt(K1) * first, 2 * sqrt(K2) * (2 * ratio - first)


def exact(share: float, ratio: float) -> float:
    """Friction coefficient at which the lumped system begins to flutter, in closed form."""
    c1, c2 = dampings(share, ratio)
    return float(hulten_threshold(K1, str(K2), repr(c1), repr(c2), digits=24)[0])


def scene(case: Case, options: Options) -> Scene:
    """The scene of a case, without friction."""
    c1, c2 = dampings(case["share"], case["ratio"])
    square = _body(case["backend"], (0.0, 0.0), (1.0, 1.0))
    bodies = {"square": square | ({"damping": {"alpha": c1}} if c1 else {})}
    contacts: dict[str, Any] = {}
    for name, (of_square, of_wall, corner, size, direction, k) in _WALLS.items():
        opposite = of_wall[:2] + {"min": "max", "max": "min"}[of_wall[2:]]
        bodies[name] = _body(case["backend"], corner, size) | {"supports": [{"surface": opposite}]}
        contacts[name] = {
            "a": f"square.{of_square}",
            "b": f"{name}.{of_wall}",
            "formulation": {"method": "gpts", "points": 3},
            "P": 0.5 * k,
            "form": "penalty",
            "friction_direction_on_a": {"vector": list(direction)},
        }
        if of_square[0] == "x" and c2 > c1:
            contacts[name]["sliding"] = {"pressure": 1.0, "mu_slope": 0.5 * (c2 - c1)}
    analysis = {"kind": "cea", "max_frequency": _TOP}
    return read_scene(
        {"name": "four walls", "bodies": bodies, "contacts": contacts, "analysis": analysis}
    )


def _body(backend: str, corner: tuple[float, ...], size: tuple[float, ...]) -> dict[str, Any]:
    """A stiff rectangle of one element; the mass of the square is 1 kg."""
    return {
        "backend": backend,
        "geometry": {"shape": "rectangle", "origin": list(corner), "size": list(size)},
        "material": {"E": MODULUS, "nu": 0.3, "rho": 1.0},
        "mesh": {
            "fe": {"cell": "quadrilateral", "degree": 2, "elements": [1, 1]},
            "iga": {"degree": [2, 2], "elements": [1, 1]},
        },
    }


def evaluate(case: Case, session: Session) -> dict[str, float]:
    """Friction coefficient at which the elastic bodies begin to flutter, and the exact one."""
    assert session.scene is not None
    assembled = AssembledScene(session.scene)
    try:
        found = assembled.threshold("contacts.*.mu", _LOWEST, _HIGHEST).value
    finally:
        assembled.free()
    right = exact(case["share"], case["ratio"])
    return {"exact": right, "threshold": found, "error": abs(found / right - 1)}


def curves(result: StudyResult) -> pd.DataFrame:
    """The thresholds of the elastic bodies on each backend, and the exact ones."""
    runs = result.frame()
    exact_ones = runs.assign(threshold=runs["exact"], backend="exact")
    return pd.concat([exact_ones.drop_duplicates(["share", "ratio"]), runs])


def headline(result: StudyResult) -> str:
    """Range of the thresholds with damping, and the largest error of the elastic bodies."""
    runs = result.frame()
    return (
        f"Flutter begins at μ = {number(exact(1.0, 0.0))} without damping, and between "
        f"{number(runs['exact'].min())} and {number(runs['exact'].max())} with it; relative "
        f"errors of the elastic bodies are at most {number(runs['error'].max(), 1)}."
    )


COLUMNS = {
    "share": Column("ζ₂ / ζ₁", show=plain),
    "ratio": Column("mean damping ratio", show=number),
    "exact": Column("exact", show=shown(8)),
    "threshold": Column("friction at which flutter begins", show=shown(8)),
}
TABLE = Table("damping", "Friction at which flutter begins.", "runs", COLUMNS, printed=True)
PLOT = Plot(
    "damping",
    "Exact: two degrees of freedom. Elastic bodies on both backends.",
    curves,
    "ratio",
    "threshold",
    ("share", "backend"),
    log="x",
    own=COLUMNS,
)
STUDY = Study(
    name="damping",
    title="Damping moves the threshold of flutter",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={"backends": ("iga",), "shares": (1.0, 10.0), "ratios": (0.1,)},
    sections=[Section("Thresholds", "", headline, [TABLE], [PLOT], of="runs")],
)
