"""The record of a study: what is held, the words of the run, modes, meshes, warnings."""

from collections.abc import Mapping, Sequence
from math import floor, isfinite, log10, tau
from typing import Any

import numpy as np

from cea.eigen.classify import classify_run, counted_words
from cea.eigen.matching import assign
from cea.eigen.spectrum import Window
from comparisons.converge.combine import Mode
from comparisons.converge.course import Course
from comparisons.converge.ladder import Mesh, elements_of, window_of
from comparisons.converge.request import Request, half_unit
from comparisons.kit.run_warnings import Run, merged_warnings
from scenes.checking.steady import STATE_KEPT
from scenes.refinement.meshes import moved_to_mortar
from scenes.spec.body import Backend
from scenes.spec.reading import Scene
from scenes.spec.toml import scene_text


def data_of(
    courses: Mapping[Backend, Course], modes: list[Mode], request: Request, scene: Scene
) -> dict[str, Any]:
    """What the record of a study holds, as :func:`comparisons.converge.study.run_converge` says."""
    window = window_of(scene)
    top, threshold = window.max_frequency, window.growth_threshold
    inside = [mode for mode in modes if mode.frequency <= top]
    above = [mode for mode in modes if mode.frequency > top]
    ran = {b: course for b, course in courses.items() if course.followed.meshes}
    finest = {b: course.followed.meshes[-1] for b, course in ran.items()}
    errors = [
        (mesh, {"backend": backend, **_level(mesh), **_errors(mesh, inside)})
        for backend, course in ran.items()
        for mesh in course.followed.meshes
    ]
    held, first = _held(inside, courses, request, threshold)
    scenes = {f"finest_{backend}": mesh.scene for backend, mesh in finest.items()}
    tolerance = half_unit(request.sweep_digits)
    enough = [(m, e) for m, e in errors if e["bound"] is not None and e["bound"] <= tolerance]
    if enough:
        scenes["for_sweeps"] = min(enough, key=lambda each: each[0].dofs)[0].scene
    return {
        "first": first,
        "max_frequency": top,
        "growth_threshold": threshold,
        "held": held,
        "words": _words(inside, above, [mesh.window for mesh in finest.values()], threshold, top),
        "hints": _hints(above),
        "modes": [mode.plain() for mode in inside],
        "levels": [plain for _, plain in errors],
        "backends": {b: {"ended": c.ended, "spent": c.spent} for b, c in courses.items()},
        "mortar": moved_to_mortar(scene),
        "scenes": {name: scene_text(each) for name, each in scenes.items()},
        "warnings": _warnings(ran, finest, inside, top),
    }


def _held(
    modes: list[Mode],
    courses: Mapping[Backend, Course],
    request: Request,
    threshold: float | None,
) -> tuple[bool, str]:
    """Whether all digits are held, and the line that says it."""
    asked = [mode.shortfalls(request, threshold) for mode in modes]
    of_frequency = [f <= 1 for f, _ in asked]
    of_growth = [g <= 1 for mode, (_, g) in zip(modes, asked, strict=True) if g > 0]
    line = (
        f"{_digits(request.digits)} of frequency held in {sum(of_frequency)} of {len(modes)} modes"
    )
    if of_growth:
        line += f", {request.of_growth} of growth in {sum(of_growth)} of {len(of_growth)}"
    ran = any(course.followed.meshes for course in courses.values())
    short = [
        f"{name} of {mode.frequency:.6g} Hz ({_digits(max(0, digits))})"
        for mode, both in zip(modes, asked, strict=True)
        for name, shortfall, wanted in zip(
            ("frequency", "growth"), both, (request.digits, request.of_growth), strict=True
        )
        if shortfall > 1
        for digits in [floor(wanted - log10(shortfall)) if isfinite(shortfall) else 0]
    ]
    ended = [f"{b}: {course.ended}" for b, course in courses.items() if course.ended]
    if not ran:
        return False, f"not reached: no mesh was solved; {'; '.join(ended)}"
    if short:
        more = f" and {len(short) - 3} more" if len(short) > 3 else ""
        line += f"; not reached: {', '.join(short[:3])}{more}; {'; '.join(ended)}"
    return not short, line


def _digits(count: int) -> str:
    return f"{count} digit{'s' * (count != 1)}"


