"""The verdict on a run: accurate, warned, refused, or WRONG.

Eigenvalues are compared by kappa = -lambda^2, which is smooth where lambda vanishes: errors are
those of lambda, abs(kappa - true) / (2 abs(true)), for rigid motions relative to a small part of
the window.
"""

from contextlib import suppress
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign, group
from cea.errors import ConvergenceError, InputError
from comparisons.stability.case import Run
from comparisons.stability.problems import NOT_COMPLETE, UNDECIDED, Answer, StressAnswer
from scenes.spec.problems import SceneError

_RIGID = 1e-4  # part of the window's kappa to which errors of smaller eigenvalues are relative
_REACH = 0.25  # relative error of lambda up to which an eigenvalue is matched with a true one
_BEYOND = 2.0  # true eigenvalues are used up to 1 + this times the window's kappa
_OPEN = {UNDECIDED, NOT_COMPLETE}  # marks of answers that are right but leave modes open
_GAPS = 2  # gaps between frequencies among which the widest ends a window
_CLEAR = 2.0  # factor on the threshold beyond which a growth rate is clearly above or below it


@dataclass(frozen=True)
class Comparison:
    """Errors of an answer against the true one."""

    error: float  # worst relative error, infinite where a mode is missing or spurious
    missing: int = 0  # true eigenvalues of the window that are missing
    spurious: int = 0  # computed eigenvalues that match no true one
    admitted: bool = False  # whether all errors are within the stated uncertainties
    false_claim: str = ""  # wrong claim of stability, in words


def judged(run: Run) -> dict[str, Any]:
    """Solve a run and return its verdict and errors as a row; None for missing numbers."""
    answer: Answer | StressAnswer | None = None
    found: Comparison | None = None
    begun = perf_counter()
    try:
        true = None
        if run.reference is not None:
            with suppress(InputError, SceneError):  # what cannot be assembled can only be refused
                true = run.reference.values()
        begun = perf_counter()
        answer = run.problem(None if true is None else window_end(true, run.lowest))
        if true is None:
            told = _wrong("answered what has no answer")
        else:
            found = compared(answer, true, run.tolerance)
            told = _answered(run, answer, found)
    except (InputError, SceneError, ConvergenceError) as error:
        told = {"verdict": "refused", "reason": str(error), "met": "refused" in run.expected}
        if run.names not in str(error):
            told = _wrong(f"refused for another reason than {run.names}: {error}")
    except Exception as error:  # a crash is data: it must not end the study
        told = _wrong(f"crash: {type(error).__name__}: {error}")
    return {
        **told,
        **{name: getattr(found, name, None) for name in ("error", "missing", "spurious")},
        **{name: getattr(answer, name, None) for name in ("residual", "condition", "dofs")},
        "modes": len(answer.eigenvalues) if isinstance(answer, Answer) else None,
        "says": "" if answer is None else ", ".join(answer.says),
        "seconds": perf_counter() - begun,
    }


def _wrong(reason: str) -> dict[str, Any]:
    return {"verdict": "WRONG", "reason": reason, "met": False}


def window_end(true: Complexes, lowest: int) -> float:
    """Frequency (Hz) in a wide gap above the lowest true modes, or above all if there are fewer."""
    frequencies = np.sort(true.imag) / (2 * np.pi)
    some = frequencies[lowest - 1 : lowest + _GAPS]
    if len(some) < 2 or len(frequencies) <= lowest:
        return float(1.1 * frequencies.max(initial=1.0))
    widest = int(np.argmax(np.diff(some)))
    return float(some[widest : widest + 2].mean())


def _answered(run: Run, answer: Answer | StressAnswer, found: Comparison) -> dict[str, Any]:
    """Verdict on an answer that was compared with the true one."""
    if found.false_claim:
        return _wrong(found.false_claim)
    said = [kind for kind in answer.says if kind not in run.warnings]
    reason = f"error {found.error:.1e}; it says: {', '.join(answer.says) or 'nothing'}"
    if found.error <= run.tolerance and not _OPEN & set(said):
        met = "accurate" in run.expected and ("warned" in run.expected or not said)
        return {"verdict": "accurate", "reason": reason, "met": met}
    if said or found.admitted:
        return {"verdict": "warned", "reason": reason, "met": "warned" in run.expected}
    return _wrong(reason)


