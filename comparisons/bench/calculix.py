"""CalculiX and this program on the same meshes: each body alone, and both in frictional contact.

The meshes are straight tetrahedra of ten nodes, exported by :mod:`scenes.export.decks`. CalculiX
integrates their mass with the four points of the stiffness, which is not exact. This program is run
with the same mass, to compare the programs, and with the exact mass, to measure that error.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import tau
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from cea.arrays import Complexes
from cea.body import Body
from cea.contact.formulations import Segments
from cea.eigen.classify import classify, thresholds
from comparisons.bench import ccx
from comparisons.study.columns import wide
from comparisons.study.numbers import counted, decimals, number, shown
from comparisons.study.sections import Column, Section, Table
from comparisons.study.study import Case, Session, Study, StudyResult
from fe_cea import LagrangeSpace
from scenes import run_modes
from scenes.building.build import body_mesh
from scenes.export.decks.write import write_deck
from scenes.spec.mesh import FeMesh, MeshSpec
from scenes.spec.reading import Scene, load_scene

MASS_QUADRATURE = 2
"""Polynomial degree that four points integrate exactly: the mass of CalculiX."""
MODES = 20  # modes requested from CalculiX
_WIDER = 1.01  # end of the window of this program over the highest frequency of CalculiX
_RIGID = 1e-6  # abs(lambda), relative to the largest, below which a mode is a rigid body mode
PROGRAMS = ("CalculiX", "this program", "exact mass")
"""CalculiX, this program with the mass of CalculiX, this program with the exact mass."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    # for each mesh: boxes of six tetrahedra along each direction of each body
    meshes: tuple[Mapping[str, tuple[int, ...]], ...] = (
        {"pad": (3, 5, 2), "disc": (5, 36, 1)},
        {"pad": (4, 8, 3), "disc": (7, 56, 2)},
    )


def cases(options: Options) -> Iterator[Case]:
    """Each body alone, then both bodies in contact, on each mesh."""
    for mesh in range(1, len(options.meshes) + 1):
        for problem in ("pad", "disc", "disc_pad"):
            yield {"problem": problem, "mesh": mesh}


