"""The record of a study: digits reached, classification, modes, meshes, warnings."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from math import floor, inf, log10, tau
from typing import Any

import numpy as np

from cea.eigen.classify import GROWING
from cea.eigen.matching import assign
from cea.eigen.spectrum import Window
from comparisons.converge.combine import Mode
from comparisons.converge.follow import Followed
from comparisons.converge.ladder import Mesh, elements_of
from comparisons.converge.request import Request, half_unit
from comparisons.study.numbers import counted
from comparisons.study.run_warnings import Run, merged_warnings
from scenes.running.run import STATE_KEPT
from scenes.spec.body import Backend
from scenes.spec.plain import scene_text
from scenes.spec.reading import Scene
from scenes.spec.refinement import moved_to_mortar


def data_of(
    followed: Mapping[Backend, Followed],
    ended: Mapping[Backend, str],
    modes: list[Mode],
    request: Request,
    scene: Scene,
) -> dict[str, Any]:
    """Return the data of the record (:func:`comparisons.converge.study.run_converge`)."""
    window = scene.window
    top, threshold = window.max_frequency, window.growth_threshold
    inside = [mode for mode in modes if mode.frequency <= top]
    above = [mode for mode in modes if mode.frequency > top]
    finest = {backend: each.meshes[-1] for backend, each in followed.items()}
    scenes = {f"finest_{backend}": mesh.scene for backend, mesh in finest.items()}
    levels, least = list[dict[str, Any]](), inf
    for backend, each in followed.items():
        for mesh in each.meshes:
            levels.append(_level(mesh, backend, inside))
            bound = levels[-1]["bound"]
            enough = bound is not None and bound <= half_unit(request.sweep_digits)
            if enough and mesh.dofs < least:
                least, scenes["for_sweeps"] = mesh.dofs, mesh.scene
    held, first = False, f"not reached: no mesh was solved; {_reasons(ended)}"
    words, hints = "", list[str]()
    if finest:
        held, first = _held(inside, ended, request, threshold)
        searched = _window(inside, above, [mesh.window for mesh in finest.values()], top)
        growth = [mode.estimated.value.real for mode in inside]
        words = searched.headline([mode.word for mode in inside], growth, threshold)
        hints = searched.hints
    return {
        "first": first,
        "max_frequency": top,
        "growth_threshold": threshold,
        "held": held,
        "words": words,
        "hints": hints,
        "modes": [mode.plain() for mode in inside],
        "levels": levels,
        "ended": dict(ended),
        "mortar": moved_to_mortar(scene),
        "scenes": {name: scene_text(each) for name, each in scenes.items()},
        "warnings": _warnings(followed, ended if held else {}, inside, top),
    }


def _held(
    modes: list[Mode],
    ended: Mapping[Backend, str],
    request: Request,
    threshold: float | None,
) -> tuple[bool, str]:
    """Return whether all digits are reached, and a line that states it."""
    wanted = {"frequency": request.digits, "growth": request.of_growth}
    asked = [mode.shortfalls(request, threshold) for mode in modes]
    growths = [growth for _, growth in asked if growth > 0]
    reached = sum(frequency <= 1 for frequency, _ in asked)
    line = f"{counted(request.digits, 'digit')} of frequency in {reached} of {len(modes)} modes"
    if growths:
        reached = sum(growth <= 1 for growth in growths)
        line += f", {request.of_growth} of growth in {reached} of {len(growths)}"
    short = []
    for mode, shortfalls in zip(modes, asked, strict=True):
        for (name, digits), shortfall in zip(wanted.items(), shortfalls, strict=True):
            if shortfall > 1:
                own = counted(max(0, floor(digits - log10(shortfall))), "digit")
                short.append(f"{name} of {mode.frequency:.6g} Hz ({own})")
    if short:
        more = f" and {len(short) - 3} more" if len(short) > 3 else ""
        line += f"; not reached: {', '.join(short[:3])}{more}; {_reasons(ended)}"
    return not short, line


def _reasons(ended: Mapping[Backend, str]) -> str:
    return "; ".join(f"{backend}: {reason}" for backend, reason in ended.items() if reason)


def _window(inside: list[Mode], above: list[Mode], windows: list[Window], top: float) -> Window:
    """Return the window up to ``top``, with a mode missing if any has, else complete if any is.

    Meshes were searched to 5 per cent above it: growing modes there and the lowest one are listed.
    """
    window = min(windows, key=lambda each: (not each.missing, not each.complete))
    grow = tuple((m.frequency, m.estimated.value.real) for m in above if m.word in GROWING)
    lowest = min([mode.frequency for mode in above], default=window.lowest)
    return replace(window, max_frequency=top, growing_above=grow, lowest=lowest)


def _level(mesh: Mesh, backend: Backend, modes: list[Mode]) -> dict[str, Any]:
    """Return size and time of a mesh, and ``worst``: its largest error relative to abs(lambda).

    The error is the distance from the final eigenvalue; ``bound`` adds the bar of the latter.
    """
    row = {
        "backend": backend,
        **asdict(mesh.resolution),
        "elements": elements_of(mesh.scene),
        "dofs": mesh.dofs,
        "seconds": mesh.seconds,
    }
    moving = [mode.estimated for mode in modes if not mode.rigid]
    final = np.array([own.value for own in moving], complex)
    if not len(final) or len(mesh.eigenvalues) < len(final):
        return row | {"worst": None, "bound": None}
    bars = np.array([np.hypot(own.frequency_bar, own.growth_bar) for own in moving])
    distance = np.abs(mesh.eigenvalues[None, :] - final[:, None])
    apart = distance[assign(distance / np.abs(final)[:, None])]
    bound = float(((apart + bars) / np.abs(final)).max())
    worst = float((apart / np.abs(final)).max())
    return row | {"worst": worst, "bound": bound}


def _warnings(
    followed: Mapping[Backend, Followed],
    ended: Mapping[Backend, str],
    modes: list[Mode],
    top: float,
) -> list[dict[str, Any]]:
    """Return warnings about bars and modes, and those of the runs on the finest meshes."""
    found = [
        {"kind": "backend-ended", "message": f"{backend}: {reason}", "data": {"backend": backend}}
        for backend, reason in ended.items()
        if reason
    ]
    lost = [v for each in followed.values() for v in each.lost.tolist() if v.imag <= tau * top]
    kinds = {
        "backends-disagree": (
            "bars of the two backends do not overlap and were widened in",
            [mode.frequency for mode in modes if mode.agree is False],
        ),
        "modes-alone": (
            "only one backend found",
            [mode.frequency for mode in modes if len(followed) > 1 and mode.agree is None],
        ),
        "not-converging": (
            "differences between meshes do not decrease in",
            [mode.frequency for mode in modes if not mode.estimated.converges],
        ),
        "one-estimate": (
            "bars are based on a single estimate, the change in a richer space, in",
            [m.frequency for m in modes if m.estimated.estimates < 2 and not m.rigid],
        ),
        "modes-lost": (
            "the finest mesh lost, of the modes of the mesh before,",
            [value.imag / tau for value in lost],
        ),
    }
    found += [
        {
            "kind": kind,
            "message": f"{text} {counted(len(where), 'mode')}",
            "data": {"frequencies": where},
        }
        for kind, (text, where) in kinds.items()
        if where
    ]
    runs: list[Run] = [
        ({"backend": b}, [w.plain() for w in each.meshes[-1].warnings if w.kind != STATE_KEPT])
        for b, each in followed.items()
    ]
    return found + merged_warnings(runs, "backends, on its newest mesh")
