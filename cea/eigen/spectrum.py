"""Eigenvalues of a complex eigenvalue analysis, with their errors and the window searched."""

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
"""Fraction of omega below which errors are relative to it instead of to abs(lambda), which is zero
for rigid body modes."""
_TRUSTED = 1e-2
"""Largest uncertainty of lambda, relative to :attr:`Spectrum.speeds`, of a trusted mode."""


@dataclass(frozen=True)
class Window:
    """The window that was searched, and the evidence that it is complete.

    A window holds the modes with 0 <= Im lambda <= omega of any growth rate, with damping or
    rotation those of at least ``min_growth``. Eigenvalues are kappa = -lambda^2 (1/s^2), with
    damping or rotation lambda (1/s).
    """

    max_frequency: float  # omega / (2 pi) (Hz)
    shift: float  # centre of the first disc
    radius: float  # radius of the first disc
    found: int  # number of eigenvalues in all discs, guard eigenvalues included
    discs: int = 1  # number of discs
    # growth rate (1/s) up to which every mode was found; infinite where none can grow faster
    max_growth: float = 0.0
    bounded: bool = False  # whether it was shown that no mode grows faster
    odd: bool = False  # whether the sign of a determinant shows that a real eigenvalue is missing
    # upper end of kappa for the count, slightly above omega^2, or with damping omega (1/s), and
    # number of eigenvalues found below it, or with damping in the window
    upper: float = np.inf
    found_below: int = 0
    symmetric_count: int | None = None  # number below ``upper`` by inertia; None with friction
    # frequency (Hz) and growth rate (1/s) of growing modes up to 5 percent above the end
    growing_above: tuple[tuple[float, float], ...] = field(default=(), kw_only=True)
    # frequency (Hz) of the lowest mode above an empty window; None where it is not known
    lowest: float | None = field(default=None, kw_only=True)
    # whether all eigenvalues of a small system were computed by LAPACK
    whole: bool = field(default=False, kw_only=True)
    # with damping or rotation, growth rate (1/s) down to which every mode was found and is listed
    min_growth: float | None = field(default=None, kw_only=True)
    # whether the eigenvalues nearest to a target were computed instead of a window
    neighbours: bool = field(default=False, kw_only=True)

    @property
    def complete(self) -> bool:
        """Whether every mode of the window was found, whatever its growth rate."""
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
        """Sentence that states why the window is complete, or what may be missing."""
        if self.neighbours:
            return f"{self.found} eigenvalues nearest to a target; no window was searched"
        if self.symmetric_count is not None:
            return (
                f"{self.found_below} eigenvalues were found below kappa = {self.upper:.5g}, and "
                f"the inertia of S - kappa M counts {self.symmetric_count}"
            )
        found = (
            f"the search found {self.found} eigenvalues in {self.discs} "
            f"disc{'s' * (self.discs > 1)}; appended random vectors found no further one"
        )
        if self.whole:
            found = f"LAPACK computed all eigenvalues, of which {self.found} were kept"
        if self.min_growth is not None:
            found += f"; the window extends down to the growth rate {self.min_growth:.4g} 1/s"
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
        """Return the number of modes of each class, the threshold, and the verdict of the window.

        ``words`` and ``growth`` are the classes and growth rates (1/s) of the modes; without a
        threshold it is 1e-4 abs(lambda).
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
        """Lines that name growing modes just above the end of the window; empty without any."""
        above = self.growing_above
        if not above:
            return []
        modes = "a mode grows" if len(above) == 1 else f"{len(above)} modes grow"
        each = ", ".join(f"{growth:+.3g} 1/s at {at:.6g} Hz" for at, growth in above)
        return [f"hint: {modes} just above the end of the window: {each}"]


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues with Im lambda >= 0, sorted by frequency.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,): growth rate + i * angular frequency.
    residuals
        Norms of (lambda^2 M + K) x relative to abs(lambda)^2 times the norm of M x, shape (n,).
        With damping or rotation norms of P(lambda) x relative to the norm of the sum of its terms
        in absolute values, abs(lambda)^2 abs(M) abs(x) etc.
    conditions
        Condition numbers of lambda^2 in the M-norm, shape (n,): 1 for a symmetric problem without
        damping, large near a coalescence. Without left vectors, those within the subspace found.
    growth_uncertainties
        Error estimates of lambda (1/s), shape (n,): backward error and rounding of the matrices
        times the condition number.
    window
        The window that was searched.
    bounded
        Modes that cannot grow owing to the structure of the problem, shape (n,), by
        :func:`cea.eigen.classify.cannot_grow`; None where it is not known for any mode.
    warnings
        Warnings about the result.
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
        """-Re lambda / abs(lambda), shape (n,): negative for growing modes, NaN for rigid ones."""
        ratios = np.full(len(self), np.nan)
        moving = ~self.rigid & (self.eigenvalues != 0)
        ratios[moving] = 0.0 - self.growth_rates[moving] / np.abs(self.eigenvalues[moving])
        return ratios

    @property
    def rigid(self) -> NDArray[np.bool_]:
        """Whether each mode is a rigid body mode, lambda = 0 within its error, shape (n,)."""
        return self.trusted & (np.abs(self.eigenvalues) <= self.growth_uncertainties)

    @property
    def slowest(self) -> float:
        """Least reference value of relative errors (1/s): a tenth of omega, zero without a window.

        It replaces abs(lambda) of rigid body modes, which is zero apart from rounding.
        """
        end = 2 * np.pi * self.window.max_frequency
        return SLOW * end if np.isfinite(end) else 0.0

    @property
    def speeds(self) -> Floats:
        """Reference values of relative errors (1/s): abs(lambda), at least :attr:`slowest`."""
        return np.maximum(np.abs(self.eigenvalues), self.slowest)

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """Whether each mode has an error of at most 1 % of :attr:`speeds`, shape (n,)."""
        return self.growth_uncertainties <= _TRUSTED * self.speeds

    def thresholds(self, threshold: float | None = None) -> Floats:
        """Growth rates (1/s) above which modes count as unstable; None takes 1e-4 abs(lambda)."""
        return thresholds(self.eigenvalues, threshold)

    def unstable(self, threshold: float | None = None) -> NDArray[np.bool_]:
        """Return whether each mode is classified as unstable, shape (n,)."""
        return np.array([word == "unstable" for word in self.verdicts(threshold)], dtype=bool)

    def verdicts(self, threshold: float | None = None) -> list[Word]:
        """Classify each mode with its algebraic error (:func:`cea.eigen.classify.classify`)."""
        return classify(
            self.growth_rates,
            self.growth_uncertainties,
            self.thresholds(threshold),
            np.zeros(len(self), dtype=bool) if self.bounded is None else self.bounded,
            self.rigid,
        )

    def verdict(self, threshold: float | None = None) -> RunWord:
        """Classify the whole window (:func:`cea.eigen.classify.classify_run`)."""
        window = self.window
        each = self.verdicts(threshold)
        return classify_run(each, complete=window.complete, missing=window.missing)

    def table(self, threshold: float | None = None) -> ModeTable:
        """Return a row for each mode: number from 1, frequency (Hz), growth rate (1/s), errors."""
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
        """Return the number of modes of each class, the threshold, and the verdict of the run."""
        words, growth = self.verdicts(threshold), self.growth_rates.tolist()
        return self.window.headline(words, growth, threshold)

    def text(self, threshold: float | None = None) -> str:
        """Return the headline and a table of all modes with marks."""
        lines = aligned(self.table(threshold))
        return "\n".join([self.headline(threshold), *self.window.hints, *lines, SIGNS])
