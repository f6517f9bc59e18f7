"""Thresholds of stability: values of a parameter at which the fastest mode ceases to decay.

With damping every mode of a stable system decays, and the largest growth rate of a window is a
continuous function of a parameter that passes through zero where the system becomes unstable. It
has a finite slope there but for coalescences, which damping makes rare.
"""

import numpy as np
from scipy.optimize import brentq

from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.modes import Modes
from cea.eigen.thresholds import Threshold
from cea.errors import ConvergenceError, InputError


def growth_threshold(
    driver: KrylovSchur,
    parameter: str,
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
        Name of a parameter of the pencil, e.g. ``contacts.pad_disc.mu``.
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
    driver.pencil.parameter(parameter)
    solves, factorisations = driver.solves, driver.factorisations
    last: dict[float, complex] = {}

    def solved(value: float) -> Modes:
        modes = driver.solve(max_frequency, {parameter: value})
        if not modes.window.complete:
            raise ConvergenceError(
                f"at {parameter} = {value:.6g} {modes.window.evidence}", best=modes
            )
        return modes

    def growth(value: float) -> float:
        modes = solved(value)
        fastest = int(np.argmax(modes.growth_rates)) if len(modes) else None
        last[value] = complex(modes.eigenvalues[fastest]) if fastest is not None else -np.inf
        return last[value].real

    for name, value, sign in (("stable", stable, -1), ("unstable", unstable, 1)):
        modes = solved(value)
        sure = sign * modes.growth_rates - modes.growth_uncertainties > 0
        if not (sure.all() if sign < 0 else sure.any()):
            word = "every mode decays" if sign < 0 else "a mode grows"
            raise InputError(name, value, f"a value of {parameter} at which {word}")
    scale = max(abs(stable), abs(unstable))
    value = float(brentq(growth, stable, unstable, xtol=tolerance * scale))
    if value not in last:
        growth(value)
    return Threshold(
        parameter,
        value,
        last[value],
        driver.solves - solves,
        driver.factorisations - factorisations,
    )
