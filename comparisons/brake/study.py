"""``ventilated_brake`` on meshes that become finer, and with contacts of other stiffness.

Modes of each mesh are matched with those of the next by their shapes on the contact surfaces and by
eigenvalue; the spread of a mode over the meshes says how far its frequency and its growth rate may
be trusted. Contacts are mortar: Gauss points on quadratic elements are not usable at such a
stiffness (``cea accuracy``), and mortar does not lock where p is larger still.
"""

import resource
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from cea.eigen.mode_matching import ModeMatch
from cea.errors import InputError
from cea.petsc import MPI
from comparisons.kit.progress import Progress
from comparisons.kit.run_warnings import Run, merged_warnings
from scenes.memory import estimated_memory
from scenes.read import Scene, load_scene
from scenes.results import ModesResult
from scenes.run import run_modes
from scenes.run_matching import match_runs
from scenes.stored import record
from scenes.variants import with_contact

COMMAND = "brake"
"""Command that a result is marked with."""

SCENE = "ventilated_brake"

_KILOBYTE = 1024
"""Bytes of the unit in which the system tells the peak of a process."""


@dataclass(frozen=True)
class BrakeStudy:
    """What is run.

    Parameters
    ----------
    sizes
        Target edge lengths of the tetrahedra (m), of disc and pads alike, falling.
    stiffnesses
        Contact stiffnesses p (N/m^3) that are run on the coarsest mesh.
    overrides
        Fields of the scene that differ, as ``--set`` takes them.
    pictures
        Pictures at most of unstable modes, on the finest mesh.

    Raises
    ------
    InputError
        When there is no size, or sizes do not fall.
    """

    sizes: tuple[float, ...] = (0.012, 0.0075, 0.006)
    stiffnesses: tuple[float, ...] = (5e12, 5e13, 5e14)
    overrides: tuple[str, ...] = ()
    pictures: int = 4

    def __post_init__(self) -> None:
        falling = all(a > b > 0 for a, b in zip(self.sizes, self.sizes[1:], strict=False))
        if not self.sizes or not falling or not self.sizes[0] > 0:
            raise InputError("sizes", self.sizes, "one or more positive lengths (m), falling")


def run_brake(study: BrakeStudy, progress: Progress, out: Path) -> Iterator[dict[str, Any]]:
    """Run every mesh, the stiffnesses on the coarsest, and draw what is unstable on the finest.

    Parameters
    ----------
    study
        What is run.
    progress
        Told what is being run.
    out
        Folder for pictures; rank 0 writes them.

    Yields
    ------
    dict
        The record so far after each mesh, so that a finer one that ends in want of memory or time
        leaves the others: ``runs``, one for each mesh, with ``size`` (m), ``p`` (N/m^3), ``dofs``,
        ``seconds``, ``timings``, ``memory`` (bytes) measured and estimated, the evidence of the
        window, and ``modes``; ``matches`` of each mesh with the next; ``stiffnesses``, runs
        likewise, of the coarsest; ``pictures``, names of files, with the last mesh.
    """
    begun = perf_counter()
    runs: list[dict[str, Any]] = []
    told: list[Run] = []
    matches: list[dict[str, Any]] = []
    stiffnesses: list[dict[str, Any]] = []
    coarser: ModesResult | None = None
    for size in study.sizes:
        scene = scene_of_size(size, study.overrides)
        progress.step(f"size {size * 1e3:g} mm")
        result = run_modes(scene, listener=progress.stage)
        runs.append({"size": size, **_described(result)})
        told.append(_told(size, result))
        if coarser is None:
            for again in _with_stiffnesses(result, study.stiffnesses, progress):
                stiffnesses.append(_described(again))
                told += [] if again is result else [_told(size, again)]
        else:
            progress.stage("matching")
            matches.append(_plain(match_runs(coarser, result)))
        last = len(runs) == len(study.sizes)
        data = {
            "runs": list(runs),
            "matches": list(matches),
            "stiffnesses": stiffnesses,
            "pictures": _draw(result, study.pictures, progress, out) if last else [],
        }
        seconds = perf_counter() - begun
        warnings = merged_warnings(told, "runs")
        yield record(COMMAND, data, inputs=asdict(study), seconds=seconds, warnings=warnings)
        coarser = result


def _draw(result: ModesResult, most: int, progress: Progress, out: Path) -> list[str]:
    """Draw unstable modes, so many at most; names of the files."""
    count = min(most, int(result.unstable.sum()))
    if not count:
        return []
    from scenes.pictures import draw_modes  # brings in pyvista

    progress.step("pictures")
    return [picture.name for picture in draw_modes(result, count, out)]


def scene_of_size(size: float, overrides: Iterable[str] = ()) -> Scene:
    """``ventilated_brake`` with tetrahedra of one target edge length (m) in disc and pads."""
    scene = load_scene(Path(SCENE), list(overrides))
    bodies = {}
    for name, body in scene.bodies.items():
        assert body.mesh.fe is not None
        mesh = replace(body.mesh, fe=replace(body.mesh.fe, size=size))
        bodies[name] = replace(body, mesh=mesh)
    return replace(scene, bodies=bodies)


def _with_stiffnesses(
    result: ModesResult, stiffnesses: Iterable[float], progress: Progress
) -> Iterator[ModesResult]:
    """Runs with other contact stiffnesses, on the bodies and contact points of one run."""
    for p in stiffnesses:
        again = result
        if p != _stiffness(result.scene):
            progress.step(f"p = {p:g} N/m^3")
            again = run_modes(
                with_contact(result.scene, p=p),
                bodies=result.bodies,
                interfaces=result.interfaces,
                listener=progress.stage,
            )
        yield again


def _told(size: float, result: ModesResult) -> Run:
    """Which run it is, and what it warns of."""
    point = {"size": size, "p": _stiffness(result.scene)}
    return point, [warning.plain() for warning in result.warnings]


def _stiffness(scene: Scene) -> float | str | None:
    """Contact stiffness p of all contacts (N/m^3), a number or an expression."""
    return next(iter(scene.contacts.values())).p


def _described(result: ModesResult) -> dict[str, Any]:
    """One run as plain data; collective."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _KILOBYTE
    window = result.modes.window
    return {
        "p": _stiffness(result.scene),
        "dofs": result.system.size,
        "seconds": result.timer.total,
        "timings": dict(result.timer.seconds),
        "memory": {
            "measured": result.comm.allreduce(peak, MPI.SUM),
            "estimated": estimated_memory(result.scene).bytes,
        },
        "complete": window.complete,
        "evidence": window.evidence,
        "verdict": result.verdict,
        "warnings": [warning.kind for warning in result.warnings],
        "modes": [
            {
                "frequency": row["frequency"],
                "growth": row["growth_rate"],
                "uncertainty": row["uncertainty"],
                "verdict": row["verdict"],
            }
            for row in result.table()
        ],
    }


def _plain(match: ModeMatch) -> dict[str, Any]:
    """Modes of two runs that stand for one another, as numbers from 0."""
    return {
        "groups": [
            {
                "first": group.first.tolist(),
                "second": group.second.tolist(),
                "assurance": group.assurance,
            }
            for group in match.groups
        ],
        "only_first": match.only_first.tolist(),
        "only_second": match.only_second.tolist(),
    }
