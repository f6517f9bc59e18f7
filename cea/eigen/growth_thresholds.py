"""Thresholds of stability: values of a parameter at which the fastest mode ceases to decay.

With damping every mode of a stable system decays, and the largest growth rate of a window is a
continuous function of a parameter that passes through zero where the system becomes unstable. It
has a finite slope there but for coalescences, which damping makes rare.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from cea.arrays import Complexes, Floats
from cea.eigen.classify import classify
from cea.eigen.thresholds import Threshold, ThresholdDriver, names_of
from cea.errors import ConvergenceError, InputError


def growth_threshold(
    driver: ThresholdDriver,
    parameter: str | Sequence[str],
    stable: float,
    unstable: float,
    *,
    max_frequency: float,
    tolerance: float = 1e-12,
) -> Threshold:
    """Where a damped system becomes unstable as a parameter changes.

    Parameters
    ----------
    driver
        What solves the pencil.
    parameter
        Name of a parameter of the pencil, e.g. ``contacts.pad_disc.mu``; or of several, which have
        one value.
    stable, unstable
        Values on either side: every mode decays at one, and one grows at the other. Which is the
        larger does not matter.
    max_frequency
        Upper end of the modes that are looked at (Hz).
    tolerance
        Error of the value relative to the larger one.

    Raises
    ------
    InputError
        When there is no such parameter, a mode does not decay at ``stable``, or none grows at
        ``unstable``.
    ConvergenceError
        When a window on the way is not complete.
    """
    names = names_of(driver, parameter)
    told = ", ".join(names)
    solves, factorisations = driver.solves, driver.factorisations
    solved: dict[float, tuple[Complexes, Floats]] = {}

    def at(value: float) -> tuple[Complexes, Floats]:
        """Eigenvalues of the window and what their growth may be off by; no vectors are kept."""
        if value not in solved:
            modes = driver.solve(max_frequency, dict.fromkeys(names, value))
            if not modes.window.complete:
                raise ConvergenceError(
                    f"at {told} = {value:.6g} {modes.window.evidence}", best=modes
                )
            solved[value] = modes.eigenvalues, modes.growth_uncertainties
        return solved[value]

    def fastest(value: float) -> complex:
        """Where the window is empty all decay faster than it reaches: any such rate will do."""
        values, _ = at(value)
        return complex(
            values[np.argmax(values.real)] if len(values) else -2 * np.pi * max_frequency
        )

    for name, value in (("stable", stable), ("unstable", unstable)):
        values, uncertainties = at(value)
        words = classify(values.real, uncertainties, 0.0, False)
        if not (set(words) <= {"stable"} if name == "stable" else name in words):
            needed = "every mode decays" if name == "stable" else "a mode grows"
            raise InputError(name, value, f"a value of {told} at which {needed}")
    scale = max(abs(stable), abs(unstable))
    value = float(brentq(lambda each: fastest(each).real, stable, unstable, xtol=tolerance * scale))
    return Threshold(
        told,
        value,
        fastest(value),
        driver.solves - solves,
        driver.factorisations - factorisations,
    )
