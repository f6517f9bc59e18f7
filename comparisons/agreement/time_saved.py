"""What leaving out friction saves: processor time of two kinds of runs, and what of it is noise.

Runs alternate, lean and full, then full and lean, so that a machine that grows busier or cooler
favours neither. Successive runs of one kind tell how far apart equal runs are.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cea.timing import STAGES
from comparisons.kit.progress import Progress
from scenes.read import load_scene
from scenes.run import run_scene
from scenes.variants import on_backend, with_contact

PAIRS = 8
"""Pairs of a lean and a full run."""

_MESHES = (
    "bodies.pad.mesh.fe.elements=[4,6,2]",
    "bodies.disc.mesh.fe.elements=[7,32,2]",
)
"""Coarser than the scene's: more runs in the same time."""


def time_saved(progress: Progress) -> dict[str, Any]:
    """One scene without friction: solved as it is, and as if friction could not be left out.

    Both kinds of runs use the same bodies, whose meshes and matrices are not timed: friction has no
    part in them.

    Returns
    -------
    dict
        Plain data: ``scene`` in words, ``dofs``, ``skipped``, and what :func:`compared` gives of
        the processor seconds.
    """
    scene = with_contact(on_backend(load_scene(Path("disc_pad"), _MESHES), "fe"), mu=0.0)
    progress.step("disc and pad without friction, bodies")
    first = run_scene(scene, listener=progress.stage)
    runs: list[tuple[str, dict[str, float]]] = []
    for pair in range(PAIRS):
        progress.step(f"disc and pad without friction, lean and in full, {pair + 1} of {PAIRS}")
        for kind in ("lean", "full") if pair % 2 == 0 else ("full", "lean"):
            result = run_scene(
                scene,
                bodies=first.system.bodies,
                leave_out=kind == "lean",
                listener=progress.stage,
            )
            runs.append((kind, dict(result.timer.processor_seconds)))
    return {
        "scene": "disc and pad, finite elements, coarse meshes, μ = 0",
        "dofs": first.system.size,
        "skipped": dict(first.skipped),
        **compared(runs),
    }


def compared(runs: Sequence[tuple[str, dict[str, float]]]) -> dict[str, Any]:
    """Lean runs beside full ones, pair by pair, and runs of one kind beside each other.

    Parameters
    ----------
    runs
        Kind, ``lean`` or ``full``, and seconds by stage of each run in the order of running: pairs
        of one run of each kind, every other pair the other way round.

    Returns
    -------
    dict
        ``pairs``, their number; ``lean`` and ``full``, median seconds by stage, and
        ``lean_seconds`` and ``full_seconds``, those of all stages; ``ratio`` with the ``median``,
        ``least`` and ``largest`` of lean over full, pair by pair; ``noise``, the largest relative
        difference of successive runs of one kind.
    """
    totals = [sum(seconds.values()) for _, seconds in runs]
    ratios = []
    for first in range(0, len(runs), 2):
        of = {runs[i][0]: totals[i] for i in (first, first + 1)}
        ratios.append(of["lean"] / of["full"])
    repeats = [totals[i + 1] / totals[i] for i in range(1, len(runs) - 1, 2)]
    found: dict[str, Any] = {"pairs": len(ratios)}
    for kind in ("lean", "full"):
        own = [i for i, (name, _) in enumerate(runs) if name == kind]
        stages = [stage for stage in STAGES if any(runs[i][1].get(stage) for i in own)]
        found[kind] = {
            stage: float(np.median([runs[i][1].get(stage, 0.0) for i in own])) for stage in stages
        }
        found[f"{kind}_seconds"] = float(np.median([totals[i] for i in own]))
    return found | {
        "ratio": {
            "median": float(np.median(ratios)),
            "least": min(ratios),
            "largest": max(ratios),
        },
        "noise": max(abs(ratio - 1) for ratio in repeats),
    }
