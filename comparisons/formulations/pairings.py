"""Unstable modes of the disc and pad in every pairing of backends, beside each other.

With mortar contact only the bodies' own discretisation is left to differ. The last pairing is run
once more with a higher degree on the same elements: what changes there is not converged, however
well the pairings agree.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from cea.contact.formulations import Mortar
from comparisons.study.columns import Column
from comparisons.study.numbers import decimals, number, per_cent, shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case
from scenes import Result
from scenes.results.matching import match_unstable
from scenes.spec.body import Backend, BodySpec, MeshSpec, backend_name
from scenes.spec.reading import BACKENDS, Scene, load_scene, with_contact

FREQUENCY_BOUND = 0.01
"""Largest relative difference of frequencies that agree."""
GROWTH_BOUND = 0.15
"""Largest relative difference of growth rates that agree."""
PAIRINGS: tuple[tuple[Backend, Backend], ...] = tuple(product(BACKENDS, BACKENDS))
"""Backends of pad and disc; the others are compared with the first."""


@dataclass(frozen=True)
class Options:
    """Options of the pairings.

    Parameters
    ----------
    refined_degree
        Degree, in every direction, that the last pairing is run with once more.
    overrides
        Changes of the disc_pad scene.
    """

    refined_degree: int = 3
    overrides: tuple[str, ...] = ()


def cases(options: Options) -> Iterator[Case]:
    """All pairings together: they are compared with the first."""
    yield {"scene": "disc_pad"}


def paired(options: Options, backends: tuple[Backend, Backend]) -> Scene:
    """The scene in one pairing of pad and disc, with mortar contact."""
    scene = load_scene(Path("disc_pad"), options.overrides)
    bodies = {
        name: replace(scene.bodies[name], backend=backend)
        for name, backend in zip(("pad", "disc"), backends, strict=True)
    }
    return with_contact(replace(scene, bodies=bodies), formulation=Mortar())


def refined(options: Options, backends: tuple[Backend, Backend]) -> Scene:
    """The same with bodies of the refined degree."""
    scene = paired(options, backends)
    degree = options.refined_degree
    return replace(scene, bodies={n: _of_degree(b, degree) for n, b in scene.bodies.items()})


def _of_degree(body: BodySpec, degree: int) -> BodySpec:
    fe, iga = body.mesh.fe, body.mesh.iga
    return replace(
        body,
        mesh=MeshSpec(
            fe=fe and replace(fe, degree=degree),
            iga=iga and replace(iga, degree=(degree,) * len(iga.degree)),
        ),
    )


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Unstable modes of every pairing, and how far they are from those of the first."""
    options = session.options
    results = {_name(pair): session.solve(paired(options, pair)) for pair in PAIRINGS}
    first, last = _name(PAIRINGS[0]), _name(PAIRINGS[-1])
    finer = f"{last}, degree {options.refined_degree}"
    results[finer] = session.solve(refined(options, PAIRINGS[-1]))
    compared = [(first, other) for other in results if other not in (first, finer)]
    differences = [
        row
        for one, other in [*compared, (last, finer)]
        for row in _differences(f"{other}, against {one}", results[one], results[other])
    ]
    return {
        "pairing_runs": [_run(name, result) for name, result in results.items()],
        "pairing_modes": [
            {"run": name, **{key: row[key] for key in ("frequency", "growth")}}
            for name, result in results.items()
            for row in _unstable(result)
        ],
        "pairing_differences": differences,
    }


def _name(backends: tuple[Backend, Backend]) -> str:
    return " on ".join(map(backend_name, backends))


def _unstable(result: Result) -> list[dict[str, Any]]:
    """Unstable modes with their errors."""
    return [
        {
            "mode": row["mode"],
            "frequency": row["frequency"],
            "growth": row["growth_rate"],
            "residual": row["residual"],
            "condition": row["condition"],
        }
        for row in result.table()
        if row["verdict"] == "unstable"
    ]


