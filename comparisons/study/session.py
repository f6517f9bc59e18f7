"""Runs of scenes in a study: equal bodies are reused, sizes and times are recorded."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from comparisons.study.shapes import Shapes, by_importance, mode_rows
from scenes import Result, run_scene
from scenes.spec.plain import plain_data
from scenes.spec.reading import Scene

_REMEMBERED = 2  # results whose bodies are reused: cases often alternate between two backends


@dataclass(frozen=True)
class Progress:
    """Callbacks that show the progress of an application."""

    step: Callable[[str], None] = lambda _: None  # called as a step begins
    stage: Callable[[str], None] = lambda _: None  # called for each stage in it


class Session:
    """Second argument of ``evaluate``, which runs scenes and keeps data of the case.

    ``scene`` is the scene of the case, or scenes by name, None if the study has none; ``stage`` is
    called with the name of each stage; ``runs`` are records of the runs of the case, ``arrays`` and
    ``shapes`` the data that it kept.
    """

    def __init__(self, options: Any, stage: Callable[[str], None] = lambda _: None) -> None:
        self.options, self.stage = options, stage
        self._earlier: list[Result] = []
        self.begin(None)

    def begin(self, scene: Any) -> None:
        """Begin a case."""
        self.scene = scene
        self.runs: list[dict[str, Any]] = []
        self.arrays: dict[str, np.ndarray] = {}
        self.shapes = Shapes()

    def solve(self, scene: Scene | None = None, **options: Any) -> Any:
        """Run a scene, that of the case by default, with options of :func:`scenes.run_scene`.

        Bodies of earlier runs are reused if their specifications are equal; the scene of the last
        run is not run again.
        """
        scene = scene or self.scene
        assert scene is not None, "the study gives no scene for its cases"
        if self._earlier and scene == self._earlier[0].scene and not options:
            return self._earlier[0]
        given: dict[str, Any] = {"listener": self.stage}
        for earlier in self._earlier:
            if earlier.scene.bodies == scene.bodies:
                given["bodies"] = earlier.bodies
        result = run_scene(scene, **(given | options))
        kept = [each for each in self._earlier if each.scene.bodies != scene.bodies]
        self._earlier = [result, *kept][:_REMEMBERED]
        self.note(result)
        return result

    def note(self, result: Result) -> None:
        """Record size, times, warnings and omissions of a run; :meth:`solve` calls it."""
        self.runs.append(
            {
                "scene": plain_data(result.scene),
                "dofs": result.dofs,
                "stages": dict(result.timer.seconds),
                "skipped": dict(result.skipped),
                "warnings": [warning.plain() for warning in result.warnings],
            }
        )

    def keep(self, name: str, array: np.ndarray) -> None:
        """Keep an array beside the record."""
        self.arrays[name] = np.asarray(array)

    def keep_modes(
        self, name: str, result: Result, numbers: Sequence[int] | None = None, title: str = ""
    ) -> list[dict[str, Any]]:
        """Keep mode shapes for the viewer of the page; return a row for each mode; collective.

        The shape of mode i is ``name/i``; names are unique among all cases. ``numbers`` are modes
        from 0, most important first, by default all but stable ones; shapes beyond the size limit
        of a page are left out.
        """
        if numbers is None:
            rows = result.table()
            numbers = [i for i in by_importance(result) if rows[i]["verdict"] != "stable"]
        self.shapes.add(name, result, numbers, title)
        return mode_rows(name, result)
