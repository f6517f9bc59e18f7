"""Locking: error of the lowest eigenvalues of `blocks` against contact stiffness.

If a penalty acts at more points than side a has trace functions, then for large p the interface can
only follow motions that both meshes share: it locks. Mortar has one constraint for each trace
function of side a.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, tau
from typing import Annotated, Any

import pandas as pd

from comparisons.study.columns import wide
from comparisons.study.formulations import Variant, variants
from comparisons.study.matching import match_spectrum
from comparisons.study.numbers import shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Session, Study, StudyResult
from exact_cea.reference import exact_eigenvalues
from scenes.spec.body import backend_name
from scenes.spec.reading import BACKENDS, Scene, load_scene

_MU0 = 0.3  # amplitude of the friction coefficient mu0 sin(pi x / 2)
_HIGHEST = 2.2  # highest Im lambda of the eigenvalues compared: six lie below
_DEGREE = 2  # degree of both bodies; splines have full continuity
_GAUSS, _GRID = (3, 6), 37
"""GPTS points per direction in an element; equally spaced points on side a."""
_MARGIN = 1.15  # end of the search over the highest exact eigenvalue: locked ones lie too high
_LOCKED = 10.0  # error at the largest p over the smallest error, above which a rule locks
_STIFFNESSES = (*(float(10**k) for k in range(10)), inf)


@dataclass(frozen=True)
class Options:
    """Options of the study."""

    # body a has E = 0.1 and thickness 0.5; infinite p uses the saddle form
    p: Annotated[tuple[float, ...], "Contact stiffnesses (N/m^3)."] = _STIFFNESSES
    elements_a: Annotated[tuple[int, int], "Elements of body a along x and y."] = (12, 4)
    elements_b: Annotated[tuple[int, int], "Elements of body b along x and y."] = (13, 8)
    formulations: Annotated[tuple[str, ...], "Labels of formulations; default: all."] = ()


def offered(options: Options, backend: Any) -> dict[str, Variant]:
    """Return formulations by label, with about the same grid points on both backends."""
    grid = _GRID
    if backend == "fe":
        grid = 1 + max(1, round((grid - 1) / options.elements_a[0]))
    return variants((backend, backend), _GAUSS, grid, options.formulations)


def cases(options: Options) -> Iterator[Case]:
    """Every formulation on both backends at every p; infinite p is impossible with lumping."""
    for backend in BACKENDS:
        for label, variant in offered(options, backend).items():
            for p in options.p:
                if p < inf or variant.formulation.coupling != "lumped":
                    yield {"backend": backend, "formulation": label, "p": p}


def scene(case: Case, options: Options) -> Scene:
    """Return ``blocks`` on the meshes of the study with the contact of a case."""
    changes: dict[str, Any] = {
        "contacts.interface.mu": f"{_MU0!r}*sin(pi*x/2)",
        "analysis.max_frequency": _MARGIN * _HIGHEST / tau,
    }
    for body, elements in (("upper", options.elements_a), ("lower", options.elements_b)):
        changes[f"bodies.{body}.mesh"] = {
            "fe": {"cell": "quadrilateral", "degree": _DEGREE, "elements": list(elements)},
            "iga": {"degree": [_DEGREE] * 2, "elements": list(elements)},
        }
    blocks = load_scene("blocks", backend=case["backend"]).change(changes)
    return offered(options, case["backend"])[case["formulation"]].of(blocks, p=case["p"])


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Return the worst relative error; an eigenvalue with an error above 15 % is lost."""
    result = session.solve()
    exact = exact_eigenvalues("blocks", p=case["p"], mu=_MU0, max_frequency=_HIGHEST)
    match = match_spectrum(result.eigenvalues, exact, reach=_MARGIN - 1)
    worst = float(match.errors.max())
    a = result.interfaces["interface"].a
    return {
        "points": sum(len(interface.points) for interface in result.interfaces.values()),
        "traces": len(a.abscissae(a.abscissa_kinds[0])),
        "lost": not isfinite(worst),
        "error": worst if isfinite(worst) else None,
    }


def finite(result: StudyResult) -> pd.DataFrame:
    """Runs with finite p."""
    return result.frame().query("p < inf")


def locked(result: StudyResult) -> dict[str, list[str]]:
    """Return, by backend, formulations whose error grows with p or that lose an eigenvalue."""
    found: dict[str, list[str]] = {}
    for (backend, name), own in finite(result).groupby(["backend", "formulation"], sort=False):
        errors = own["error"].tolist()
        if own["lost"].any() or errors[-1] > _LOCKED * min(errors):
            found.setdefault(backend, []).append(name)
    return found


def headline(result: StudyResult) -> str:
    """Name the formulations that lock."""
    names = [f"{backend_name(b)}: {'; '.join(f)}" for b, f in locked(result).items()]
    return f"The error grows with p, or an eigenvalue is lost: {'. '.join(names) or 'none'}."


_LABELS = ["backend", "formulation", "points", "traces"]
OWN = {"error": Column("worst relative error of λ", show=shown(2))}
SECTION = Section(
    "Locking",
    "Worst relative error of the eigenvalues of the blocks against contact stiffness p. A "
    "formulation locks if its error grows with p. A dash means that an eigenvalue was lost or that "
    "p = ∞ is impossible.",
    headline,
    [
        Table(
            "locking",
            "Error at each p.",
            lambda result: wide(result.frame(), _LABELS, "p", "error"),
            OWN,
        )
    ],
    [
        Plot(
            "locking",
            "A line ends where an eigenvalue is lost.",
            finite,
            "p",
            "error",
            ("formulation",),
            ("backend",),
            "xy",
            OWN,
        )
    ],
    of="runs",
)
STUDY = Study(
    name="locking",
    title="Locking of contact formulations",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={
        "p": (1.0, 1e6),
        "elements_a": (6, 2),
        "elements_b": (7, 3),
        "formulations": ("Greville", "segments", "mortar"),
    },
    sections=[SECTION],
)
