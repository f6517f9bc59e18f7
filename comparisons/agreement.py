"""Comparison of both backends on the disc and pad: basic formulations, pairings of backends.

With mortar contact only the discretisation of the bodies differs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import pi
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd

from cea.contact.formulations import GaussPointToSurface, Greville, Grid, Mortar, NodeToSurface
from comparisons.study.numbers import decimals, number, per_cent, shown
from comparisons.study.sections import Column, Section, Table, diagram
from comparisons.study.study import Case, Session, Study, StudyResult
from scenes import Result
from scenes.results.matching import match_runs
from scenes.spec.body import Backend, backend_name
from scenes.spec.reading import BACKENDS, Scene, load_scene

FREQUENCY_BOUND, GROWTH_BOUND = 0.01, 0.15
"""Relative differences of frequencies and growth rates up to which two modes agree."""


@dataclass(frozen=True)
class Options:
    """Options of the comparison."""

    overrides: Annotated[tuple[str, ...], "Changes of the disc_pad scene."] = ()


def rules(backend: Backend) -> dict[str, Any]:
    """Formulations of the disc and pad; grids have about as many points on both backends."""
    own, grid = (Greville(), Grid(10)) if backend == "iga" else (NodeToSurface(), Grid(4))
    return {"collocation": own, "grid": grid, "GPTS": GaussPointToSurface(5), "mortar": Mortar()}


def cases(options: Options) -> Iterator[Case]:
    """Yield one case for each formulation, with all backends in it."""
    for formulation in rules("fe"):
        yield {"formulation": formulation}


def scene(case: Case, options: Options) -> dict[str, Scene]:
    """Scenes of a case by the backends of pad and disc."""
    disc_pad = load_scene(Path("disc_pad"), options.overrides)
    mortar = case["formulation"] == "mortar"
    pairs = product(BACKENDS, BACKENDS) if mortar else zip(BACKENDS, BACKENDS, strict=True)
    return {
        f"{backend_name(pad)} on {backend_name(disc)}": disc_pad.change(
            {
                "bodies.pad.backend": pad,
                "bodies.disc.backend": disc,
                "contacts.pad_disc.formulation": rules(pad)[case["formulation"]],
            }
        )
        for pad, disc in pairs
    }


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Solve all pairings, and match their unstable modes with those of the first."""
    assert session.scene is not None
    results = {name: session.solve(scene) for name, scene in session.scene.items()}
    runs, modes = [], []
    for number_of_run, (name, result) in enumerate(results.items(), 1):
        key = f"{case['formulation']}-{number_of_run}"
        rows = session.keep_modes(key, result, title=f"{case['formulation']}, {name}")
        window = result.modes.window
        runs.append(
            {
                "run": name,
                "dofs": result.dofs,
                "found": window.found_below,
                "counted": window.symmetric_count,
                "complete": bool(window.complete),
                "unstable": sum(row["verdict"] == "unstable" for row in rows),
                "condition": max((row["condition"] for row in result.table()), default=None),
                "seconds": result.timer.total,
            }
        )
        modes += [{"run": name} | row for row in rows]
    first, *others = results
    pairs = [
        {"compared": f"{other}, against {first}"} | pair
        for other in others
        for pair in _paired(results[first], results[other])
    ]
    return {"runs": runs, "modes": modes, "agreement": pairs}


def _paired(first: Result, second: Result) -> Iterator[dict[str, Any]]:
    """Yield a row for each unstable mode of two runs, with its partner if it has one."""
    chosen = [np.flatnonzero(result.unstable) for result in (first, second)]
    found = match_runs(first, second, *chosen, near=0.0, limit=None)
    for pair in found.groups:
        before, after = (_numbers(mean) for mean in pair.means)
        row: dict[str, Any] = {}
        for key, one in before.items():
            row |= {f"{key}_first": one, key: after[key], f"{key}_change": after[key] / one - 1}
        row["modal_assurance"] = pair.assurance
        near = abs(row["frequency_change"]) <= FREQUENCY_BOUND
        yield row | {"within": near and abs(row["growth_change"]) <= GROWTH_BOUND}
    nothing = dict.fromkeys(("frequency_change", "growth_change", "modal_assurance"))
    for end, result, modes in (
        ("_first", first, chosen[0][found.only_first]),
        ("", second, chosen[1][found.only_second]),
    ):
        for value in result.eigenvalues[modes].tolist():
            own = {f"{key}{end}": each for key, each in _numbers(value).items()}
            yield own | nothing | {"within": False}


def _numbers(eigenvalue: complex) -> dict[str, float]:
    """Return the frequency (Hz) and the growth rate (1/s) of an eigenvalue (1/s)."""
    return {"frequency": eigenvalue.imag / (2 * pi), "growth": eigenvalue.real}


def unstable(result: StudyResult) -> pd.DataFrame:
    """Unstable modes of all runs."""
    frame = result.frame("modes")
    return frame[frame["verdict"] == "unstable"].drop(columns="verdict")


def headline(result: StudyResult) -> str:
    """Largest differences of matched modes."""
    frame = result.frame("agreement")
    f, g = (number(100 * frame[f"{key}_change"].abs().max(), 2) for key in ("frequency", "growth"))
    return (
        f"Unstable modes of different backends differ by at most {f} % in frequency and {g} % in "
        f"growth rate; {frame['modal_assurance'].isna().sum()} have no partner."
    )


OWN = {
    "run": Column("pad on disc"),
    "condition": Column("largest condition", show=shown(2)),
    "frequency_first": Column("frequency", "Hz", decimals(2)),
    "growth_first": Column("growth rate", "1/s", decimals(2)),
}
PAIRED = OWN | {
    "compared": Column("runs"),
    "frequency": Column("compared", "Hz", decimals(2)),
    "frequency_change": Column("change", "%", per_cent),
    "growth": Column("compared", "1/s", decimals(2)),
    "growth_change": Column("change", "%", per_cent),
    "modal_assurance": Column("MAC", show=decimals(4)),
}
SECTIONS = [
    Section(
        "Disc and pad",
        "Unstable modes are matched by shape and frequency among all modes; MAC is the modal "
        "assurance criterion of both shapes on the contact surfaces. Within: differences of at "
        f"most {number(100 * FREQUENCY_BOUND, 1)} % in frequency and "
        f"{number(100 * GROWTH_BOUND, 2)} % in growth rate. Found: eigenvalues below the end of "
        "the window; counted: their number in the symmetric part, from its inertia.",
        headline,
        [
            Table(
                "agreement",
                "Unstable modes of the reference and of the compared run, and the change.",
                "agreement",
                PAIRED,
                printed=True,
            ),
            Table("unstable_modes", "Unstable modes of every run.", unstable, OWN),
            Table("runs", "Every run.", "runs", OWN),
            Table("modes", "", "modes", shown=False),
        ],
        [
            diagram(
                "stability", "Every mode of every run.", "modes", ("run",), panel=("formulation",)
            )
        ],
        modes=True,
        of="agreement",
    ),
]
STUDY = Study(
    name="agreement",
    title="Both backends on the disc and pad",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={
        "overrides": (
            "bodies.pad.mesh.fe.elements=[2, 3, 1]",
            "bodies.pad.mesh.iga.elements=[2, 3, 1]",
            "bodies.disc.mesh.fe.elements=[5, 24, 1]",
            "bodies.disc.mesh.iga.elements=[6, 28, 1]",
            "analysis.max_frequency=8500.0",
        ),
    },
    sections=SECTIONS,
)
