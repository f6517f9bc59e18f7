"""The kinds of analysis there are, and what each does of running, storing and opening results."""

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from pydantic import ValidationError

from cea.errors import InputError
from cea.timing import StageTimer
from scenes.results.data import Record, RunRecord, checked_record
from scenes.results.record import PROVENANCE, read_record
from scenes.results.result import Analysis, Result
from scenes.spec.problems import problems
from scenes.spec.reading import Scene, read_scene

if TYPE_CHECKING:
    from scenes.spec.matrices import MatrixScene

ANALYSES = {
    "cea": "scenes.running.modes",
    "static": "scenes.running.static",
    "matrices": "scenes.running.matrices",
}
"""Modules by the kind of analysis that they make, ``analysis.kind``; that of a scene of matrices is
named here alone."""


def analysis_of(scene: "Scene | MatrixScene") -> Analysis:
    """What runs a scene; its module is imported."""
    kind = scene.analysis.kind if isinstance(scene, Scene) else "matrices"
    return cast(Analysis, import_module(ANALYSES[kind]))


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
        When bodies or interfaces have other names than those of the scene, or the machine has not
        the memory it takes.
    """
    return analysis_of(scene).run(scene, **options)


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
    if missing:
        raise InputError("file", str(file), f"a stored result; {', '.join(missing)} not in it")
    try:
        return _opened(data)
    except ValidationError as error:
        first = problems(error, data, {})[0]
        raise InputError("file", str(file), f"a stored result; broken at {first}") from error


def _opened(data: dict[str, Any]) -> Result:
    from scenes.spec.matrices import read_matrix_scene

    made = {name: data[name] for name in PROVENANCE}
    stored = {name: value for name, value in data.items() if name not in PROVENANCE}
    if "scene" not in data or not {"eigenvalues", "stresses"} & data.keys():
        made |= checked_record(Record, data)
        return Result(None, None, StageTimer(), {}, provenance=made, stored=stored)
    record = checked_record(RunRecord, data)
    of_matrices = "files" in record.scene
    read: Callable[[Mapping[str, Any]], Any] = read_matrix_scene if of_matrices else read_scene
    scene = read(record.scene)
    timer = StageTimer()
    timer.seconds = record.timings
    kind = analysis_of(scene)
    return Result(
        kind,
        scene,
        timer,
        record.skipped,
        record.warnings,
        **kind.opened(record),
        provenance=made,
        stored=stored,
    )
