"""What a search of a window found, and the window that it makes of it."""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Complexes
from cea.eigen.spectrum import Window
from cea.eigen.subspace import InvariantSubspace

_MARGIN = 1.05
"""Radius of the disc about the middle of the window relative to half the window."""


@dataclass(frozen=True)
class Disc:
    """A disc of kappa = -lambda^2 in which every eigenvalue of the window was found.

    Parameters
    ----------
    centre, radius
        In 1/s^2.
    """

    centre: float
    radius: float


@dataclass(frozen=True)
class Found:
    """What a search of a window found.

    Parameters
    ----------
    subspace
        Invariant subspace of the eigenvalues found.
    discs
        Discs that are full.
    depth
        Every eigenvalue of the window with Re kappa >= -depth was found (1/s^2).
    bounded
        Whether no eigenvalue of the window has Re kappa < -depth.
    odd
        Whether the sign of a determinant shows that a real kappa is missing.
    counted
        Without friction, eigenvalues below :func:`upper_end` by inertia.
    slices
        Slices in which those about the middle were found; 0 where they were found at once.
    """

    subspace: InvariantSubspace
    discs: tuple[Disc, ...] = ()
    depth: float = 0.0
    bounded: bool = False
    odd: bool = False
    counted: int | None = None
    slices: int = 0

    def window(self, top: float, kappa: Complexes) -> Window:
        """The window, and why it is believed complete.

        Parameters
        ----------
        top
            omega^2 (1/s^2).
        kappa
            The eigenvalues found (1/s^2).
        """
        upper = upper_end(top)
        return Window(
            max_frequency=float(np.sqrt(top)) / (2 * np.pi),
            shift=self.discs[0].centre if self.discs else 0.5 * top,
            radius=self.discs[0].radius if self.discs else 0.0,
            found=len(kappa),
            discs=len(self.discs),
            max_growth=np.inf if self.bounded else float(np.sqrt(max(self.depth, 0.0))),
            bounded=self.bounded,
            odd=self.odd,
            upper=upper,
            found_below=int(np.sum(kappa.real < upper)),
            symmetric_count=self.counted,
            slices=self.slices,
        )


def nearest_window(kappa: float, found: Complexes) -> Window:
    """What a search for the few eigenvalues nearest to kappa (1/s^2) found: no window is full."""
    return Window(
        max_frequency=np.inf,
        shift=kappa,
        radius=float(np.abs(found - kappa).max(initial=0.0)),
        found=len(found),
        discs=1,
        max_growth=0.0,
        bounded=False,
        odd=False,
        upper=np.inf,
        found_below=len(found),
        symmetric_count=None,
    )


def upper_end(top: float) -> float:
    """Upper end of the disc about the middle of a window that ends at omega^2 (1/s^2)."""
    return 0.5 * top * (1 + _MARGIN)
