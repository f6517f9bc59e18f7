"""What was searched of a damped or rotating pencil."""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Complexes
from cea.eigen.spectrum import Window


@dataclass(frozen=True)
class QuadraticWindow(Window):
    """What was searched of a quadratic problem, and why it is believed complete.

    The window holds the modes with 0 <= Im lambda <= omega of any growth, down to a decay. Shift
    and radius are those of the first disc of lambda (1/s), ``found`` counts what it holds without
    conjugates; ``upper`` is omega (1/s), and ``found_below`` counts the lambda found with
    0 <= Im lambda <= omega.

    Parameters
    ----------
    min_growth
        Growth rate (1/s) down to which every mode was found, below zero; modes that decay faster
        are not listed.
    """

    min_growth: float

    @property
    def evidence(self) -> str:
        """Why the window is believed complete, or how far it is not, in words."""
        found = (
            f"{self.searched}; the window reaches down to the growth rate {self.min_growth:.4g} 1/s"
        )
        if self.odd:
            return f"{found}; the sign of a determinant shows that a real one is missing"
        if self.whole:
            return found
        if self.bounded:
            return f"{found}; no eigenvalue of the window grows faster"
        return f"{found}; modes that grow faster than {self.max_growth:.4g} 1/s are not excluded"


@dataclass(frozen=True)
class QuadraticNeighbours(QuadraticWindow):
    """What was searched next to a place: no window."""

    @classmethod
    def of(cls, shift: float, values: Complexes) -> "QuadraticNeighbours":
        """Of the eigenvalues found about a real shift (1/s)."""
        return cls(
            max_frequency=float(np.abs(values).max(initial=shift)) / (2 * np.pi),
            shift=shift,
            radius=float(np.abs(values - shift).max(initial=0.0)),
            found=len(values),
            discs=1,
            max_growth=0.0,
            bounded=False,
            odd=False,
            upper=np.inf,
            found_below=len(values),
            symmetric_count=None,
            min_growth=-np.inf,
        )

    @property
    def evidence(self) -> str:
        """What was looked for, in words."""
        return (
            f"{self.found} eigenvalues lambda nearest to a place, up to {self.radius:.4g} 1/s "
            "away; no window was searched"
        )