def scene(case: Case, options: Options) -> Scene:
    """Return a scene of straight quadratic tetrahedra with exactly integrated contact."""
    meshes = {}
    for name, boxes in options.meshes[case["mesh"] - 1].items():
        mesh = FeMesh("tetrahedron", 2, geometry_degree=1, elements=boxes)
        meshes[f"bodies.{name}.mesh"] = MeshSpec(fe=mesh)
    whole, problem = load_scene("disc_pad", backend="fe").change(meshes), case["problem"]
    if problem in whole.bodies:
        bodies = {problem: whole.bodies[problem]}
        return replace(whole, name=problem, bodies=bodies, contacts={})
    return whole.change("contacts.pad_disc.formulation", Segments())


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Run a scene in both programs; return all modes by rising frequency, and unstable ones."""
    assert session.scene is not None
    with TemporaryDirectory() as name:
        theirs = ccx.run(write_deck(session.scene, Path(name), MODES)[1])
    top = _WIDER * float(theirs[-1].imag) / tau
    wide_enough = session.scene.change({"analysis.max_frequency": top})
    same, exact = (
        run_modes(wide_enough, bodies=bodies).eigenvalues
        for bodies in (bodies_of(wide_enough), None)
    )
    in_order = [v[np.lexsort((v.real, v.imag))] for v in (theirs, same, exact)]
    found = dict(zip(PROGRAMS, in_order, strict=True))
    count = min(map(len, in_order))

    def rows(chosen: Callable[[Complexes], Complexes]) -> list[dict[str, Any]]:
        return [
            {"program": program, "mode": i, "frequency": value.imag / tau, "growth": value.real}
            for program, values in found.items()
            for i, value in enumerate(chosen(values), 1)
        ]

    return {
        "runs": [{"calculix": ccx.version()}],
        "modes": rows(lambda values: values[:count]),
        "unstable": rows(unstable),
    }


def bodies_of(scene: Scene) -> dict[str, Body]:
    """Return the Lagrange bodies of a scene, with the mass of CalculiX."""
    return {
        name: Body(
            name,
            LagrangeSpace.from_mesh(
                body_mesh(name, spec, ()), degree=2, mass_quadrature=MASS_QUADRATURE
            ),
            spec.material,
            supports=spec.supports,
        )
        for name, spec in scene.bodies.items()
    }


def unstable(values: Complexes) -> Complexes:
    """Return the eigenvalues of unstable modes."""
    rigid = np.abs(values) <= _RIGID * np.abs(values).max(initial=0.0)
    words = classify(values.real, 0.0, thresholds(values), False, rigid)
    return values[np.array(words) == "unstable"]


_MODE = ["problem", "mesh", "mode"]


def beside(result: StudyResult, table: str) -> pd.DataFrame:
    """Frequency and growth rate of each mode, with a column for each program."""
    frame = result.frame(table)
    found = frame[_MODE].drop_duplicates()
    for program in PROGRAMS:
        own = frame[frame["program"] == program].drop(columns="program").set_index(_MODE)
        found = found.join(own.add_suffix(f", {program}"), on=_MODE)
    return found


def differences(result: StudyResult) -> pd.DataFrame:
    """Largest relative difference of frequencies between the programs, by problem."""
    modes = wide(result.frame("modes"), _MODE, "program", "frequency")
    for program in PROGRAMS[1:]:
        modes[program] = (modes[program] / modes["CalculiX"] - 1).abs()
    worst = modes.groupby(["problem", "mesh"], sort=False)[[*PROGRAMS[1:]]].max().reset_index()
    return result.frame().merge(worst, on=["problem", "mesh"])


def headline(result: StudyResult) -> str:
    """State the largest differences and the number of unstable modes of each program."""
    found = differences(result)
    contact = found["problem"] == "disc_pad"
    alone, touching = (found.loc[own, PROGRAMS[1]].max() for own in (~contact, contact))
    modes = result.frame("unstable")
    counts = [int((modes["program"] == p).sum()) if len(modes) else 0 for p in PROGRAMS[:2]]
    return (
        f"CalculiX {found['calculix'][0]} and this program on the same meshes. Frequencies of each "
        f"body alone differ by {number(alone, 2)} at most, in frictional contact by "
        f"{number(touching, 2)}; CalculiX finds {counted(counts[0], 'unstable mode')}, this "
        f"program {counts[1]}."
    )


COLUMNS = {
    "this program": Column("same mass", show=shown(2)),
    "exact mass": Column("exact mass", show=shown(2)),
    **{
        f"{name}, {program}": Column(f"{name}, {program}", unit, decimals(4))
        for name, unit in (("frequency", "Hz"), ("growth", "1/s"))
        for program in PROGRAMS
    },
}
STUDY = Study(
    name="bench calculix",
    title="Comparison with CalculiX",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={"meshes": ({"pad": (2, 3, 1), "disc": (3, 16, 1)},)},
    shipped=Path(__file__).parent / "calculix_results",
    sections=[
        Section(
            "Frequencies",
            "CalculiX integrates the mass of a tetrahedron of ten nodes with the four points of "
            "its stiffness. With the same points in this program the frequencies of a body agree "
            "to rounding; with the exact mass they are lower, less on finer meshes.",
            headline,
            [
                Table(
                    "differences",
                    "Largest relative difference of frequencies, with the mass of CalculiX and "
                    "with the exact mass in this program.",
                    differences,
                    COLUMNS,
                    printed=True,
                ),
                Table("modes", "Modes by rising frequency.", lambda r: beside(r, "modes"), COLUMNS),
            ],
            of="modes",
        ),
        Section(
            "Unstable modes",
            "In CalculiX a point slips if its friction force of the static step exceeds the limit "
            "in the frequency step. The deck therefore has twice the friction coefficient in the "
            "static step. CalculiX drops the smallest contact segments, keeps the stick stiffness "
            "perpendicular to the direction of slip, and prints complex eigenvalues with seven "
            "digits.",
            tables=[
                Table(
                    "unstable",
                    "Unstable modes of each program.",
                    lambda result: beside(result, "unstable"),
                    COLUMNS,
                    printed=True,
                )
            ],
            of="unstable",
        ),
    ],
)
