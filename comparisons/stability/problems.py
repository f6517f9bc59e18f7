"""Problems that runs solve, and their answers: eigenvalues or stresses, verdicts, warnings."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, save_npz

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import classify_run, thresholds
from cea.eigen.driver import EigenSolver
from cea.matrices import distributed
from cea.petsc import PETSc
from cea.reduced.greedy import TOLERANCE, Enrichment
from cea.reduced.model import ReducedModel
from meshes.breaks import breaks_of
from meshes.mesh_file import METRES, Unit
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Rectangle
from scenes import Result, run_scene
from scenes.export.deck_model import keyword, table
from scenes.results.record import as_json
from scenes.running.matrices import run_matrices
from scenes.running.run import coupled
from scenes.spec.matrices import read_matrix_scene
from scenes.spec.plain import plain_data
from scenes.spec.reading import Scene, read_scene

UNDECIDED, NOT_COMPLETE = "undecided", "window-not-complete"
"""Marks of answers with undecided modes, or with a window that may not be complete."""


@dataclass(frozen=True)
class Answer:
    """Modes of a run, with verdicts, error estimates and warnings."""

    eigenvalues: Complexes  # lambda (1/s), (n,)
    verdicts: tuple[str, ...]  # the verdict on each mode
    verdict: str  # the verdict on the whole window
    thresholds: Floats  # growth rate (1/s) above which each is called unstable, (n,)
    uncertainties: Floats  # error of lambda (1/s) that the run states for each, (n,)
    complete: bool  # whether the window claims to hold every mode
    max_frequency: float  # upper end of the window (Hz)
    residual: float  # the worst
    condition: float
    warnings: tuple[str, ...]  # their kinds
    dofs: int
    min_growth: float = -np.inf  # growth rate (1/s) down to which the window holds every mode

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of its warnings, and marks of undecided modes and an incomplete window."""
        undecided = "undecided" in (*self.verdicts, self.verdict)
        open_ends = [UNDECIDED] * undecided + [NOT_COMPLETE] * (not self.complete)
        return tuple(dict.fromkeys([*self.warnings, *open_ends]))


@dataclass(frozen=True)
class StressAnswer:
    """Normal stresses (N/m²) over both sides of the contacts of a static run, shape (n,)."""

    stresses: Floats
    says: tuple[str, ...]  # kinds of its warnings
    dofs: int


def _answer(result: Result) -> Answer | StressAnswer:
    """Answer of a result: its modes, or its stresses."""
    kinds = tuple(dict.fromkeys(warning.kind for warning in result.warnings))
    if result.spectrum is None:
        sides = [side.sigma_n for both in result.stresses.values() for side in both.values()]
        return StressAnswer(np.concatenate(sides), kinds, result.dofs)
    modes, threshold = result.modes, result.analysis.growth_threshold
    decay = modes.window.min_growth
    return Answer(
        eigenvalues=modes.eigenvalues,
        verdicts=tuple(modes.verdicts(threshold)),
        verdict=modes.verdict(threshold),
        thresholds=modes.thresholds(threshold),
        uncertainties=modes.growth_uncertainties,
        complete=modes.window.complete,
        max_frequency=modes.window.max_frequency,
        residual=float(modes.residuals.max(initial=0.0)),
        condition=float(modes.conditions.max(initial=1.0)),
        warnings=kinds,
        dofs=result.dofs,
        min_growth=-np.inf if decay is None else decay,
    )


Problem = Callable[[float | None], Answer | StressAnswer]
"""Solves a problem up to a frequency (Hz), unless it sets its own; an error if it is refused."""


def of_scene(data: Mapping[str, Any], max_frequency: float | None) -> Answer | StressAnswer:
    """Run a scene given as plain data; check that the result can be stored."""
    result = run_scene(_read(data, max_frequency))
    as_json(result.data)
    return _answer(result)


def _read(given: Mapping[str, Any], max_frequency: float | None) -> Scene:
    """A scene, with the end of its window set if it gives none."""
    data = plain_data(given)
    if data["analysis"]["kind"] == "cea":
        data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
    return read_scene(data)


def of_map(
    data: Mapping[str, Any],
    max_frequency: float | None,
    *,
    axes: Mapping[str, Sequence[float]],
) -> Answer:
    """Solve a scene by a reduced model of full solves at the given values of each parameter."""
    scene = _read(data, max_frequency)
    system = coupled(scene, leave_out=False)[0]
    analysis: Any = scene.analysis
    pencil, top = system.pencil(), analysis.max_frequency
    box = {name: (min(values), max(values)) for name, values in axes.items()}
    built = Enrichment(ReducedModel(pencil, box, top, analysis.min_growth), EigenSolver(pencil))
    built.cover([dict(zip(axes, values, strict=True)) for values in product(*axes.values())])
    found = built.at({}).window
    words = found.words(None)
    complete = all(each["complete"] for each in built.solves)
    return Answer(
        eigenvalues=found.eigenvalues,
        verdicts=tuple(words),
        verdict=classify_run(words, complete=complete),
        thresholds=thresholds(found.eigenvalues),
        uncertainties=found.uncertainties,
        complete=complete,
        max_frequency=top,
        residual=found.bound,
        condition=float(found.conditions.max(initial=1.0)),
        warnings=() if found.bound <= TOLERANCE else ("not-certified",),
        dofs=system.size,
    )


