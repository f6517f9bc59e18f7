"""CalculiX and this program on the same meshes: each body alone, and both in frictional contact.

The meshes are straight tetrahedra of ten nodes, exported by :mod:`scenes.export.decks`. CalculiX
integrates their mass with the four points of the stiffness, which is not exact; this program is run
both with that mass, to compare what is the same, and with the exact one, to tell what that costs.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.contact.formulations import Segments
from cea.eigen.classify import classify, thresholds
from cea.errors import InputError
from cea.petsc import MPI
from comparisons.kit.progress import Progress
from comparisons.peers import calculix
from comparisons.peers.measured import Measured, run_measured
from scenes.export.decks.bodies import deck_bodies
from scenes.export.decks.write import write_deck
from scenes.results.record import read_record, record, write_record
from scenes.spec.mesh import FeMesh, MeshSpec
from scenes.spec.plain import as_data
from scenes.spec.reading import Scene, load_scene
from scenes.spec.scene import with_contact

COMMAND = "peers"
STORED = Path(__file__).parent / "results"
"""Folder of the results that come with the project."""
MASS_QUADRATURE = 2
"""Degree to which four points integrate over a tetrahedron: the mass of CalculiX."""
MODES = 20
_WIDER = 1.01
"""Window of this program over the last frequency of CalculiX."""
_RIGID = 1e-6
"""Modes with abs(lambda) below this part of the largest are rigid, and zero but for rounding."""


@dataclass(frozen=True)
class PeersStudy:
    """What is run.

    Parameters
    ----------
    scene
        Name of the scene.
    meshes
        Boxes along each direction of each body, six tetrahedra each; a mesh after another.
    repeats
        Runs of each program; medians of their times count.
    """

    scene: str = "disc_pad"
    meshes: tuple[Mapping[str, tuple[int, ...]], ...] = (
        {"pad": (3, 5, 2), "disc": (5, 36, 1)},
        {"pad": (4, 8, 3), "disc": (7, 56, 2)},
    )
    repeats: int = 3

    def __post_init__(self) -> None:
        if self.repeats < 1:
            raise InputError("repeats", self.repeats, "1 or more")


QUICK = PeersStudy(meshes=({"pad": (2, 3, 1), "disc": (3, 16, 1)},), repeats=1)
"""A mesh that takes seconds."""


def run_peers(study: PeersStudy, progress: Progress) -> dict[str, Any]:
    """Run both programs.

    Returns
    -------
    dict
        The record: ``calculix``, its version; ``problems``, each with the numbers of both programs.

    Raises
    ------
    InputError
        When CalculiX is not installed, or on several ranks.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("ranks", MPI.COMM_WORLD.size, "1: the other program runs on one")
    begun, version = perf_counter(), calculix.version()
    problems = []
    for number, mesh in enumerate(study.meshes):
        whole = exported(load_scene(study.scene, backend="fe"), mesh)
        alone = [_alone(whole, name) for name in whole.bodies]
        for scene in (*alone, whole):
            progress.step(f"{scene.name}, mesh {number + 1} of {len(study.meshes)}")
            problems.append({"mesh": number + 1, **compared(scene, study.repeats, progress)})
    inputs = {
        "scene": study.scene,
        "meshes": [dict(mesh) for mesh in study.meshes],
        "repeats": study.repeats,
    }
    data = {"calculix": version, "problems": problems}
    return record(COMMAND, data, inputs=inputs, seconds=perf_counter() - begun)


def exported(scene: Scene, mesh: Mapping[str, tuple[int, ...]]) -> Scene:
    """A scene on straight quadratic tetrahedra, its contacts integrated exactly."""
    bodies = {
        name: replace(
            body,
            mesh=MeshSpec(fe=FeMesh("tetrahedron", 2, geometry_degree=1, elements=mesh[name])),
        )
        for name, body in scene.bodies.items()
    }
    return with_contact(replace(scene, bodies=bodies), formulation=Segments())


def _alone(scene: Scene, name: str) -> Scene:
    return replace(scene, name=name, bodies={name: scene.bodies[name]}, contacts={})


