"""Spectra along a line, on a model or by full solves, and thresholds that full solves confirm.

At a threshold found what passes zero, the half distance squared of a pair or a growth rate, is
computed on the pencil itself, and again where its slope takes it: Newton's method with the slope
that the search gives.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from cea.arrays import Complexes
from cea.eigen.block_products import all_inner, times
from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import release
from cea.errors import ConvergenceError, InputError, ResultWarning
from cea.reduced.crossings import Quantity, Threshold, growing_root, passing
from cea.reduced.following import Sample
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.pieces import Values
from cea.reduced.spectrum import ReducedSpectrum, SmallPencil
from cea.reduced.thresholds import Line, thresholds_along
from cea.reduced.window import MARGIN, Window

_ASIDE = 1e-3
"""Relative distance from a pair at which it is looked for: a pencil is singular on it."""
_NEIGHBOURS = 4
"""Modes that are computed there."""
_STEPS = 6
"""Steps of Newton's method."""
_CONVERGED = 1e-13
"""Last step of it, relative to the value."""
_TRAINING = 9
"""Values at which bounds of a basis are looked at, and between which thresholds are sought."""


@dataclass(frozen=True)
class ConfirmedThreshold:
    """A value of a parameter at which a mode begins or ceases to grow.

    Parameters
    ----------
    parameter
        Name of the parameter, or names of those that have the value.
    value
        Its value there.
    eigenvalue
        lambda there (1/s), of two modes that coalesce their mean.
    warnings
        What the value must be read with.
    """

    parameter: str
    value: float
    eigenvalue: complex
    warnings: tuple[ResultWarning, ...] = ()

    @property
    def frequency(self) -> float:
        """Frequency (Hz)."""
        return self.eigenvalue.imag / (2 * np.pi)


Solve = Callable[[float, float], tuple[Modes, Complexes]]
"""Modes at a value up to a frequency (Hz), with left vectors, and derivatives of their lambda."""


def line_of_model(
    small: SmallPencil,
    parameters: Callable[[float], Values],
    rates: Mapping[str, float],
    level: float = 0.0,
    known: Mapping[float, ReducedSpectrum] = MappingProxyType({}),
) -> Line:
    """Spectra of a reduced model along a line; those that are known serve again.

    ``parameters`` gives those at a value of the line, which change at ``rates``; modes that grow by
    more than ``level`` (1/s) count.
    """
    window = replace(small.window, level=level)

    def at(value: float) -> Sample:
        values = parameters(value)
        found = known.get(value) or small.at(values)
        slopes = small.slopes(found, values, rates)
        shapes, bounds = found.right[~small.forces], (found.errors, found.means, found.clusters)
        vectors = shapes / np.linalg.norm(shapes, axis=0)
        return Sample(value, found.z, slopes, *bounds, vectors)

    return Line(window, at)


def line_in_full(solve: Solve, window: Window) -> Line:
    """Spectra by full solves; vectors are told by their parts along the modes solved first."""
    first: list[Complexes] = []

    def at(value: float) -> Sample:
        modes, slopes = solve(value, MARGIN * window.max_frequency)
        z, errors = modes.eigenvalues, modes.growth_uncertainties
        if not first:
            matrices = modes.pencil.at(modes.values)
            first.append(times(matrices.mass, modes.vectors))
            release(matrices)
        vectors = all_inner(first[0], modes.vectors, modes.pencil.comm)
        vectors = vectors / np.maximum(np.linalg.norm(vectors, axis=0), np.finfo(float).tiny)
        numbers = np.arange(len(z))
        if not window.damped:
            errors = errors * (2 * np.abs(z) + errors)
            z, slopes = -(z**2), -2 * z * slopes
        return Sample(value, z, slopes, errors, errors, numbers, vectors)

    return Line(window, at)