def _run(name: str, result: Result) -> dict[str, Any]:
    window, unstable = result.modes.window, _unstable(result)
    return {
        "run": name,
        "dofs": result.dofs,
        "found": window.found_below,
        "counted": window.symmetric_count,
        "complete": window.complete,
        "unstable": len(unstable),
        "condition": max((row["condition"] for row in unstable), default=None),
        "seconds": sum(result.timer.seconds.values()),
    }


def _differences(label: str, first: Result, second: Result) -> Iterator[dict[str, Any]]:
    """Every unstable mode of two runs beside its partner."""
    found = match_unstable(first, second)
    for pair in found["pairs"]:
        row: dict[str, Any] = {"compared": label}
        for key in ("frequency", "growth"):
            one, other = pair[key]
            row |= {f"{key}_first": one, key: other, f"{key}_change": other / one - 1}
        row["modal_assurance"] = pair["modal_assurance"]
        row["within"] = (
            abs(row["frequency_change"]) <= FREQUENCY_BOUND
            and abs(row["growth_change"]) <= GROWTH_BOUND
        )
        yield row
    nothing = dict.fromkeys(("frequency_change", "growth_change", "modal_assurance"))
    for end, modes in (("_first", found["only_first"]), ("", found["only_second"])):
        for mode in modes:
            own = {f"{key}{end}": mode[key] for key in ("frequency", "growth")}
            yield {"compared": label} | own | nothing | {"within": False}


def table(name: str) -> Any:
    """Makes the frame of a table of the pairings."""
    return lambda result: result.frame(name).drop(columns=["part", "scene"], errors="ignore")


def headline(result: StudyResult) -> str | None:
    """How far paired modes are apart, and which are not converged."""
    frame = table("pairing_differences")(result)
    if frame.empty:
        return None
    degree = frame["compared"].str.contains("degree")
    pairs, finer = frame[~degree], frame[degree]
    alone = int(pairs["modal_assurance"].isna().sum())
    changed = finer["frequency_first"].fillna(finer["frequency"])[~finer["within"]]
    open_ones = [f"{number(f, 4)} Hz" for f in changed]
    return (
        "Unstable modes of other backends differ by at most "
        f"{number(100 * pairs['frequency_change'].abs().max(), 2)} % in frequency and "
        f"{number(100 * pairs['growth_change'].abs().max(), 2)} % in growth rate, "
        f"{alone} have no partner; not converged in the degree: {', '.join(open_ones) or 'none'}."
    )


OWN = {
    "run": Column("pad on disc"),
    "unstable": Column("unstable", show=number),
    "found": Column("found", show=number),
    "counted": Column("counted", show=number),
    "condition": Column("largest condition", show=shown(2)),
    "frequency_first": Column("frequency", "Hz", decimals(2)),
    "frequency": Column("compared", "Hz", decimals(2)),
    "frequency_change": Column("change", "%", per_cent),
    "growth_first": Column("growth rate", "1/s", decimals(2)),
    "growth": Column("compared", "1/s", decimals(2)),
    "growth_change": Column("change", "%", per_cent),
    "modal_assurance": Column("modal assurance", show=decimals(4)),
}
SECTION = Section(
    "Pairings of backends",
    "Disc and pad with mortar contact. Found: eigenvalues below the end of the window; counted: "
    "those that the inertia of the symmetric part has there. Within: at most "
    f"{number(100 * FREQUENCY_BOUND, 1)} % in frequency and {number(100 * GROWTH_BOUND, 2)} % in "
    "growth rate.",
    headline,
    [
        Table("pairing_runs", "Every run.", table("pairing_runs"), OWN),
        Table(
            "pairing_differences",
            "Unstable modes paired by shape and eigenvalue: those compared with, those compared, "
            "and the change.",
            table("pairing_differences"),
            OWN,
            group="compared",
        ),
    ],
    [
        Plot(
            *("pairings", "Unstable modes of every run.", table("pairing_modes")),
            *("frequency", "growth", ("run",)),
            style="markers",
        )
    ],
)
