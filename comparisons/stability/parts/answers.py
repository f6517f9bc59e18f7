"""What runs say: eigenvalues or stresses, and how far they claim to be trusted."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.body import Complexes, Floats
from cea.eigen.spectrum import Spectrum

_RELATIVE_THRESHOLD = 1e-4
"""Growth rate above which a mode is unstable where none is given, relative to abs(lambda)."""


@dataclass(frozen=True)
class ModesAnswer:
    """Modes of a run, and what it says of them.

    Parameters
    ----------
    eigenvalues
        Lambda (1/s), shape (n,).
    verdicts
        "stable", "unstable" or "undecided" for each.
    verdict
        The same of the whole window.
    thresholds
        Growth rate (1/s) above which each is called unstable, shape (n,).
    complete
        Whether the window claims to hold every mode.
    max_frequency
        Upper end of the window (Hz).
    residual, condition
        The worst of both.
    warnings
        Kinds of its warnings.
    dofs
        Number of unknowns.
    """

    eigenvalues: Complexes
    verdicts: tuple[str, ...]
    verdict: str
    thresholds: Floats
    complete: bool
    max_frequency: float
    residual: float
    condition: float
    warnings: tuple[str, ...]
    dofs: int

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of what it warns of: its warnings, modes undecided, a window not complete."""
        undecided = "undecided" in (*self.verdicts, self.verdict)
        return (
            *dict.fromkeys(self.warnings),
            *(["undecided"] if undecided else []),
            *([] if self.complete else ["not-complete"]),
        )


@dataclass(frozen=True)
class StressAnswer:
    """Normal stresses (N/m^2) over both sides of the contacts of a static run.

    Parameters
    ----------
    stresses
        Shape (n,).
    warnings, dofs
        As of :class:`ModesAnswer`.
    """

    stresses: Floats
    warnings: tuple[str, ...]
    dofs: int

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of what it warns of."""
        return self.warnings


Answer = ModesAnswer | StressAnswer


def answer_of(modes: Spectrum, threshold: float | None, dofs: int) -> ModesAnswer:
    """What a spectrum says.

    Parameters
    ----------
    modes
        The spectrum.
    threshold
        Growth rate (1/s) above which a mode is called unstable; None where it is relative.
    dofs
        Number of unknowns.
    """
    size = np.abs(modes.eigenvalues)
    relative = _RELATIVE_THRESHOLD * size
    verdicts, verdict, complete = _told(modes, threshold)
    return ModesAnswer(
        eigenvalues=modes.eigenvalues,
        verdicts=verdicts,
        verdict=verdict,
        thresholds=relative if threshold is None else np.full(len(size), threshold),
        complete=complete,
        max_frequency=modes.window.max_frequency,
        residual=float(modes.residuals.max(initial=0.0)),
        condition=float(modes.conditions.max(initial=1.0)),
        warnings=tuple(warning.kind for warning in modes.warnings),
        dofs=dofs,
    )


def _told(modes: Any, threshold: float | None) -> tuple[tuple[str, ...], str, bool]:
    """Verdict on each mode, on the window, and whether that is complete."""
    if hasattr(modes, "verdicts"):
        each = tuple(str(verdict) for verdict in modes.verdicts(threshold))
        return each, str(modes.verdict(threshold)), bool(modes.window.complete)
    least = _RELATIVE_THRESHOLD * np.abs(modes.eigenvalues) if threshold is None else threshold
    each = tuple("unstable" if u else "stable" for u in modes.unstable(least))
    return each, "unstable" if "unstable" in each else "stable", True
