"""All roots of a characteristic function in a window: counting, separation, refinement."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

from flint import acb, arb, ctx

from cea.errors import ConvergenceError

Function = Callable[[acb], acb]

_STARTS = 8  # starting points of Muller's method in a box
_FEW = 3  # a box with more roots is divided first


class EdgeTooClose(Exception):  # noqa: N818
    """A root lies too close to a contour to decide whether it is inside."""


@dataclass(frozen=True)
class Box:
    """Rectangle ``left < Re < right``, ``bottom < Im < top``; open below where bottom is 0.

    Points x and -x of a bottom edge on the real axis have the same ``lambda^2``, so the other
    three edges form a closed path in the plane of ``lambda^2``.
    """

    left: float
    right: float
    bottom: float
    top: float

    def __contains__(self, z: complex) -> bool:
        return self.left <= z.real <= self.right and self.bottom <= z.imag <= self.top

    @property
    def path(self) -> list[complex]:
        """Corners, counterclockwise."""
        lower_right, upper_right = complex(self.right, self.bottom), complex(self.right, self.top)
        upper_left, lower_left = complex(self.left, self.top), complex(self.left, self.bottom)
        path = [lower_right, upper_right, upper_left, lower_left]
        return [*path, lower_right] if self.bottom else path

    def halves(self, part: float) -> "tuple[Box, Box]":
        """Divide the box across its longer side at a fraction of it."""
        width, height = self.right - self.left, self.top - self.bottom
        if height > width or self.bottom == 0:
            cut = self.bottom + part * height
            return (
                Box(self.left, self.right, self.bottom, cut),
                Box(self.left, self.right, cut, self.top),
            )
        cut = self.left + part * width
        return (
            Box(self.left, cut, self.bottom, self.top),
            Box(cut, self.right, self.bottom, self.top),
        )


@dataclass
class RootFinder:
    """Roots of ``f(lambda^2)`` in boxes of the upper half plane of lambda."""

    f: Function  # entire function of lambda^2
    # rate of the phase of f along a path away from roots (rad per unit of lambda): first steps are
    # so short that none can contain a whole turn
    turning: float
    real: bool = False  # whether f is real for real arguments: f is then symmetric in Re lambda
    precision: int = 96  # bits of the search
    _values: dict[complex, tuple[float, float]] = field(default_factory=dict, repr=False)

    def count(self, box: Box) -> int:
        """Number of roots in a box by the argument principle.

        Steps are bisected until the phase changes by less than 0.8 in both halves and the modulus
        at the midpoint is near the geometric mean of the ends.
        """
        path = box.path
        turn = 0.0
        for start, end in pairwise(path):
            steps = 4 + math.ceil(abs(end - start) * self.turning / 2)
            nodes = [start + (end - start) * i / steps for i in range(steps + 1)]
            turn += sum(self._turn(a, b, abs(end - start) * 1e-9) for a, b in pairwise(nodes))
        return round(turn / math.tau)

    def roots(self, box: Box, count: int) -> list[complex]:
        """Return approximations of all ``count`` roots in a box."""
        if count == 0:
            return []
        if count <= _FEW and len(found := self._hunt(box, count)) == count:
            return found
        if box.top - box.bottom < 1e-9 * box.top:
            middle = complex((box.left + box.right) / 2, (box.bottom + box.top) / 2)
            return [middle] * count
        for part in (0.5231, 0.4417, 0.6113, 0.3571):
            lower, upper = box.halves(part)
            try:
                inside = self.count(lower)
            except EdgeTooClose:
                continue
            return self.roots(lower, inside) + self.roots(upper, count - inside)
        raise ConvergenceError(f"no cut separates the {count} roots in {box}")

    def _turn(self, a: complex, b: complex, shortest: float) -> float:
        middle = (a + b) / 2
        (log_a, phase_a), (log_m, phase_m), (log_b, phase_b) = map(self._value, (a, middle, b))
        first = math.remainder(phase_m - phase_a, math.tau)
        second = math.remainder(phase_b - phase_m, math.tau)
        smooth = abs(log_m - (log_a + log_b) / 2) < 0.5
        if smooth and max(abs(first), abs(second)) < 0.8:
            return first + second
        if abs(b - a) < shortest:
            raise EdgeTooClose
        return self._turn(a, middle, shortest) + self._turn(middle, b, shortest)

    def _value(self, z: complex) -> tuple[float, float]:
        if self.real and z.real < 0:
            modulus, phase = self._value(complex(-z.real, z.imag))
            return modulus, -phase
        if z not in self._values:
            precision = self.precision
            for _ in range(4):
                with ctx.workprec(precision):
                    value = self.f(acb(z) ** 2)
                    if value.rel_accuracy_bits() > 10:
                        self._values[z] = (
                            float(abs(value).log()),
                            float(value.arg() if value.real > 0 else (-value).arg())
                            + (0 if value.real > 0 else math.pi),
                        )
                        break
                precision *= 2
            else:
                raise EdgeTooClose
        return self._values[z]

    def _hunt(self, box: Box, count: int) -> list[complex]:
        """Search roots by Muller's method from several points, deflating converged roots."""
        inside: list[complex] = []
        known: list[complex] = []
        centre = (box.left + box.right) / 2
        for i in range(_STARTS):
            height = box.bottom + (box.top - box.bottom) * ((0.5 + i * 0.618034) % 1)
            root = self._muller(complex(centre, height), box, known)
            if root is None:
                continue
            known.append(root)
            if root in box:
                inside.append(root)
            if len(inside) == count:
                break
        return inside

    def _muller(self, start: complex, box: Box, known: list[complex]) -> complex | None:
        """Return the root the iteration converges to; None if it diverges or leaves the box."""

        def deflated(z: acb) -> acb:
            value = self.f(z * z).mid()
            for root in known:
                value = value / (z - acb(root)) / (z + acb(root))
            return value.mid()

        size = box.right - box.left + box.top - box.bottom
        step = 0.02 * (box.top - box.bottom)
        with ctx.workprec(self.precision):
            z = [acb(start - step), acb(start + step), acb(start)]
            w = [deflated(point) for point in z]
            for _ in range(20):
                new = _parabola_root(z, w)
                if new is None or not new.is_finite() or abs(complex(new) - start) > size:
                    return None
                z, w = [*z[1:], new], [*w[1:], deflated(new)]
                if float(abs(z[2] - z[1])) < 1e-10 * float(abs(z[2])):
                    root = complex(new)
                    return root if root.imag >= 0 else -root
        return None


