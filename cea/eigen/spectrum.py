"""Eigenvalues of a complex eigenvalue analysis, with the errors and search that vouch for them."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Complexes, Floats
from cea.warned import ResultWarning


@dataclass(frozen=True)
class Window:
    """What was searched, and why it is believed complete.

    Parameters
    ----------
    max_frequency
        Upper end (Hz) of the modes asked for.
    shift
        Centre sigma of the searched disc of kappa = -lambda^2 (1/s^2).
    radius
        Every kappa with abs(kappa - shift) < radius was found (1/s^2).
    found
        Number of eigenvalues in the disc.
    upper
        Upper end of kappa for the count (1/s^2), a little above the window's.
    found_below
        Eigenvalues found with Re kappa below ``upper``.
    symmetric_count
        Eigenvalues of S x = kappa M x, without friction, below ``upper``, by inertia; None where
        they were not counted.
    max_growth
        Largest growth rate (1/s) a mode at the upper end can have and still lie in the disc.
    """

    max_frequency: float
    shift: float
    radius: float
    found: int
    upper: float
    found_below: int
    symmetric_count: int | None
    max_growth: float

    @property
    def evidence(self) -> str:
        """Why the window is believed complete, in words."""
        disc = (
            f"shift-and-invert converged outwards to all {self.found} eigenvalues in the disc "
            f"|kappa - {self.shift:.5g}| <= {self.radius:.5g}"
        )
        if self.symmetric_count is None:
            return disc
        return (
            f"{disc}; below kappa = {self.upper:.5g} it found {self.found_below}, and the inertia "
            f"of the symmetric part counts {self.symmetric_count}"
        )


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues by rising frequency, Im lambda >= 0.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,): growth rate + i * angular frequency.
    residuals
        Norm of (lambda^2 M + K) x relative to abs(lambda)^2 times that of M x, shape (n,).
    conditions
        Condition numbers of lambda^2 in the M-norm, shape (n,): 1 for a symmetric problem, large
        near a coalescence. Without left vectors, those within the computed invariant subspace.
    window
        What was searched.
    warnings
        What they must be read with.
    """

    eigenvalues: Complexes
    residuals: Floats
    conditions: Floats
    window: Window
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
    def growth_uncertainties(self) -> Floats:
        """Growth rates (1/s) that backward error times condition can explain.

        An error e of lambda^2 moves lambda by e / (2 abs(lambda)), or by sqrt(e) near 0. Near a
        coalescence the condition number carries the square root of the rounding.
        """
        square = np.abs(self.eigenvalues) ** 2
        floor = np.maximum(np.abs(self.eigenvalues), np.finfo(float).tiny)
        error = np.maximum(self.residuals, np.finfo(float).eps) * self.conditions * square
        return np.minimum(error / (2 * floor), np.sqrt(error))

    def unstable(self, threshold: float = 0.0) -> NDArray[np.bool_]:
        """Modes that grow faster than a threshold (1/s) and than their errors explain, (n,)."""
        return self.growth_rates > np.maximum(threshold, self.growth_uncertainties)

    def table(self, threshold: float = 0.0) -> list[dict[str, Any]]:
        """A row for each mode: its number from 1, frequency (Hz), growth rate (1/s), errors.

        Parameters
        ----------
        threshold
            Growth rate (1/s) above which a mode is called unstable.
        """
        columns: dict[str, Iterable[Any]] = {
            "mode": range(1, len(self) + 1),
            "frequency": self.frequencies.tolist(),
            "growth_rate": self.growth_rates.tolist(),
            "unstable": self.unstable(threshold).tolist(),
            "residual": self.residuals.tolist(),
            "condition": self.conditions.tolist(),
        }
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def text(self, threshold: float = 0.0) -> str:
        """How many modes are unstable, and all of them in a table; a star marks unstable ones."""
        count = int(self.unstable(threshold).sum())
        lines = [
            f"{count} of {len(self)} modes up to {self.window.max_frequency:g} Hz unstable",
            " mode  frequency (Hz)  growth rate (1/s)  residual  condition",
        ]
        lines += [
            f"{row['mode']:5d}  {row['frequency']:14.3f}  {row['growth_rate']:+17.3f}"
            f"  {row['residual']:8.1e}  {row['condition']:9.1f}{' *' if row['unstable'] else ''}"
            for row in self.table(threshold)
        ]
        return "\n".join(lines)
