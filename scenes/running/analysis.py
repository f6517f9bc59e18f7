"""Run a scene according to its kind of analysis, and open stored results."""

import json
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from pydantic import ValidationError

from cea.errors import InputError
from cea.timing import StageTimer
from scenes.results.data import RunRecord, opened
from scenes.results.record import read_record
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
"""Modules and functions that run a scene, by ``analysis.kind``; ``matrices`` stands for scenes of
matrices, whose kind is ``cea``."""


def run_scene(scene: "Scene | MatrixScene", **options: Any) -> Result:
    """Run a scene.

    Parameters
    ----------
    scene
        Scene of bodies or of matrices.
    options
        See :class:`scenes.running.system.RunOptions`.

    Raises
    ------
    InputError
        If the memory of the machine does not suffice.
    """
    module, name = ANALYSES[scene.analysis.kind if isinstance(scene, Scene) else "matrices"]
    return cast(Result, getattr(import_module(module), name)(scene, **options))


def open_result(file: str | Path) -> Result:
    """Open the record of a run.

    Parameters
    ----------
    file
        A ``result.json``, compressed if its name ends in ``.gz``.

    Raises
    ------
    InputError
        If the file does not exist or is not the record of a run.
    """
    data = read_record(file)
    try:
        record = RunRecord.model_validate_json(json.dumps(data), strict=True)
    except ValidationError as error:
        first = problems(error, data, {})[0]
        raise InputError("file", str(file), f"a stored result; invalid field {first}") from error
    from scenes.spec.matrices import read_matrix_scene

    read: Any = read_matrix_scene if "files" in record.scene else read_scene
    scene, timer = read(record.scene), StageTimer()
    timer.seconds = record.timings
    return Result(
        scene,
        timer,
        record.skipped,
        record.warnings,
        **opened(record, scene.analysis.kind),
        record=data,
    )