def _words(
    modes: list[Mode],
    above: list[Mode],
    windows: Sequence[Window],
    threshold: float | None,
    top: float,
) -> str:
    """How many modes have which word and the word of the run, as one run says it."""
    end = f"{top:g} Hz"
    if not modes:
        lowest = [w.lowest for w in windows if w.lowest is not None]
        lowest = [min(mode.frequency for mode in above)] if above else lowest
        near = f"; the lowest is near {min(lowest):.5g} Hz" if lowest else ""
        return f"no modes below {end}{near}"
    words = [mode.word for mode in modes]
    counts = counted_words(words, [mode.estimated.value.real for mode in modes], threshold)
    word = classify_run(
        words,
        complete=any(window.complete for window in windows),
        missing=any(window.missing for window in windows),
    )
    line = f"{len(modes)} mode{'s' * (len(modes) > 1)} up to {end}: {counts}; verdict: {word}"
    if word == "no unstable mode found":
        most = max(window.max_growth for window in windows)
        line += f" up to a growth rate of {most:.4g} 1/s"
    return line


def _hints(above: list[Mode]) -> list[str]:
    """Modes that grow beyond their bars up to 5 per cent above the window."""
    grow = [mode for mode in above if mode.word in ("unstable", "grows slowly")]
    if not grow:
        return []
    modes = "a mode grows" if len(grow) == 1 else f"{len(grow)} modes grow"
    told = ", ".join(
        f"{mode.estimated.value.real:+.3g} 1/s at {mode.frequency:.6g} Hz" for mode in grow
    )
    return [f"hint: {modes} just above the end of the window: {told}"]


def _level(mesh: Mesh) -> dict[str, Any]:
    return {
        **mesh.resolution.plain(),
        "elements": elements_of(mesh.scene),
        "dofs": mesh.dofs,
        "seconds": mesh.seconds,
        "corrected": mesh.corrected is not None,
    }


def _errors(mesh: Mesh, modes: list[Mode]) -> dict[str, Any]:
    """Worst distance of a mesh's eigenvalues from the final ones, relative to abs(lambda).

    ``bound`` is the worst of them with the bars of the final ones; None where one has no bar.
    """
    moving = [mode.estimated for mode in modes if not mode.rigid]
    final = np.array([own.value for own in moving], complex)
    if not len(final) or len(mesh.eigenvalues) < len(final):
        return {"worst": None, "bound": None}
    bars = np.array([np.hypot(own.frequency_bar, own.growth_bar) for own in moving])
    distance = np.abs(mesh.eigenvalues[None, :] - final[:, None])
    apart = distance[assign(distance / np.abs(final)[:, None])]
    bound = float(((apart + bars) / np.abs(final)).max())
    worst = float((apart / np.abs(final)).max())
    return {"worst": worst, "bound": bound if isfinite(bound) else None}


def _warnings(
    ran: Mapping[Backend, Course], finest: Mapping[Backend, Mesh], modes: list[Mode], top: float
) -> list[dict[str, Any]]:
    """What the result must be read with; what runs warn of is that of the finest meshes."""
    lost = [v for c in ran.values() for v in c.followed.lost.tolist() if v.imag <= tau * top]
    kinds = {
        "backends-disagree": (
            "bars of the backends do not meet, and are widened, in",
            [mode.frequency for mode in modes if mode.agree is False],
        ),
        "modes-alone": (
            "one backend alone found",
            [mode.frequency for mode in modes if len(ran) > 1 and mode.agree is None],
        ),
        "not-converging": (
            "differences between meshes do not fall in",
            [mode.frequency for mode in modes if not mode.estimated.converges],
        ),
        "one-estimate": (
            "bars are twice the change in a richer space alone in",
            [m.frequency for m in modes if m.estimated.estimates < 2 and not m.rigid],
        ),
        "modes-lost": (
            "the finest mesh lacks, of those of the mesh before,",
            [value.imag / tau for value in lost],
        ),
    }
    found = [
        {
            "kind": kind,
            "message": f"{text} {len(where)} mode{'s' * (len(where) > 1)}",
            "data": {"frequencies": where},
        }
        for kind, (text, where) in kinds.items()
        if where
    ]
    runs: list[Run] = [
        ({"backend": backend}, [w.plain() for w in mesh.warnings if w.kind != STATE_KEPT])
        for backend, mesh in finest.items()
    ]
    return found + merged_warnings(runs, "backends, on its newest mesh")
