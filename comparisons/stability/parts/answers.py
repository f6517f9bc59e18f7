"""What runs say: eigenvalues or stresses, and how far they claim to be trusted."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.spectrum import Spectrum
from cea.warned import ResultWarning

UNDECIDED, NOT_COMPLETE = "undecided", "window-not-complete"
"""Kinds of what an answer leaves open."""


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
    uncertainties
        What lambda (1/s) of each may be off by its own account, shape (n,).
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
    min_growth
        Growth rate (1/s) down to which the window holds every mode.
    """

    eigenvalues: Complexes
    verdicts: tuple[str, ...]
    verdict: str
    thresholds: Floats
    uncertainties: Floats
    complete: bool
    max_frequency: float
    residual: float
    condition: float
    warnings: tuple[str, ...]
    dofs: int
    min_growth: float = -np.inf

    @property
    def says(self) -> tuple[str, ...]:
        """Kinds of what it warns of: its warnings, modes undecided, a window not complete."""
        undecided = "undecided" in (*self.verdicts, self.verdict)
        open_ends = [UNDECIDED] * undecided + [NOT_COMPLETE] * (not self.complete)
        return tuple(dict.fromkeys([*self.warnings, *open_ends]))


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


def answer_of(
    modes: Spectrum, warnings: Iterable[ResultWarning], threshold: float | None, dofs: int
) -> ModesAnswer:
    """What a spectrum says.

    Parameters
    ----------
    modes
        The spectrum.
    warnings
        What it must be read with.
    threshold
        Growth rate (1/s) above which a mode is called unstable; None where it is relative.
    dofs
        Number of unknowns.
    """
    return ModesAnswer(
        eigenvalues=modes.eigenvalues,
        verdicts=tuple(modes.verdicts(threshold)),
        verdict=modes.verdict(threshold),
        thresholds=modes.thresholds(threshold),
        uncertainties=modes.growth_uncertainties,
        complete=modes.window.complete,
        max_frequency=modes.window.max_frequency,
        min_growth=getattr(modes.window, "min_growth", -np.inf),
        residual=float(modes.residuals.max(initial=0.0)),
        condition=float(modes.conditions.max(initial=1.0)),
        warnings=kinds(warnings),
        dofs=dofs,
    )


def kinds(warnings: Iterable[ResultWarning]) -> tuple[str, ...]:
    """Kinds of warnings, each once."""
    return tuple(dict.fromkeys(warning.kind for warning in warnings))