def threshold_between(
    line: Line, real: float, flutter: float, frequency: float | None = None, count: int = 3
) -> Threshold:
    """The first threshold from one value on at which a mode begins to grow; without damping a pair.

    Spectra are made at ``count`` values first. That nearest to a frequency (Hz) is taken where one
    is given. InputError is raised when nothing begins to grow, ConvergenceError when an interval
    before it is not resolved.
    """
    if real == flutter:
        raise InputError("flutter", flutter, "another value than real")
    found = thresholds_along(line, np.linspace(real, flutter, count).tolist())
    kinds = ("flutter", "divergence") if line.window.damped else ("flutter",)
    way = 1.0 if flutter > real else -1.0
    begins = [each for each in found.thresholds if way * each.change > 0 and each.kind in kinds]
    begins.sort(key=lambda each: way * each.value)
    if frequency is not None:
        begins.sort(key=lambda each: abs(each.eigenvalue.imag - 2 * np.pi * frequency))
    before = [
        each for each in found.unresolved if not begins or way * each.low < way * begins[0].value
    ]
    if before and (frequency is None or not begins):
        told = ", ".join(f"{each.low:.6g} to {each.high:.6g}" for each in before)
        raise ConvergenceError(f"thresholds may lie where spectra do not tell: {told}")
    if not begins:
        raise InputError(
            "flutter",
            flutter,
            f"a value on the way to which from {real:g} one mode or more begin to grow",
        )
    return begins[0]


def first_threshold(
    driver: EigenSolver,
    parameter: str | Sequence[str],
    real: float,
    flutter: float,
    *,
    max_frequency: float,
    frequency: float | None = None,
) -> ConfirmedThreshold:
    """The first threshold of a pencil on the way between two values, confirmed by full solves.

    Of one parameter, e.g. ``contacts.pad_disc.mu``, or of several that have one value, in a window
    (Hz); other parameters and errors as of :func:`threshold_between`.
    """
    names = [parameter] if isinstance(parameter, str) else list(parameter)
    if not names:
        raise InputError("parameter", parameter, "one or more names")

    def point(value: float) -> Mapping[str, float]:
        return dict.fromkeys(names, value)

    for value in (real, flutter):
        driver.pencil.check(point(value))
    pencil = driver.pencil
    box = dict.fromkeys(names, (min(real, flutter), max(real, flutter)))
    model = ReducedModel(pencil, box, max_frequency)
    try:
        training = np.linspace(real, flutter, _TRAINING).tolist()
        Enrichment(model, driver).cover([point(value) for value in training])
    finally:
        model.free()
    rates = dict.fromkeys(names, 1.0)
    line = line_of_model(model.small, lambda value: pencil.values(point(value)), rates)
    found = threshold_between(line, real, flutter, frequency, _TRAINING)
    told = confirm(driver, point, found, line.window)
    value, root = told or (found.value, found.eigenvalue)
    return ConfirmedThreshold(", ".join(names), value, root)


def confirm(
    driver: EigenSolver,
    point: Callable[[float], Mapping[str, float]],
    found: Threshold,
    window: Window,
) -> tuple[float, complex] | None:
    """A threshold of the pencil itself, beginning at one of a reduced model, and lambda there.

    None where only numbers of growing modes beside it are known, or where it leaves what a
    parameter allows.
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
            driver.pencil.check(point(value))
        except InputError:
            return None
        z = _nearest(driver, point(value), of, window, root)
        root = growing_root(window, of, z)
        step = -float(passing(window, of, z)[0]) / found.slope
        if abs(step) >= before:  # nothing but rounding is left
            break
        value, before = value + step, abs(step)
        if before <= _CONVERGED * abs(value):
            break
    return value, root


def _nearest(
    driver: EigenSolver, point: Mapping[str, float], of: Quantity, window: Window, root: complex
) -> Complexes:
    """The z of the mode, or of the pair, next to lambda."""
    near = (root or 1j * window.end * _ASIDE) * (1 + _ASIDE)
    quadratic = driver.matrices(point).quadratic
    at = -(near**2) if quadratic else float(-(near**2).real)
    wanted = 2 if window.by_growth else _NEIGHBOURS  # the mode and its partner, which is as near
    modes = driver.nearest(at, wanted, point)
    z: Complexes = modes.eigenvalues if window.damped else -(modes.eigenvalues**2)
    if of in ("growth", "end"):
        return z[np.argsort(np.abs(modes.eigenvalues - root))[:1]]
    count = 2 if of == "coalescence" else 1
    return z[np.argsort(np.abs(z - float(-(root**2).real)))[:count]]
