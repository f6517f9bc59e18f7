"""The verdict on a run: accurate, warned, refused, or WRONG.

Eigenvalues are compared through kappa = -lambda^2, which is smooth where lambda vanishes: errors
are those of lambda, abs(kappa - true) / (2 abs(true)), relative to a small part of the window where
a motion is rigid.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import assign, group
from comparisons.stability.parts.case import Run, Verdict
from comparisons.stability.parts.problems import (
    NOT_COMPLETE,
    UNDECIDED,
    Answer,
    ModesAnswer,
    StressAnswer,
)

_RIGID = 1e-4
"""Part of the window's kappa that errors of smaller eigenvalues are relative to."""
_REACH = 0.25
"""Largest relative error of lambda of an eigenvalue that stands for a true one."""
_BEYOND = 2.0
"""Part of kappa beyond the window's up to which true eigenvalues are looked at, for its ends."""
_OPEN = {UNDECIDED, NOT_COMPLETE}
"""What an answer leaves open that is right as far as it goes."""
_CLEAR = 2.0
"""How far above or below the threshold a growth rate lies on one side of it beyond doubt."""


@dataclass(frozen=True)
class Comparison:
    """An answer beside the true one.

    Parameters
    ----------
    error
        Worst relative error, infinite where a mode is missing or spurious.
    missing, spurious
        True eigenvalues of the window that were not found, and found ones that stand for none.
    admitted
        Whether no mode is farther off than it says itself that it may be.
    false_claim
        A mode, or the window, that is called stable or unstable and is not, in words; "" if none.
    """

    error: float
    missing: int = 0
    spurious: int = 0
    admitted: bool = False
    false_claim: str = ""


@dataclass(frozen=True)
class Judged:
    """The verdict on a run.

    Parameters
    ----------
    verdict
        The verdict.
    reason
        Why, in words.
    met
        Whether it is one that was expected, with no warning but those that may come.
    comparison
        The answer beside the true one; None where there was none of both.
    """

    verdict: Verdict
    reason: str
    met: bool
    comparison: Comparison | None = None


def refused(run: Run, message: str) -> Judged:
    """Verdict on a run that was refused, or did not converge and said so."""
    if run.names and run.names not in message:
        return Judged("WRONG", f"refused for another reason than {run.names}: {message}", False)
    return Judged("refused", message, "refused" in run.expected)


def crashed(message: str) -> Judged:
    """Verdict on a run that ended in any other way."""
    return Judged("WRONG", f"crash: {message}", False)


def answered(run: Run, answer: Answer, true: Complexes | None) -> Judged:
    """Verdict on a run with an answer, beside the true one; None where there can be none."""
    if true is None:
        return Judged("WRONG", "answered what has no answer", False)
    found = (
        _compare_stresses(answer, true)
        if isinstance(answer, StressAnswer)
        else compare(answer, true, run.tolerance)
    )
    if found.false_claim:
        return Judged("WRONG", found.false_claim, False, found)
    said = [kind for kind in answer.says if kind not in run.warnings]
    says = f"it says: {', '.join(answer.says)}" if answer.says else ""
    if found.error <= run.tolerance and not _OPEN & set(said):
        met = "accurate" in run.expected and ("warned" in run.expected or not said)
        return Judged("accurate", says, met, found)
    what = _what(found)
    if found.admitted and found.error > run.tolerance:
        what = f"{what}, which its uncertainties admit"
    if said or found.admitted:
        reason = "; ".join(part for part in (what, says) if part)
        return Judged("warned", reason, "warned" in run.expected, found)
    return Judged("WRONG", f"{what}, without a word of it", False, found)


def _what(found: Comparison) -> str:
    if not (found.missing or found.spurious):
        return f"error {found.error:.1e}"
    return f"{found.missing} modes missing, {found.spurious} spurious"


