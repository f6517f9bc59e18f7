"""What was searched of a damped or rotating pencil."""

from dataclasses import dataclass

from cea.eigen.spectrum import Window
from cea.eigen.subspace import InvariantSubspace


@dataclass(frozen=True)
class ShiftedDisc:
    """A disc of lambda in which every eigenvalue was found.

    Parameters
    ----------
    centre, radius
        In 1/s.
    """

    centre: float
    radius: float


@dataclass(frozen=True)
class QuadraticFound:
    """What a search of a window found.

    Parameters
    ----------
    subspace
        Invariant subspace of the eigenvalues found, of the companion form.
    discs
        Discs that are full.
    growth
        Every eigenvalue of the window with Re lambda <= growth was found (1/s).
    bounded
        Whether none grows faster.
    odd
        Whether the sign of a determinant shows that a real eigenvalue is missing.
    """

    subspace: InvariantSubspace
    discs: tuple[ShiftedDisc, ...] = ()
    growth: float = 0.0
    bounded: bool = False
    odd: bool = False


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
            f"{self.found} eigenvalues lambda fill {self.discs} "
            f"disc{'s' * (self.discs > 1)}, which hold the window down to the growth rate "
            f"{self.min_growth:.4g} 1/s and were searched beside them until nothing more was found"
        )
        if self.odd:
            return f"{found}; the sign of a determinant shows that a real one is missing"
        if self.bounded:
            return f"{found}; none grows faster than they reach, or the spectrum ends before"
        return f"{found}; modes that grow faster than {self.max_growth:.4g} 1/s are not excluded"
