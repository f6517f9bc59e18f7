"""Complete lists of eigenvalues of a characteristic function, with the digits they hold."""

import math
from dataclasses import dataclass, replace
from typing import Protocol, Self

from flint import acb, arb, ctx

from cea.errors import ConvergenceError, InputError
from comparisons.exact.numbers import check_window
from comparisons.exact.roots import Box, EdgeTooClose, Root, RootFinder, polish

DIGITS = 25


class Characteristic(Protocol):
    """A problem whose eigenvalues are the roots of an entire function of ``lambda^2``."""

    @property
    def real(self) -> bool:
        """Whether the function is real for real arguments."""

    def scale(self) -> float:
        """A frequency near the lowest."""

    def turning(self, frequency: float) -> float:
        """Turning of the function's phase with lambda: its travel times, up to a frequency."""

    def for_frequency(self, frequency: float) -> Self:
        """The problem truncated finely enough for eigenvalues up to a frequency."""

    def refined(self) -> Self:
        """The problem truncated later; itself where nothing is, or far beyond all need."""

    def closed_form(self, frequency: float) -> list[acb]:
        """Eigenvalues beside the roots, of modes that never feel the contact."""

    def __call__(self, kappa: acb) -> acb:
        """Characteristic function at ``kappa = lambda^2``."""


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues with Im >= 0 in a window, sorted by frequency.

    Parameters
    ----------
    roots
        Roots of the characteristic function and the digits they hold.
    contact_free
        Imaginary eigenvalues of closed form, of modes that never feel the contact.
    box
        The window: complete in it, by the argument principle.
    """

    roots: list[Root]
    contact_free: list[acb]
    box: Box

    @property
    def values(self) -> list[complex]:
        """Roots in double precision."""
        return [complex(root.value) for root in self.roots]


def spectrum(
    problem: Characteristic,
    max_frequency: float | None = None,
    count: int | None = None,
    max_growth: float | None = None,
    digits: int = DIGITS,
) -> Spectrum:
    """All eigenvalues of a window, or the lowest few.

    Parameters
    ----------
    problem
        Characteristic function.
    max_frequency
        Upper end of Im lambda.
    count
        Instead: number of roots; the window grows until it holds them.
    max_growth
        Bound of abs(Re lambda); half of the frequency by default.
    digits
        Digits aimed at.

    Raises
    ------
    InputError
        Unless exactly one of ``max_frequency`` and ``count`` is given, positive.
    """
    check_window(max_frequency, count)
    if max_growth is not None and not max_growth > 0:
        raise InputError("max_growth", max_growth, "a positive number")
    frequency = 2 * problem.scale() if max_frequency is None else max_frequency
    while True:
        found = _window(problem.for_frequency(frequency), frequency, max_growth, digits)
        if count is None:
            return found
        if len(found.roots) >= count:
            last = float(found.roots[count - 1].value.imag)
            free = [value for value in found.contact_free if float(value.imag) <= last]
            box = replace(found.box, top=last)
            return Spectrum(found.roots[:count], free, box)
        frequency *= 1.5


def _window(
    problem: Characteristic, frequency: float, max_growth: float | None, digits: int
) -> Spectrum:
    growth = max_growth or frequency / 2
    finder = RootFinder(problem, problem.turning(frequency), problem.real)
    for widening in (0.0, 1.7e-3, 4.1e-3, 7.3e-3):
        box = Box(-growth * (1 + widening), growth * (1 + widening), 0, frequency * (1 + widening))
        try:
            starts = finder.roots(box, finder.count(box))
        except EdgeTooClose:
            continue
        break
    else:
        raise ConvergenceError(f"roots crowd the edge of the window up to {frequency}")
    roots = [_finish(problem, start, digits) for start in starts]
    with ctx.workdps(2 * digits):
        free = problem.closed_form(frequency)
    kept = [root for root in roots if float(root.value.imag) <= frequency]
    kept.sort(key=lambda root: (float(root.value.imag), float(root.value.real)))
    free.sort(key=lambda value: float(value.imag))
    return Spectrum(kept, free, replace(box, top=frequency))


def _finish(problem: Characteristic, start: complex, digits: int) -> Root:
    """Polish, check the truncation, and put on the axis what a real function must have there."""
    root = polish(problem, start, digits)
    while (refined := problem.refined()) is not problem:
        again = polish(refined, complex(root.value), digits)
        agreed = agreement(root.value, again.value, digits)
        problem, root = refined, Root(again.value, min(again.digits, agreed))
        if agreed >= digits:
            break
    real, imaginary = root.value.real, root.value.imag
    with ctx.workdps(2 * digits):
        # The mirror image of a simple root is a root: one within the error is the root itself.
        small = abs(root.value) * 10 ** acb(-min(root.digits, digits) + 2).real
        if problem.real and abs(real) < small:
            return Root(acb(0, imaginary), root.digits)
        if problem.real and abs(imaginary) < small:
            return Root(acb(abs(real), 0), root.digits)
    return root


def agreement(x: acb, y: acb, digits: int) -> int:
    """Digits two numbers share."""
    with ctx.workdps(2 * digits):
        apart = abs(x - y) / abs(y)
        if apart.abs_upper() < arb(10) ** (-2 * digits):
            return 2 * digits
        return math.floor(-float(apart.abs_upper().log()) / math.log(10))