def compare(answer: ModesAnswer, true: Complexes, tolerance: float) -> Comparison:
    """Modes beside the true ones.

    Parameters
    ----------
    answer
        The modes of a window.
    true
        Lambda of every true mode, far beyond the window.
    tolerance
        Relative distance at which a mode may lie on either side of the window's end, and within
        which true eigenvalues are compared by their mean: near a coalescence they lose half the
        digits of it.
    """
    top = (2 * np.pi * answer.max_frequency) ** 2
    near = true[-(true**2).real <= (1 + _BEYOND) * top]
    near = np.where(np.abs(near) ** 2 <= 2 * tolerance * _RIGID * top, 0, near)
    kappa, found = -(near**2), -(answer.eigenvalues**2)
    scale = 2 * np.maximum(np.abs(kappa), _RIGID * top)
    cost = np.abs(found[None, :] - kappa[:, None]) / scale[:, None]
    cost[_opposite(near, answer.eigenvalues, _RIGID * top)] = np.inf
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
    claims = _Claims(answer, tolerance * scale[rows][same], columns[same])
    claim = claims.false_one(near[rows][same], near[inside])
    return Comparison(error, missing, spurious, admitted, claim)


def _opposite(true: Complexes, found: Complexes, rigid: float) -> NDArray[np.bool_]:
    """Pairs of about lambda and - lambda, which have one kappa: both are real, one decays."""
    apart, together = (np.abs(true[:, None] + sign * found) for sign in (-1, 1))
    return (apart > together) & (np.abs(true[:, None]) ** 2 > rigid)


def _errors(difference: Complexes, kappa: Complexes, scale: Floats, tolerance: float) -> Floats:
    """Relative errors; in a group those of its mean, and the squares of those of its members."""
    errors = np.abs(difference) / scale
    for members in group(kappa, np.sqrt(tolerance)):
        if len(members) > 1:
            mean = np.abs(difference[members].mean()) / scale[members]
            errors[members] = np.maximum(mean, errors[members] ** 2)
    return errors


@dataclass(frozen=True)
class _Claims:
    """What an answer calls stable or unstable.

    Parameters
    ----------
    answer
        The answer.
    slack
        Error of kappa (1/s^2) that each true partner may have.
    columns
        Number of the found mode that is paired with each true one.
    """

    answer: ModesAnswer
    slack: Floats
    columns: Ints

    def false_one(self, partners: Complexes, inside: Complexes) -> str:
        """A claim that clearly is not so, in words; "" if there is none.

        Parameters
        ----------
        partners
            True partner of each paired mode.
        inside
            True modes of the window.
        """
        thresholds = self.answer.thresholds
        size = np.maximum(np.abs(partners), np.finfo(float).tiny)
        slack = np.where(partners == 0, 0, np.minimum(self.slack / (2 * size), np.sqrt(self.slack)))
        for true, i, open_by in zip(partners, self.columns, slack, strict=True):
            if self._false(self.answer.verdicts[i], true, thresholds[i], open_by):
                told = f"{self.answer.eigenvalues[i]:.4g} called {self.answer.verdicts[i]}"
                return f"mode of {told}, the true one is {true:.4g}"
        if not len(inside):
            return "window called unstable, it is empty" * (self.answer.verdict == "unstable")
        fastest = inside[np.argmax(inside.real)]
        extreme = thresholds.min if self.answer.verdict == "unstable" else thresholds.max
        threshold = extreme(initial=abs(fastest) * 1e-4) if len(thresholds) else 0.0
        if self._false(self.answer.verdict, fastest, threshold, slack.max(initial=0.0)):
            return f"window called {self.answer.verdict}, its fastest true mode is {fastest:.4g}"
        return ""

    @staticmethod
    def _false(said: str, true: complex, threshold: float, slack: float) -> bool:
        if said == "grows slowly" and true.real < -slack:
            return True
        if said in ("stable", "grows slowly", "rigid"):
            return true.real > _CLEAR * threshold + slack
        return said == "unstable" and true.real <= threshold / _CLEAR - slack


def _compare_stresses(answer: StressAnswer, true: Complexes) -> Comparison:
    """A uniform stress beside the true one."""
    return Comparison(float(np.abs(answer.stresses / true.real[0] - 1).max()))
