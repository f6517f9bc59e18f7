"""Scenes run by their kind of analysis, and results opened again."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from pydantic import ValidationError

from cea.errors import InputError, require
from cea.timing import StageTimer
from scenes.results.data import Record, RunRecord, checked_record, opened
from scenes.results.record import PROVENANCE, read_record
from scenes.results.result import Result
from scenes.spec.problems import problems
from scenes.spec.reading import Scene, read_scene

if TYPE_CHECKING:
    from scenes.spec.matrices import MatrixScene

ANALYSES = {
    "cea": ("scenes.running.modes", "run_modes"),
    "static": ("scenes.running.static", "run_static"),
    "matrices": ("scenes.running.matrices", "run_matrices"),
}
"""Modules and functions that run a scene, by ``analysis.kind``; a scene of matrices is named here
alone."""


def run_scene(scene: "Scene | MatrixScene", **options: Any) -> Result:
    """Run a scene.

    Parameters
    ----------
    scene
        The scene.
    options
        See :class:`scenes.running.system.RunOptions`.

    Raises
    ------
    InputError
        When the machine has not the memory it takes.
    """
    module, name = ANALYSES[scene.analysis.kind if isinstance(scene, Scene) else "matrices"]
    return cast(Result, getattr(import_module(module), name)(scene, **options))


def open_result(file: str | Path) -> Result:
    """Open what a command stored.

    Parameters
    ----------
    file
        A ``result.json``, or any other record of a command; compressed where it ends in ``.gz``.

    Returns
    -------
    Result
        Of a run with its eigenvalues or stresses; of any other command with ``data`` alone.

    Raises
    ------
    InputError
        When there is no such file, or it is no record.
    """
    data = read_record(file)
    missing = [name for name in PROVENANCE if name not in data]
    allowed = f"a stored result; {', '.join(missing)} not in it"
    require(not missing, "file", str(file), allowed)
    made = {name: data[name] for name in PROVENANCE}
    stored = {name: value for name, value in data.items() if name not in PROVENANCE}
    timer, of_run = StageTimer(), "scene" in data and {"eigenvalues", "stresses"} & data.keys()
    try:
        if not of_run:
            made |= checked_record(Record, data)
            return Result(None, timer, {}, provenance=made, stored=stored)
        record = checked_record(RunRecord, data)
    except ValidationError as error:
        first = problems(error, data, {})[0]
        raise InputError("file", str(file), f"a stored result; broken at {first}") from error
    from scenes.spec.matrices import read_matrix_scene

    read: Any = read_matrix_scene if "files" in record.scene else read_scene
    scene, timer.seconds = read(record.scene), record.timings
    return Result(
        scene,
        timer,
        record.skipped,
        record.warnings,
        **opened(record, scene.analysis.kind),
        provenance=made,
        stored=stored,
    )
