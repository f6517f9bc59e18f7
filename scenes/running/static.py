"""Static analysis: a scene to its displacement and contact stresses, to data and back."""

from typing import Any, Unpack

import numpy as np

from cea.eigen.static import solve_static
from cea.errors import InputError
from cea.system.contact_stresses import NormalStress, contact_stresses
from cea.system.support_forces import support_reactions
from scenes.checking.doubts import doubtful_motions
from scenes.checking.skipped import skipped_by
from scenes.results.data import RunRecord, SideStress, described_run
from scenes.results.result import Fields, Result
from scenes.running.analysis import analysis_of
from scenes.running.system import RunOptions, coupled, system_warnings
from scenes.spec.reading import Scene, StaticAnalysis


def run_static(scene: Scene, **options: Unpack[RunOptions]) -> Result:
    """Displacement of a scene whose analysis asks for it; options are :class:`RunOptions`.

    Raises
    ------
    InputError
        When the analysis is another, or bodies or interfaces have other names than the scene's.
    """
    if not isinstance(scene.analysis, StaticAnalysis):
        raise InputError("analysis.kind", scene.analysis.kind, "'static'")
    system, interfaces, timer = coupled(scene, **options)
    if system.steady is not None:
        x, reactions = system.steady.displacement, system.steady.reactions
    else:
        with timer("assembly"):
            pencil = system.pencil(leave_out=options.get("leave_out", True))
        equilibrium = solve_static(pencil, system.load, timer)
        x = equilibrium.displacement
        with timer("post-processing"):
            reactions = support_reactions(system, x, equilibrium.forces)
    with timer("post-processing"):
        stresses = {
            name: contact_stresses(system, name, x, scene.analysis.samples)
            for name in scene.contacts
        }
        warnings = system_warnings(scene, system)
        if system.steady is None:
            warnings = (*warnings, *doubtful_motions(scene, system, x))
    return Result(
        analysis_of(scene),
        scene,
        timer,
        skipped_by(scene),
        warnings,
        stresses=stresses,
        reactions=reactions,
        interfaces=interfaces,
        coupled=system,
        solution=x,
    )


run = run_static
"""As :class:`scenes.results.result.Analysis` has it."""


def describe(result: Result) -> dict[str, Any]:
    """What the record of a result holds; `docs/result_json.md` says what every field is."""
    return described_run(result) | {
        "stresses": {
            name: {side: _described(stress) for side, stress in sides.items()}
            for name, sides in result.stresses.items()
        }
    }


def _described(stress: NormalStress) -> dict[str, Any]:
    along = [value if np.isfinite(value) else None for value in stress.sigma_n_along.tolist()]
    return {
        "oscillation": stress.oscillation,
        "min": stress.min,
        "max": stress.max,
        "arc": stress.arc.tolist(),
        "sigma_n_along": along,
    }


def opened(record: RunRecord) -> Fields:
    """Contact stresses from a record, without those at the points of the surfaces."""
    if record.stresses is None:
        raise InputError("scene.analysis.kind", "static", "'cea', as the data are")
    stresses = {
        name: {side: _stress(stress) for side, stress in sides.items()}
        for name, sides in record.stresses.items()
    }
    return {"stresses": stresses}


def _stress(stress: SideStress) -> NormalStress:
    along = np.array(stress.sigma_n_along, dtype=float)
    return NormalStress(stress.min, stress.max, np.array(stress.arc), along)


def table(result: Result) -> list[dict[str, Any]]:
    """A row for each side of each contact: extremes and oscillation of sigma_n (N/m^2)."""
    return [
        {"contact": name, "side": side, "min": s.min, "max": s.max, "oscillation": s.oscillation}
        for name, sides in result.stresses.items()
        for side, s in sides.items()
    ]


def lines(result: Result) -> list[str]:
    """What contacts and supports carry, then the rows of the table."""
    form = "{contact}, side {side}: sigma_n from {min:.6g} to {max:.6g}, oscillation "
    form += "{oscillation:.6g} N/m^2"
    rows = [form.format(**row) for row in table(result)]
    return [f"{result.scene.name}: static analysis", *result.steady_lines(), *rows]
