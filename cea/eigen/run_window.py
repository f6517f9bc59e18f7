"""The window of a run: searched a little beyond its end, for modes that grow there."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.modes import Modes, warnings_of
from cea.eigen.quadratic_window import QuadraticWindow
from cea.errors import ConvergenceError
from cea.timing import StageTimer

ABOVE = 1.05
"""End of the search relative to that of the window."""


def run_window(
    driver: KrylovSchur,
    max_frequency: float,
    changes: Mapping[str, float] | None = None,
    *,
    min_growth: float | None = None,
    left: bool = False,
    timer: StageTimer | None = None,
) -> Modes:
    """Modes up to a frequency, with what a reader of them should know of those above.

    Parameters and errors are those of :meth:`cea.eigen.krylov_schur.KrylovSchur.solve`. The window
    names the modes that grow up to 5 percent above its end, and where it is empty the lowest mode.
    Where nothing can grow for the structure of the problem, nothing is searched above the end.
    """
    above = 1.0 if driver.conservative(changes) else ABOVE
    try:
        wider = driver.solve(
            above * max_frequency, changes, min_growth=min_growth, left=left, timer=timer
        )
    except ConvergenceError as error:
        if isinstance(error.best, Modes):
            error.best = _up_to(error.best, max_frequency, min_growth)
        raise
    modes = _up_to(wider, max_frequency, min_growth)
    if len(modes) or modes.window.odd:
        return modes
    window = replace(modes.window, lowest=_lowest(driver, max_frequency, changes))
    return replace(modes, window=window)


def _up_to(wider: Modes, max_frequency: float, min_growth: float | None) -> Modes:
    """Modes of a window that was searched beyond its end."""
    beyond = wider.frequencies > max_frequency
    grow = beyond & (wider.growth_rates > wider.growth_uncertainties)
    pairs = np.column_stack([wider.frequencies, wider.growth_rates])[grow]
    window = replace(
        wider.window, max_frequency=max_frequency, growing_above=tuple(map(tuple, pairs.tolist()))
    )
    kept = ~beyond
    if isinstance(window, QuadraticWindow) and min_growth is None:  # it is relative to the end
        least = window.min_growth * max_frequency / wider.window.max_frequency
        window, kept = replace(window, min_growth=least), kept & (wider.growth_rates >= least)
    modes = replace(wider[np.flatnonzero(kept)], window=window)
    return replace(modes, warnings=warnings_of(modes))


def _lowest(driver: KrylovSchur, end: float, changes: Mapping[str, float] | None) -> float | None:
    """Frequency (Hz) of the lowest mode, which lies above the end of an empty window (Hz)."""
    try:
        found = driver.nearest(0.5 * (2 * np.pi * end) ** 2, 1, changes).frequencies
    except ConvergenceError:  # there may be no mode at all
        return None
    return min(found[found > end].tolist(), default=None)
