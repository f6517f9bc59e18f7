"""Eigenvalues of a complex eigenvalue analysis, with the errors and search that vouch for them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.classify import RunWord, Word, classify, classify_run, counted_words, thresholds
from cea.errors import ResultWarning
from cea.mode_table import SIGNS, ModeTable, aligned

SLOW = 0.1
"""Errors of modes slower than this part of the window are relative to it: rigid motions have no
speed."""
_TRUSTED = 1e-2
"""Uncertainty of lambda, relative likewise, up to which a mode is trusted."""


@dataclass(frozen=True)
class Window:
    """What was searched, and why it is believed complete.

    A window holds the modes with 0 <= Im lambda <= omega of any growth. Without damping and
    rotation eigenvalues are kappa = -lambda^2 (1/s^2), with them lambda (1/s).
    """

    max_frequency: float  # omega / (2 pi) (Hz)
    shift: float  # of the first disc in which every eigenvalue was found
    radius: float
    found: int  # eigenvalues in all discs and around them
    discs: int = 1
    # growth rate (1/s) up to which every mode was found; infinite where none can grow faster
    max_growth: float = 0.0
    bounded: bool = False  # whether it was shown that none can grow faster
    odd: bool = False  # whether the sign of a determinant shows that a real one was not found
    # end of kappa for the count, a little above the window's, or with damping omega (1/s), and
    # eigenvalues found below it, or with damping in the window
    upper: float = np.inf
    found_below: int = 0
    symmetric_count: int | None = None  # those below it by inertia; None where friction acts
    # frequency (Hz) and growth rate (1/s) of modes that grow up to 5 percent above the end
    growing_above: tuple[tuple[float, float], ...] = field(default=(), kw_only=True)
    # frequency (Hz) of the lowest mode above an empty window, where it was found
    lowest: float | None = field(default=None, kw_only=True)
    # whether the system is so small that all eigenvalues were computed
    whole: bool = field(default=False, kw_only=True)
    # with damping or rotation, growth rate (1/s) down to which every mode was found and is listed
    min_growth: float | None = field(default=None, kw_only=True)
    # whether it is no window, but the eigenvalues nearest to a place were asked for
    neighbours: bool = field(default=False, kw_only=True)

    @property
    def complete(self) -> bool:
        """Whether every mode of the window was found, whatever its growth."""
        if self.symmetric_count is not None:
            return self.found_below == self.symmetric_count
        return self.bounded and not self.odd

    @property
    def missing(self) -> bool:
        """Whether a mode is known to be missing."""
        counted = self.symmetric_count
        return self.odd or (counted is not None and self.found_below != counted)

    @property
    def evidence(self) -> str:
        """Why the window is believed complete, or how far it is not, in words."""
        if self.neighbours:
            return f"{self.found} eigenvalues nearest to a place; no window was searched"
        if self.symmetric_count is not None:
            return (
                f"below kappa = {self.upper:.5g} {self.found_below} eigenvalues were found, and "
                f"the inertia of S - kappa M counts {self.symmetric_count}"
            )
        found = (
            f"{self.found} eigenvalues fill {self.discs} disc{'s' * (self.discs > 1)}, "
            "in which appended random vectors found no further one"
        )
        if self.whole:
            found = f"LAPACK computed all eigenvalues, of which {self.found} were kept"
        if self.min_growth is not None:
            found += f"; the window reaches down to the growth rate {self.min_growth:.4g} 1/s"
        if self.odd:
            return f"{found}; the sign of a determinant shows that a real one is missing"
        if self.whole:
            return found
        if self.bounded:
            return f"{found}; no eigenvalue of the window grows faster"
        return f"{found}; modes that grow faster than {self.max_growth:.4g} 1/s are not excluded"

    def headline(
        self, words: Sequence[Word], growth: Sequence[float], threshold: float | None
    ) -> str:
        """How many modes have which word, the threshold that decided, and the word of all.

        ``words`` and ``growth`` rates (1/s) are those of the modes; the threshold is 1e-4 of
        abs(lambda) where it is None.
        """
        top = f"{self.max_frequency:g} Hz"
        if not words:
            near = "" if self.lowest is None else f"; the lowest is near {self.lowest:.5g} Hz"
            return f"no modes below {top}{near}"
        word = classify_run(words, complete=self.complete, missing=self.missing)
        modes = "mode" if len(words) == 1 else "modes"
        counts = counted_words(words, growth, threshold)
        line = f"{len(words)} {modes} up to {top}: {counts}; verdict: {word}"
        if word == "no unstable mode found":
            line += f" up to a growth rate of {self.max_growth:.4g} 1/s"
        return line

    @property
    def hints(self) -> list[str]:
        """What to know of modes just above the window, a line where some grow there."""
        above = self.growing_above
        if not above:
            return []
        modes = "a mode grows" if len(above) == 1 else f"{len(above)} modes grow"
        told = ", ".join(f"{growth:+.3g} 1/s at {at:.6g} Hz" for at, growth in above)
        return [f"hint: {modes} just above the end of the window: {told}"]


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues by rising frequency, Im lambda >= 0.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,): growth rate + i * angular frequency.
    residuals
        Norm of (lambda^2 M + K) x relative to abs(lambda)^2 times that of M x, shape (n,). With
        damping or rotation that of P(lambda) x relative to that of its parts, abs(M) abs(x) etc.
    conditions
        Condition numbers of lambda^2 in the M-norm, shape (n,): 1 for a symmetric problem without
        damping, large near a coalescence. Without left vectors, those within the subspace found.
    growth_uncertainties
        What backward error and rounding of the matrices, times the condition, can make of lambda
        (1/s), shape (n,).
    window
        What was searched.
    bounded
        Modes that cannot grow for the structure of the problem, shape (n,), as
        :func:`cea.eigen.classify.cannot_grow` says; None where that is not known of any.
    warnings
        What they must be read with.
    """

    eigenvalues: Complexes
    residuals: Floats
    conditions: Floats
    growth_uncertainties: Floats
    window: Window
    bounded: NDArray[np.bool_] | None = field(default=None, kw_only=True)
    warnings: tuple[ResultWarning, ...] = field(default=(), kw_only=True)

    def __len__(self) -> int:
        return len(self.eigenvalues)

    def __str__(self) -> str:
        return self.text()

    @property
    def frequencies(self) -> Floats:
        """Frequencies (Hz)."""
        return self.eigenvalues.imag / (2 * np.pi)

    @property
    def growth_rates(self) -> Floats:
        """Growth rates Re lambda (1/s)."""
        return self.eigenvalues.real

    @property
    def damping_ratios(self) -> Floats:
        """-Re lambda / abs(lambda), shape (n,): below zero where a mode grows, NaN where rigid."""
        ratios = np.full(len(self), np.nan)
        moving = ~self.rigid & (self.eigenvalues != 0)
        ratios[moving] = 0.0 - self.growth_rates[moving] / np.abs(self.eigenvalues[moving])
        return ratios

    @property
    def rigid(self) -> NDArray[np.bool_]:
        """Modes whose lambda is zero but for rounding, shape (n,): nothing holds their motion."""
        return self.trusted & (np.abs(self.eigenvalues) <= self.growth_uncertainties)

    @property
    def slowest(self) -> float:
        """Tenth of the window (1/s): what errors of slower modes are relative to, else zero.

        Rigid motions have lambda = 0 but for rounding, and no speed of their own.
        """
        end = 2 * np.pi * self.window.max_frequency
        return SLOW * end if np.isfinite(end) else 0.0

    @property
    def speeds(self) -> Floats:
        """abs(lambda), but no less than :attr:`slowest` (1/s): what errors are relative to."""
        return np.maximum(np.abs(self.eigenvalues), self.slowest)

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """Modes that are known to a hundredth of their speed, shape (n,)."""
        return self.growth_uncertainties <= _TRUSTED * self.speeds

    def thresholds(self, threshold: float | None = None) -> Floats:
        """Growth rates (1/s) above which modes are called unstable; None takes 1e-4 abs(lambda)."""
        return thresholds(self.eigenvalues, threshold)

    def unstable(self, threshold: float | None = None) -> NDArray[np.bool_]:
        """Modes that are called unstable, shape (n,)."""
        return np.array([word == "unstable" for word in self.verdicts(threshold)], dtype=bool)

    def verdicts(self, threshold: float | None = None) -> list[Word]:
        """The word of each mode, with its algebraic error (:func:`cea.eigen.classify.classify`)."""
        return classify(
            self.growth_rates,
            self.growth_uncertainties,
            self.thresholds(threshold),
            np.zeros(len(self), dtype=bool) if self.bounded is None else self.bounded,
            self.rigid,
        )

    def verdict(self, threshold: float | None = None) -> RunWord:
        """The word of the whole window (:func:`cea.eigen.classify.classify_run`)."""
        window = self.window
        each = self.verdicts(threshold)
        return classify_run(each, complete=window.complete, missing=window.missing)

    def table(self, threshold: float | None = None) -> ModeTable:
        """A row for each mode: its number from 1, frequency (Hz), growth rate (1/s), errors."""
        ratios = zip(self.damping_ratios.tolist(), self.rigid.tolist(), strict=True)
        columns: dict[str, Iterable[Any]] = {
            "mode": range(1, len(self) + 1),
            "frequency": self.frequencies.tolist(),
            "growth_rate": self.growth_rates.tolist(),
            "damping_ratio": [None if rigid else ratio for ratio, rigid in ratios],
            "unstable": self.unstable(threshold).tolist(),
            "verdict": self.verdicts(threshold),
            "rigid": self.rigid.tolist(),
            "uncertainty": self.growth_uncertainties.tolist(),
            "residual": self.residuals.tolist(),
            "condition": self.conditions.tolist(),
        }
        rows = zip(*columns.values(), strict=True)
        return ModeTable(dict(zip(columns, row, strict=True)) for row in rows)

    def headline(self, threshold: float | None = None) -> str:
        """How many modes have which word, the threshold that decided, and the run's word."""
        words, growth = self.verdicts(threshold), self.growth_rates.tolist()
        return self.window.headline(words, growth, threshold)

    def text(self, threshold: float | None = None) -> str:
        """The headline, and all modes in a table with marks."""
        lines = aligned(self.table(threshold))
        return "\n".join([self.headline(threshold), *self.window.hints, *lines, SIGNS])
