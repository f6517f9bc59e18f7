"""The record of a study: modes, meshes with their errors, why each backend ended, warnings."""

from collections.abc import Mapping
from math import isfinite, tau
from typing import Any

import numpy as np

from cea.eigen.eigenvalue_matching import assign
from comparisons.converge.combined import Mode
from comparisons.converge.course import Course
from comparisons.converge.following import lost
from comparisons.converge.levels import Level, elements_of
from comparisons.converge.request import Request, half_unit
from comparisons.converge.steps import Step
from comparisons.kit.run_warnings import Run, merged_warnings
from scenes.following import STATE_KEPT
from scenes.read import Scene
from scenes.refinement import moved_to_mortar, refined
from scenes.scene_toml import scene_text
from scenes.spec.body import Backend

_REACH = 0.1
"""Relative distance at which an eigenvalue of a mesh no longer stands for a final one."""
_MORE = 10.0
"""Factor between errors of one digit and of the next."""


def data_of(
    courses: Mapping[Backend, Course], modes: list[Mode], request: Request, scene: Scene
) -> dict[str, Any]:
    """What the record of a study holds, as :func:`comparisons.converge.study.run_converge` says."""
    moving = [mode.member for mode in modes if not mode.member.rigid]
    final = np.array([member.value for member in moving], complex)
    bars = np.array([np.hypot(member.frequency_bar, member.growth_bar) for member in moving])
    levels = []
    for course in courses.values():
        levels += [(level, errors_of(level, final, bars)) for level in course.levels]
    for_sweeps = _cheapest(levels, half_unit(request.sweep_digits))
    scenes = {f"finest_{b}": c.sequence.last for b, c in courses.items() if c.sequence.levels}
    if for_sweeps is not None:
        scenes["for_sweeps"] = for_sweeps
    assert scene.analysis.kind == "cea"
    return {
        "modes": [mode.plain() for mode in modes],
        "levels": [level.plain() | errors for level, errors in levels],
        "backends": {backend: _told(course) for backend, course in courses.items()},
        "lost": [
            {"backend": course.backend, "frequency": value.imag / tau, "growth": value.real}
            for course in courses.values()
            for value in lost(course.sequence, highest_of(scene) * tau)
        ],
        "mortar": moved_to_mortar(scene),
        "scenes": {name: scene_text(level.scene) for name, level in scenes.items()},
        "max_frequency": highest_of(scene),
        "growth_threshold": scene.analysis.growth_threshold,
    }


def highest_of(scene: Scene) -> float:
    """Upper end of the window (Hz)."""
    assert scene.analysis.kind == "cea"
    return scene.analysis.max_frequency


def errors_of(level: Level, final: np.ndarray, bars: np.ndarray) -> dict[str, Any]:
    """Distance of a mesh's eigenvalues from the final ones but zeros, relative to abs(lambda).

    ``bound`` is the worst of them with the bars of the final ones; None where one has no bar.
    """
    values = level.eigenvalues
    if not len(final) or not len(values):
        return {"worst": None, "bound": None, "median": None, "missing": len(final)}
    distance = np.abs(values[None, :] - final[:, None]) / np.abs(final)[:, None]
    rows, columns = assign(distance, _REACH)
    errors = distance[rows, columns]
    missing = len(final) - len(rows)
    worst, bound = float(errors.max(initial=0.0)), np.inf
    if not missing:
        bound = float((errors + bars[rows] / np.abs(final[rows])).max(initial=0.0))
    return {
        "worst": worst if not missing else None,
        "bound": bound if isfinite(bound) else None,
        "median": float(np.median(errors)) if len(errors) else None,
        "missing": missing,
    }


def _cheapest(levels: list[tuple[Level, dict[str, Any]]], tolerance: float) -> Level | None:
    """The mesh tried that takes least time of those that are within a tolerance, bars included."""
    enough = [
        level
        for level, e in levels
        if e["bound"] is not None and e["bound"] <= tolerance and not level.corrected
    ]
    return min(enough, key=lambda level: level.seconds, default=None)


def _told(course: Course) -> dict[str, Any]:
    """Why a backend ended, what its bars need, what a digit more would cost."""
    if not course.sequence.levels:
        return {
            "ended": course.ended,
            "held": False,
            "need": None,
            "more": None,
            "rate": None,
            "owed": [],
        }
    need = course.need
    more = course.cost_of(max(need, 1.0) * _MORE) if isfinite(need) else None
    return {
        "ended": course.ended,
        "held": course.holds,
        "need": need if isfinite(need) else None,
        "rate": course.judged.window.rate,
        "owed": _owed(course),
        "more": None if more is None else _more(course, more),
    }


def _owed(course: Course) -> list[dict[str, Any]]:
    """What each body and direction was measured to owe to the errors of a mesh."""
    parts = course.sequence.parts
    if parts is None:
        return []
    usual = parts.of_mean(None)
    each = [parts.of_mean(np.array([i])) for i in np.flatnonzero(parts.known)]
    worst = np.max(each, axis=0) if each else usual
    bodies = course.scene.bodies
    return [
        {
            "body": part.body,
            "directions": [bodies[part.body].geometry.directions[d] for d in part.directions],
            "edges": part.edges,
            "median": float(median),
            "worst": float(most),
        }
        for part, median, most in zip(parts.parts, usual, worst, strict=True)
    ]


def _more(course: Course, step: Step) -> dict[str, Any]:
    """A mesh that would give more, with its time."""
    scene = refined(course.scene, course.backend, step.resolution)
    return {
        "seconds": step.seconds,
        **step.resolution.plain(),
        "elements": elements_of(scene),
    }


def warnings_of(
    courses: Mapping[Backend, Course], modes: list[Mode], scene: Scene
) -> list[dict[str, Any]]:
    """What the result must be read with."""
    found = []
    apart = [mode for mode in modes if mode.agree is False]
    if apart:
        found.append(
            {
                "kind": "backends-disagree",
                "message": f"the backends differ by more than their bars in {len(apart)} modes",
                "data": {"frequencies": [m.member.value.imag / tau for m in apart]},
            }
        )
    both = sum(1 for course in courses.values() if course.sequence.levels) > 1
    alone = [mode for mode in modes if both and len(mode.members) == 1]
    if alone:
        found.append(
            {
                "kind": "modes-alone",
                "message": f"{len(alone)} modes were found by one backend only",
                "data": {"frequencies": [m.member.value.imag / tau for m in alone]},
            }
        )
    for course in courses.values():
        if not course.holds:
            found.append(
                {
                    "kind": "digits-not-held",
                    "message": f"{course.backend}: {course.ended}",
                    "data": {"backend": course.backend},
                }
            )
    if missing := lost_of(courses, scene):
        found.append(
            {
                "kind": "modes-lost",
                "message": f"{missing} modes of a mesh are not among those of the next",
                "data": {"count": missing},
            }
        )
    return found + _of_newest_meshes(courses)


def _of_newest_meshes(courses: Mapping[Backend, Course]) -> list[dict[str, Any]]:
    """Warnings of the runs on the newest meshes, merged; derivatives are not told."""
    newest = {b: course.sequence.last for b, course in courses.items() if course.sequence.levels}
    runs: list[Run] = [
        ({"backend": backend}, [w.plain() for w in level.warnings if w.kind != STATE_KEPT])
        for backend, level in newest.items()
    ]
    return merged_warnings(runs, "backends, on its newest mesh")


def lost_of(courses: Mapping[Backend, Course], scene: Scene) -> int:
    """Number of modes that the newest meshes do not have and those before had."""
    return sum(len(lost(course.sequence, highest_of(scene) * tau)) for course in courses.values())
