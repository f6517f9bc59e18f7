"""Spectra of a reduced model along a line, and confirmation of thresholds by full solves.

A threshold of the reduced model is refined on the full pencil by a simplified Newton method: the
function that vanishes, the squared half distance of a pair or a growth rate, is computed by full
solves, and its slope is that of the reduced model.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from cea.arrays import Complexes
from cea.eigen.driver import EigenSolver
from cea.errors import ConvergenceError, InputError, ResultWarning, require
from cea.reduced.crossings import Quantity, Threshold, growing_root, passing
from cea.reduced.following import Sample
from cea.reduced.greedy import TOLERANCE, Enrichment, Point
from cea.reduced.model import ReducedModel
from cea.reduced.spectrum import ReducedSpectrum, Window
from cea.reduced.thresholds import Line, thresholds_along

_ASIDE = 1e-3
"""Relative distance of the shift from a pair, at which the pencil is singular."""
_NEIGHBOURS = 4
"""Number of modes computed near a pair."""
_STEPS = 6
"""Largest number of Newton steps."""
_CONVERGED = 1e-13
"""Size of a Newton step relative to the value at convergence."""
_TRAINING = 9
"""Number of values at which bounds of a basis are evaluated, and thresholds are bracketed."""
_MANY, _HELD = 20, 5
"""Number of points along a line from which on a part of the basis is used, and of spectra that it
holds at first."""
_BETTER = 0.5
"""Error bound on the whole basis relative to that on a part below which the part is enlarged."""


@dataclass(frozen=True)
class ConfirmedThreshold:
    """A value of a parameter at which a mode begins or ceases to grow.

    Parameters
    ----------
    parameter
        Name of the parameter, or names of several parameters with equal values.
    value
        Value of the parameter at the threshold.
    eigenvalue
        lambda there (1/s); for two modes that coalesce their mean.
    warnings
        Warnings about the value.
    """

    parameter: str
    value: float
    eigenvalue: complex
    warnings: tuple[ResultWarning, ...] = ()

    @property
    def frequency(self) -> float:
        """Frequency (Hz)."""
        return self.eigenvalue.imag / (2 * np.pi)


class SpectraAlong:
    """Spectra of a reduced model at many points along a line, on a part of its basis.

    The part holds the spectra at some of the points, and where that does not suffice for the
    ``tolerance`` of error bounds also that at a point in question. With few points the whole basis
    is used.
    """

    def __init__(
        self, model: ReducedModel, points: Sequence[Point] = (), tolerance: float = TOLERANCE
    ) -> None:
        self.model, self._part, self._tolerance = model, model, tolerance
        self._held = list[ReducedSpectrum]()
        if len(points) >= _MANY:
            chosen = np.linspace(0, len(points) - 1, _HELD).round().astype(int)
            self._held += [model.at(points[i]) for i in chosen]
            self._part = model.part(self._held)

    def at(self, point: Point) -> tuple[ReducedSpectrum, ReducedModel]:
        """Return the spectrum at a point, and the model in whose coordinates its vectors are."""
        found = self._part.at(point)
        if self._part is self.model or found.worst <= self._tolerance:
            return found, self._part
        whole = self.model.at(point)
        if whole.worst <= _BETTER * found.worst:
            self._held.append(whole)
            self._part = self.model.part(self._held)
        return whole, self.model


def line_of_model(
    spectra: SpectraAlong,
    point: Callable[[float], Mapping[str, float]],
    rates: Mapping[str, float],
    known: Mapping[float, tuple[ReducedSpectrum, ReducedModel]] = MappingProxyType({}),
) -> Line:
    """Return the line of spectra of a reduced model; those in ``known`` are reused.

    ``point`` returns the parameters that vary at a value of the line, which change at ``rates``.
    """

    def at(value: float) -> Sample:
        found, model = known.get(value) or spectra.at(point(value))
        slopes = model.slopes(found, point(value), rates)
        bounds = found.errors, found.means, found.clusters
        return Sample(value, found.z, slopes, *bounds, model.shapes(found))

    return Line(spectra.model.window, at)


def first_threshold(
    driver: EigenSolver,
    parameter: str | Sequence[str],
    real: float,
    flutter: float,
    *,
    max_frequency: float,
    frequency: float | None = None,
) -> ConfirmedThreshold:
    """Return the first threshold after ``real``, confirmed by full solves.

    There a mode (undamped: a pair) begins to grow. ``parameter`` is one name, e.g.
    ``contacts.pad_disc.mu``, or several names whose values are equal. The window ends at
    ``max_frequency`` (Hz). With a ``frequency`` (Hz) the threshold nearest to it is returned.
    InputError when no mode begins to grow, ConvergenceError when an interval before the threshold
    is unresolved.
    """
    names = [parameter] if isinstance(parameter, str) else list(parameter)
    require(bool(names), "parameter", parameter, "one or more names")
    require(real != flutter, "flutter", flutter, "another value than real")

    def point(value: float) -> Mapping[str, float]:
        return dict.fromkeys(names, value)

    for value in (real, flutter):
        driver.pencil.values(point(value))
    box = dict.fromkeys(names, (min(real, flutter), max(real, flutter)))
    training = np.linspace(real, flutter, _TRAINING).tolist()
    model = ReducedModel(driver.pencil, box, max_frequency)
    try:
        Enrichment(model, driver).cover([point(value) for value in training])
    finally:
        model.free()
    line = line_of_model(SpectraAlong(model), point, dict.fromkeys(names, 1.0))
    found = thresholds_along(line, training)
    kinds = ("flutter", "divergence") if line.window.damped else ("flutter",)
    way = 1.0 if flutter > real else -1.0
    begins = [each for each in found.thresholds if way * each.change > 0 and each.kind in kinds]

    def order(each: Threshold) -> float:
        if frequency is None:
            return way * each.value
        return abs(each.eigenvalue.imag - 2 * np.pi * frequency)

    first = min(begins, key=order, default=None)
    end = np.inf if first is None else way * first.value
    before = [each for each in found.unresolved if way * each.low < end]
    if before and (first is None or frequency is None):
        where = ", ".join(f"{each.low:.6g} to {each.high:.6g}" for each in before)
        raise ConvergenceError(f"unresolved intervals may contain thresholds: {where}")
    if first is None:
        allowed = f"a value such that at least one mode begins to grow between {real:g} and it"
        raise InputError("flutter", flutter, allowed)
    confirmed = confirm(driver, point, first, line.window)
    value, root = confirmed or (first.value, first.eigenvalue)
    return ConfirmedThreshold(", ".join(names), value, root)


def confirm(
    driver: EigenSolver,
    point: Callable[[float], Mapping[str, float]],
    found: Threshold,
    window: Window,
) -> tuple[float, complex] | None:
    """Return a threshold of the full pencil near one of a reduced model, and lambda there.

    None where only the numbers of growing modes beside it are known, or where an iterate is not an
    allowed value of the parameter.
    """
    if not found.slope:
        return None
    of: Quantity = "growth" if window.by_growth else "coalescence"
    if found.kind == "window":
        of = "end"
    elif found.kind == "divergence" and of == "coalescence":
        of = "zero"
    value, root, before = found.value, found.eigenvalue, np.inf
    for _ in range(_STEPS):
        try:
            driver.pencil.values(point(value))
        except InputError:
            return None
        z = _nearest(driver, point(value), of, window, root)
        root = growing_root(window, of, z)
        step = -float(passing(window, of, z)[0]) / found.slope
        if abs(step) >= before:  # steps consist of rounding
            break
        value, before = value + step, abs(step)
        if before <= _CONVERGED * abs(value):
            break
    return value, root


def _nearest(
    driver: EigenSolver, point: Mapping[str, float], of: Quantity, window: Window, root: complex
) -> Complexes:
    """Return z of the mode, or of the pair, nearest to lambda."""
    near = (root or 1j * window.end * _ASIDE) * (1 + _ASIDE)
    quadratic = driver.matrices(point).quadratic
    at = -(near**2) if quadratic else float(-(near**2).real)
    wanted = 2 if window.by_growth else _NEIGHBOURS  # the mode and a partner at equal distance
    modes = driver.nearest(at, wanted, point)
    z: Complexes = modes.eigenvalues if window.damped else -(modes.eigenvalues**2)
    if of in ("growth", "end"):
        return z[np.argsort(np.abs(modes.eigenvalues - root))[:1]]
    count = 2 if of == "coalescence" else 1
    return z[np.argsort(np.abs(z - float(-(root**2).real)))[:count]]