def compared(answer: Answer | StressAnswer, true: Complexes, tolerance: float) -> Comparison:
    """Compare modes with the true ones, also beyond the window, or stresses with a uniform one.

    Within the relative ``tolerance`` a mode may lie on either side of the window's end. Clusters of
    true eigenvalues are compared by their mean: near a coalescence each loses half the digits.
    """
    if isinstance(answer, StressAnswer):
        return Comparison(float(np.abs(answer.stresses / true.real[0] - 1).max()))
    top = (2 * np.pi * answer.max_frequency) ** 2
    near = true[-(true**2).real <= (1 + _BEYOND) * top]
    near = np.where(np.abs(near) ** 2 <= 2 * tolerance * _RIGID * top, 0, near)
    kappa, found = -(near**2), -(answer.eigenvalues**2)
    scale = 2 * np.maximum(np.abs(kappa), _RIGID * top)
    cost = np.abs(found[None, :] - kappa[:, None]) / scale[:, None]
    # lambda and - lambda have one kappa: where both are real, one decays and the other grows
    apart, together = (np.abs(near[:, None] + sign * answer.eigenvalues) for sign in (-1, 1))
    cost[(apart > together) & (np.abs(near[:, None]) ** 2 > _RIGID * top)] = np.inf
    rows, columns = assign(cost, _REACH)
    inside = near.imag <= np.sqrt(top) * (1 - 2 * tolerance)
    inside &= near.real >= answer.min_growth * (1 - 2 * tolerance)
    missing = int(inside.sum() - inside[rows].sum())
    spurious = len(found) - len(columns)
    errors = _errors(found[columns] - kappa[rows], kappa[rows], scale[rows], tolerance)
    error = float("inf") if missing or spurious else float(errors.max(initial=0.0))
    own = answer.uncertainties[columns] * np.sqrt(np.abs(found[columns])) / (0.5 * scale[rows])
    admitted = not (missing or spurious) and bool((errors <= np.maximum(own, tolerance)).all())
    same = inside[rows] | (errors <= tolerance)  # beyond the window's end it may be another mode
    pairs = near[rows][same], columns[same], tolerance * scale[rows][same]
    claim = _false_claim(answer, *pairs, near[inside])
    return Comparison(error, missing, spurious, admitted, claim)


def _errors(difference: Complexes, kappa: Complexes, scale: Floats, tolerance: float) -> Floats:
    """Relative errors; in a cluster the larger of the mean's error and the own error squared."""
    errors = np.abs(difference) / scale
    for members in group(kappa, np.sqrt(tolerance)):
        if len(members) > 1:
            mean = np.abs(difference[members].mean()) / scale[members]
            errors[members] = np.maximum(mean, errors[members] ** 2)
    return errors


def _false_claim(
    answer: Answer, partners: Complexes, columns: Ints, slack: Floats, inside: Complexes
) -> str:
    """Claim of stability or instability that is clearly wrong, in words; "" if there is none.

    ``partners`` are the true eigenvalues of the modes ``columns``, with allowed errors ``slack`` of
    kappa; ``inside`` are the true modes of the window.
    """
    thresholds, size = answer.thresholds, np.maximum(np.abs(partners), np.finfo(float).tiny)
    slack = np.where(partners == 0, 0, np.minimum(slack / (2 * size), np.sqrt(slack)))
    for true, i, open_by in zip(partners, columns, slack, strict=True):
        if _is_false(answer.verdicts[i], true, thresholds[i], open_by):
            told = f"{answer.eigenvalues[i]:.4g} called {answer.verdicts[i]}"
            return f"mode of {told}, the true one is {true:.4g}"
    if not len(inside):
        return "window called unstable, it is empty" * (answer.verdict == "unstable")
    fastest = inside[np.argmax(inside.real)]
    extreme = thresholds.min if answer.verdict == "unstable" else thresholds.max
    threshold = extreme(initial=abs(fastest) * 1e-4) if len(thresholds) else 0.0
    if _is_false(answer.verdict, fastest, threshold, slack.max(initial=0.0)):
        return f"window called {answer.verdict}, its fastest true mode is {fastest:.4g}"
    return ""


def _is_false(said: str, true: complex, threshold: float, slack: float) -> bool:
    if said == "grows slowly" and true.real < -slack:
        return True
    if said in ("stable", "grows slowly", "rigid"):
        return true.real > _CLEAR * threshold + slack
    return said == "unstable" and true.real <= threshold / _CLEAR - slack
