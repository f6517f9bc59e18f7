"""A cantilever thinner than the digits of a double bear."""

from collections.abc import Iterator

import numpy as np

from comparisons.stability.parts.case import ACCURATE, HONEST, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.scenes import body, rectangle, scene
from comparisons.stability.parts.ways import ALONE

_LENGTH, _NU, _DEGREE = 2.0, 0.3, 3
_BENDING = np.array([1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349, 14.1371683910])
"""beta L of a cantilever: cos x cosh x = -1."""


@case("Thin cantilevers, length over height 100 to 1e5", subject="geometry")
def thin_strip() -> Iterator[Run]:
    """Stiffness of bending is (h/L)^4 of that of the elements: its digits are lost from 1e3 on."""
    for slenderness in (1e2, 1e3, 2e4, 1e5):
        height = _LENGTH / slenderness
        strip = scene(
            {
                "strip": body(
                    rectangle((_LENGTH, height)),
                    (20, 1),
                    degree=_DEGREE,
                    nu=_NU,
                    supports=[{"surface": "x_min"}],
                )
            }
        )
        for way in ALONE:
            yield Run(
                f"L/h = {slenderness:.0e}",
                way,
                OfScene(way.of(strip)),
                formula(_euler_bernoulli(height)),
                ACCURATE if slenderness < 1e3 else HONEST,
                tolerance=5e-3,
                lowest=3,
            )


def _euler_bernoulli(height: float) -> list[complex]:
    """Bending of a plate strip in plane strain with E = rho = 1."""
    omega = (_BENDING / _LENGTH) ** 2 * height / np.sqrt(12 * (1 - _NU**2))
    return [1j * value for value in omega]
