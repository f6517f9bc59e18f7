"""CalculiX and this program on the same meshes: each body alone, and both in frictional contact.

The meshes are straight tetrahedra of ten nodes, exported by :mod:`scenes.export.calculix`. CalculiX
integrates their mass with the four points of the stiffness, which is not exact. This program is run
with the same mass, to compare the programs, and with the exact mass, to measure that error.

Real eigenvalues of CalculiX are read with all digits from its binary file (``.eig``). Complex ones
are only in its text file (``.dat``), with seven digits.
"""

import os
import re
import shutil
import struct
import subprocess
from collections.abc import Iterator, Mapping, Sequence
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
from cea.errors import ConvergenceError, InputError
from comparisons.bench.solve import unstable
from comparisons.study.numbers import decimals, shown
from comparisons.study.sections import Column, Section, Table
from comparisons.study.study import Case, Session, Study, StudyResult
from fe_cea import LagrangeSpace
from scenes import run_modes
from scenes.building.build import body_mesh
from scenes.export.calculix import write_deck
from scenes.spec.body import FeMesh, MeshSpec
from scenes.spec.reading import Scene, load_scene

MASS_QUADRATURE = 2
"""Polynomial degree that four points integrate exactly: the mass of CalculiX."""
MODES = 20  # modes requested from CalculiX
_WIDER = 1.01  # end of the window of this program over the highest frequency of CalculiX
PROGRAM = "ccx"
_ROW = re.compile(r"^ +\d+((?: +-?\d\.\d+E[+-]\d+){3,4})\s*$")
_VERSION = re.compile(r"Version (\S+)")
_END_OF_LIST = "P A R T I C I P A T I O N"
PROGRAMS = ("CalculiX", "this program", "exact mass")
"""CalculiX, this program with the mass of CalculiX, this program with the exact mass."""


def program() -> str:
    """Return the path of CalculiX; an InputError if it is not installed."""
    found = shutil.which(PROGRAM)
    if found is None:
        allowed = "CalculiX on the path, as the Debian package calculix-ccx installs it"
        raise InputError("program", PROGRAM, allowed)
    return found


def version() -> str:
    """Return the version of CalculiX, such as ``2.20``."""
    done = subprocess.run([program(), "-v"], capture_output=True, text=True, check=False)
    found = _VERSION.search(done.stdout)
    return found.group(1) if found else "unknown"


def run(deck: Path) -> Complexes:
    """Run a deck with a frequency step on one thread; return lambda (1/s) by frequency.

    InputError if CalculiX is not installed, ConvergenceError if it fails.
    """
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [program(), deck.stem],
        cwd=deck.parent,
        env=environment,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    eigenvalues = results(deck)
    if done.returncode or not eigenvalues.size or "*ERROR" in done.stdout:
        last = " ".join((done.stdout + done.stderr).split()[-30:])
        raise ConvergenceError(f"CalculiX found no eigenvalues of {deck.name}: {last}")
    return eigenvalues


def results(deck: Path) -> Complexes:
    """Return the eigenvalues in the files of a run; empty if there is no ``.dat``."""
    listed = deck.with_suffix(".dat")
    eigenvalues = _listed(listed.read_text(encoding="utf-8") if listed.is_file() else "")
    kappa = stored_kappa(deck.with_suffix(".eig")) if eigenvalues.size else None
    if kappa is not None:
        eigenvalues = 1j * np.sqrt(kappa.astype(complex))
    return eigenvalues[np.lexsort((eigenvalues.real, eigenvalues.imag))]


def _listed(text: str) -> Complexes:
    """Return lambda = i omega of the text file, which prints omega = b + i c.

    A row has the mode number and, for symmetric matrices, omega^2, b, frequency, c; for
    unsymmetric matrices b, frequency, c, printed with both signs of c.
    """
    rows = [_ROW.match(line) for line in text.split(_END_OF_LIST)[0].splitlines()]
    numbers = [[float(word) for word in row.group(1).split()] for row in rows if row]
    return np.array([complex(row[-1], row[-3]) for row in numbers], dtype=complex)