def compared(scene: Scene, repeats: int, progress: Progress) -> dict[str, Any]:
    """One scene on both programs, plain data."""
    with TemporaryDirectory() as folder:
        deck = write_deck(scene, Path(folder), MODES)[1]
        runs = []
        for _ in range(repeats):
            progress.stage("CalculiX")
            runs.append(calculix.run(deck))
        theirs = runs[0].eigenvalues
        top = _WIDER * float(theirs[-1].imag) / (2 * np.pi)
        assert scene.analysis.kind == "cea"
        wide = replace(scene, analysis=replace(scene.analysis, max_frequency=top))
        progress.stage("this program")
        same = [_ours(wide, MASS_QUADRATURE, Path(folder)) for _ in range(repeats)]
        exact, _ = _ours(wide, None, Path(folder))
    return {
        "name": scene.name,
        "dofs": same[0][0]["dofs"],
        "contact": bool(scene.contacts),
        "area": _area(scene, runs[0].area),
        "modes": _modes(theirs, _eigenvalues(same[0][0]), _eigenvalues(exact)),
        "unstable": {
            "CalculiX": _unstable(theirs),
            "this program": _unstable(_eigenvalues(same[0][0])[: len(theirs)]),
            "exact mass": _unstable(_eigenvalues(exact)[: len(theirs)]),
        },
        "runs": [
            _times("CalculiX", [r.measured for r in runs], [r.seconds for r in runs]),
            _times(
                "this program",
                [measured for _, measured in same],
                [sum(answer["timings"].values()) for answer, _ in same],
            ),
        ],
    }


def _ours(scene: Scene, quadrature: int | None, folder: Path) -> tuple[dict[str, Any], Measured]:
    """Answer of this program in a process of its own, and what that took."""
    file = folder / "question.json"
    write_record({"scene": as_data(scene), "mass_quadrature": quadrature}, file)
    command = [sys.executable, "-m", "comparisons.peers.own", str(file)]
    measured = run_measured(command, folder, "own.log")
    return read_record(file), measured


def _eigenvalues(answer: Mapping[str, Any]) -> Complexes:
    values = np.array([complex(*pair) for pair in answer["eigenvalues"]], dtype=complex)
    return values[np.lexsort((values.real, values.imag))]


def _modes(theirs: Complexes, same: Complexes, exact: Complexes) -> list[dict[str, Any]]:
    """Modes of CalculiX by rising frequency, beside those of the same rank of this program."""
    count = min(len(theirs), len(same), len(exact))
    return [
        {
            "frequency": float(a.imag / (2 * np.pi)),
            "growth": float(a.real),
            "ours": float(b.imag / (2 * np.pi)),
            "our_growth": float(b.real),
            "exact_mass": float(c.imag / (2 * np.pi)),
            "exact_mass_growth": float(c.real),
        }
        for a, b, c in zip(theirs[:count], same[:count], exact[:count], strict=True)
    ]


def _unstable(values: Complexes) -> list[dict[str, float]]:
    """Modes that grow."""
    rigid = np.abs(values) <= _RIGID * np.abs(values).max(initial=0.0)
    words = classify(values.real, 0.0, thresholds(values), False, rigid)
    return [
        {"frequency": float(v.imag / (2 * np.pi)), "growth": float(v.real)}
        for v, word in zip(values, words, strict=True)
        if word == "unstable"
    ]


def _area(scene: Scene, found: float | None) -> dict[str, float] | None:
    """Area of side a as meshed, and that over which CalculiX integrated; of one contact."""
    if found is None or len(scene.contacts) != 1:
        return None
    (contact,) = scene.contacts.values()
    body, surface = contact.a.split(".")
    return {"meshed": deck_bodies(scene)[body].area_of(surface), "CalculiX": found}


def _times(name: str, runs: list[Measured], solver: list[float]) -> dict[str, Any]:
    return {
        "program": name,
        "clock": median(run.clock for run in runs),
        "processor": median(run.processor for run in runs),
        "solver": median(solver),
        "memory": max(run.memory for run in runs),
    }