def _write_petsc(file: Path, matrix: csr_array) -> None:
    viewer = PETSc.Viewer().createBinary(str(file), "w", comm=PETSc.COMM_SELF)
    distributed(matrix, matrix.shape, PETSc.COMM_SELF).view(viewer)
    viewer.destroy()


WRITERS: Mapping[str, Callable[[Path, csr_array], None]] = {
    "mat": lambda file, matrix: savemat(file, {"A": matrix}),
    "mtx": lambda file, matrix: mmwrite(file, matrix, precision=17),
    "npz": save_npz,
    "petsc": _write_petsc,
}
"""Functions that write a matrix, by the extension of the file."""


def of_files(
    matrices: Mapping[str, Floats], max_frequency: float | None, *, form: str = "npz"
) -> Answer | StressAnswer:
    """Write matrices M, K and perhaps C, shape (n, n), to files, read and solve them."""
    used = {name: matrix for name, matrix in matrices.items() if matrix.any()}
    with TemporaryDirectory() as folder:
        for name, matrix in used.items():
            WRITERS[form](Path(folder) / f"{name}.{form}", csr_array(matrix))
        scene = read_matrix_scene(
            {
                "name": "files",
                "data": folder,
                "files": {name: f"{name}.{form}" for name in used},
                "mass": {"M": 1.0},
                "damping": {"C": 1.0} if "C" in used else {},
                "stiffness": {"K": 1.0},
                "analysis": {"kind": "cea", "max_frequency": max_frequency or 1.0},
            }
        )
        return _answer(run_matrices(scene))


_CPE8R, _MIDDLE = [0, 6, 8, 2, 3, 7, 5, 1], 4
"""Nodes of a quadratic cell in the order of Abaqus' CPE8R, and its middle node."""


def of_mesh_file(
    data: Mapping[str, Any],
    max_frequency: float | None,
    *,
    unit: Unit = "m",  # of lengths in the deck
    step: int = 1,  # between the numbers of nodes
    geometry: Mapping[str, Any] | None = None,  # fields of every body that differ
    notched: str = "",  # a body without the cells beyond the origin along both axes
) -> Answer | StressAnswer:
    """Write a scene of rectangles of quadratic cells to a deck of Abaqus, read it, and solve."""
    data, text, first = plain_data(data), "", 1
    above, below = METRES[unit]
    with TemporaryDirectory() as folder:
        deck = Path(folder) / "bodies.inp"
        for name, each in data["bodies"].items():
            shape = Rectangle(tuple(each["geometry"]["size"]), tuple(each["geometry"]["origin"]))
            breaks = breaks_of(shape, each["mesh"]["fe"]["elements"])
            mesh = shape_mesh(shape, "quadrilateral", 2, breaks=breaks)
            points, cells, sets = mesh.points, mesh.cells, dict(mesh.surfaces)
            if name == notched:
                cells = cells[points[cells[:, _MIDDLE]].min(axis=1) < 0]
            if f"{name}.corner" in str(data["contacts"]):
                sets["corner"] = np.flatnonzero(points.min(axis=1) == 0)
            numbers = step * (first + np.arange(len(points)))
            nodes = np.column_stack([numbers, points * below / above])
            text += _part(name, nodes, cells[:, _CPE8R], sets)
            first += len(points)
            file = {"shape": "mesh_file", "file": str(deck), "unit": unit, "part": name}
            file["faces"] = {face: f"{name}_{face}" for face in sets}
            each |= {"geometry": file | dict(geometry or {}), "mesh": {}}
        deck.write_text(text)
        return of_scene(data, max_frequency)


def _part(name: str, nodes: Floats, cells: Ints, sets: Mapping[str, Ints]) -> str:
    """A body with the numbers and positions of its nodes, elements and sets of nodes."""
    used, numbers = np.unique(cells), nodes[:, 0].astype(int)
    lines = ["*NODE", *table(nodes[used], "%d,%.17g,%.17g")]
    lines.append(keyword("ELEMENT", TYPE="CPE8R", ELSET=name))
    lines += table(np.column_stack([numbers[: len(cells)], numbers[cells]]), ",".join(["%d"] * 9))
    for face, members in sets.items():
        lines.append(keyword("NSET", NSET=f"{name}_{face}"))
        lines += map(str, numbers[np.intersect1d(members, used)])
    return "\n".join([*lines, ""])