def _parabola_root(z: list[acb], w: list[acb]) -> acb | None:
    """Root nearest to z[2] of the parabola through three points."""
    if any((z[i] - z[j]).is_zero() for i, j in ((0, 1), (1, 2), (0, 2))):
        return None
    first = (w[2] - w[1]) / (z[2] - z[1])
    second = (first - (w[1] - w[0]) / (z[1] - z[0])) / (z[2] - z[0])
    slope = first + second * (z[2] - z[1])
    spread = (slope * slope - 4 * w[2] * second).sqrt()
    plus, minus = slope + spread, slope - spread
    denominator = plus if float(abs(plus).mid().log()) > float(abs(minus).mid().log()) else minus
    return (z[2] - 2 * w[2] / denominator).mid()


@dataclass(frozen=True)
class Root:
    """Root of a characteristic function."""

    value: acb  # lambda
    digits: int  # correct digits, from the ball of f at the root over its slope


def polish(f: Function, start: complex, digits: int) -> Root:
    """Return the root of ``f(lambda^2)`` near ``start``, by Newton's method to some digits.

    The slope is a central difference. To first order, the error of the root is bounded by the ball
    of f at the root over the slope.
    """
    precision = math.ceil(3.33 * (2 * digits + 20))
    with ctx.workprec(precision):
        z = acb(start)
        step = arb(10) ** (-(digits // 2 + 5)) * abs(z)
        for _ in range(60):
            slope = ((f((z + step) ** 2) - f((z - step) ** 2)) / (2 * step)).mid()
            change = f(z * z) / slope
            z = (z - change).mid()
            if float(abs(change).abs_upper().log()) < -math.log(10) * (digits + 3) + math.log(
                max(float(abs(z)), 1e-300)
            ):
                break
        error = f(z * z) / slope
        relative = abs(error).abs_upper() / abs(z).abs_lower()
        held = -float(relative.log()) / math.log(10) if relative > 0 else 2.0 * digits
        return Root(z, max(0, min(math.floor(held), 2 * digits)))