def stored_kappa(file: Path) -> np.ndarray | None:
    """Return omega^2 (1/s^2) of the binary file; None if the step follows a static step."""
    content = file.read_bytes()
    cyclic, hermitian, perturbed, count = struct.unpack_from("=4i", content)
    if (cyclic, hermitian, perturbed) != (0, 1, 0):
        return None
    return np.frombuffer(content, np.float64, count, struct.calcsize("=4i"))


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
        theirs = run(write_deck(session.scene, Path(name), MODES)[1])
    top = _WIDER * float(theirs[-1].imag) / tau
    wide_enough = session.scene.change({"analysis.max_frequency": top})
    same, exact = (
        run_modes(wide_enough, bodies=bodies).eigenvalues
        for bodies in (bodies_of(wide_enough), None)
    )
    in_order = [v[np.lexsort((v.real, v.imag))] for v in (theirs, same, exact)]
    count = min(map(len, in_order))
    return {
        "runs": [{"calculix": version()}],
        "modes": _rows([values[:count] for values in in_order]),
        "unstable": _rows([unstable(values) for values in in_order]),
    }


def _rows(found: Sequence[Complexes]) -> list[dict[str, Any]]:
    """Return a row for each eigenvalue of each program."""
    return [
        {"program": program, "mode": i, "frequency": value.imag / tau, "growth": value.real}
        for program, values in zip(PROGRAMS, found, strict=True)
        for i, value in enumerate(values, 1)
    ]


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


_MODE = ["problem", "mesh", "mode"]


def beside(result: StudyResult, table: str = "modes") -> pd.DataFrame:
    """Frequency and growth rate of each mode, with a column for each program."""
    frame = result.frame(table)
    found = frame[_MODE].drop_duplicates()
    for program in PROGRAMS:
        own = frame[frame["program"] == program].drop(columns="program").set_index(_MODE)
        found = found.join(own.add_suffix(f", {program}"), on=_MODE)
    return found


def growing(result: StudyResult) -> pd.DataFrame:
    """Frequency and growth rate of each unstable mode, with a column for each program."""
    return beside(result, "unstable")


def differences(result: StudyResult) -> pd.DataFrame:
    """Largest relative difference of frequencies between the programs, by problem."""
    modes = beside(result)
    for program in PROGRAMS[1:]:
        modes[program] = (modes[f"frequency, {program}"] / modes["frequency, CalculiX"] - 1).abs()
    worst = modes.groupby(["problem", "mesh"], sort=False)[[*PROGRAMS[1:]]].max().reset_index()
    return result.frame().merge(worst, on=["problem", "mesh"])


COLUMNS = {
    "this program": Column("same mass", show=shown(2)),
    "exact mass": Column("exact mass", show=shown(2)),
    **{
        f"{name}, {program}": Column(f"{name}, {program}", unit, decimals(4))
        for name, unit in (("frequency", "Hz"), ("growth", "1/s"))
        for program in PROGRAMS
    },
}
_DIFFERENCES = "Largest relative differences from CalculiX, with its mass and with the exact mass."
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
            "CalculiX integrates the mass with the four points of the stiffness. With the same "
            "points the frequencies of a body agree; with the exact mass they are lower.",
            tables=[
                Table("differences", _DIFFERENCES, differences, COLUMNS, printed=True),
                Table("modes", "Modes by rising frequency.", beside, COLUMNS),
            ],
            of="modes",
        ),
        Section(
            "Unstable modes",
            "CalculiX drops the smallest contact segments, keeps the stick stiffness perpendicular "
            "to the direction of slip, and prints complex eigenvalues with seven digits.",
            tables=[Table("unstable", "Unstable modes.", growing, COLUMNS, printed=True)],
            of="unstable",
        ),
    ],
)
