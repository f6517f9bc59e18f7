"""One run: its answer beside the true one, its verdict, and what it cost, as plain data."""

from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.errors import ConvergenceError, InputError
from comparisons.stability.parts.case import Run
from comparisons.stability.parts.problems import Answer, ModesAnswer
from comparisons.stability.verdicts import Judged, answered, crashed, refused
from scenes.spec.problems import SceneError

_GAPS = 2
"""Gaps between frequencies among which the widest ends a window."""


def judged(run: Run) -> dict[str, Any]:
    """What came out of a run.

    Returns
    -------
    dict
        Plain data: ``verdict``, ``reason``, ``met``; ``error``, ``missing``, ``spurious``;
        ``residual`` and ``condition``, the worst; ``modes``, ``dofs``, ``says``, ``growth`` (1/s,
        the fastest), ``seconds``. None where there is no such number.
    """
    try:
        true = run.reference.values() if run.reference is not None else None
    except (InputError, SceneError):  # what cannot be assembled can only be refused
        true = None
    except Exception as error:  # then nothing is known, which is a fault of the catalogue or of us
        return failed(f"no reference, {type(error).__name__}: {error}")
    frequency = None if true is None else window_end(true, run.lowest)
    answer: Answer | None = None
    begun = perf_counter()
    try:
        answer = run.problem.solve(frequency)
    except (InputError, SceneError, ConvergenceError) as error:
        verdict = refused(run, str(error))
    except Exception as error:  # a crash is data: it must not end the study
        verdict = crashed(f"{type(error).__name__}: {error}")
    seconds = perf_counter() - begun
    if answer is not None:
        verdict = answered(run, answer, true)
    return {**_told(verdict), **_of(answer), "seconds": seconds}


def window_end(true: Complexes, lowest: int) -> float:
    """Frequency (Hz) between the lowest true modes and the next, in a wide gap; above all if fewer.

    Parameters
    ----------
    true
        Lambda with Im >= 0.
    lowest
        How many modes the window holds at least.
    """
    frequencies = np.sort(true.imag) / (2 * np.pi)
    some = frequencies[lowest - 1 : lowest + _GAPS]
    if len(some) < 2 or len(frequencies) <= lowest:
        return float(1.1 * frequencies.max(initial=1.0))
    widest = int(np.argmax(np.diff(some)))
    return float(some[widest : widest + 2].mean())


def failed(message: str) -> dict[str, Any]:
    """The data of a run whose process ended without an answer."""
    return {**_told(crashed(message)), **_of(None), "seconds": None}


def _told(judged: Judged) -> dict[str, Any]:
    found = judged.comparison
    return {
        "verdict": judged.verdict,
        "reason": judged.reason,
        "met": judged.met,
        "error": found.error if found is not None else None,
        "missing": found.missing if found is not None else None,
        "spurious": found.spurious if found is not None else None,
    }


def _of(answer: Answer | None) -> dict[str, Any]:
    modes = answer if isinstance(answer, ModesAnswer) else None
    return {
        "residual": modes.residual if modes else None,
        "condition": modes.condition if modes else None,
        "modes": len(modes.eigenvalues) if modes else None,
        "growth": float(modes.eigenvalues.real.max(initial=0.0)) if modes else None,
        "dofs": answer.dofs if answer else None,
        "says": list(answer.says) if answer else [],
    }
