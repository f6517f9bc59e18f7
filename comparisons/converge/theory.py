"""What theory says that a refinement takes off from the error of an eigenvalue.

The smooth part of a solution and its singular one, where edges of the scene are singular, fall
apart from each other:

- elements f times as many along every direction: by f^(2 p), and f^(2 s) with the exponent s of the
  displacements at a clamped edge;
- a degree p + 1: from an error e to e^((p + 1) / p), as of smooth splines, whose error is
  (phase / 2 pi)^(2 p) to a factor near 1 (:mod:`scenes.resolution`), and to a few times less than
  Lagrange elements reach; of the singular part by ((p + 1) / p)^(4 s);
- a layer more towards singular edges: of the singular part the ratio of the layers to 2 s.

Error bars count on the part that falls more slowly, which is left at the end.
"""

from dataclasses import dataclass
from math import exp, log

from meshes.edge_layers import RATIO
from scenes.refinement import Resolution

_EXPONENT = 0.7
"""Of displacements at a clamped edge (Williams 1952), between 0.6 and 0.75 for usual nu."""
LARGEST_ERROR = 0.1
"""Relative error from which on a mode is not resolved, and a higher degree helps no more."""
SMALLEST_ERROR = 1e-15
_ROUGH = 0.1
"""Part of the singular edges in the error of a first mesh."""
_MOST = log(1e4)
"""Most that one step is trusted to take off, as a logarithm."""


@dataclass(frozen=True)
class Fallen:
    """Logarithms of what refinements took off from the parts of an error.

    Parameters
    ----------
    smooth, rough
        Of the part of smooth solutions, and of that of singular edges.
    """

    smooth: float = 0.0
    rough: float = 0.0

    def __add__(self, other: "Fallen") -> "Fallen":
        return Fallen(self.smooth + other.smooth, self.rough + other.rough)

    def whole(self, *, singular: bool) -> float:
        """Of the sum of both parts, of which the rough one was a tenth where it is there."""
        if not singular:
            return self.smooth
        return -log((1 - _ROUGH) * exp(-self.smooth) + _ROUGH * exp(-self.rough))


def fallen(old: Resolution, new: Resolution, error: float) -> Fallen:
    """What a step takes off from both parts.

    Parameters
    ----------
    old, new
        Resolutions before and after.
    error
        Relative error of the eigenvalue before.
    """
    more = log(new.density / old.density)
    left = log(min(max(error, SMALLEST_ERROR), LARGEST_ERROR))
    finer = left - 2 * old.degree * more
    for degree in range(old.degree, new.degree):
        finer *= (degree + 1) / degree
    layered = more - (new.layers - old.layers) * log(RATIO)
    rough = 2 * _EXPONENT * layered + 4 * _EXPONENT * log(new.degree / old.degree)
    return Fallen(min(left - finer, _MOST), min(rough, _MOST))


def reduction(old: Resolution, new: Resolution, error: float, *, singular: bool) -> float:
    """Logarithm of the factor by which an error falls at least, as :func:`fallen` takes it."""
    parts = fallen(old, new, error)
    return min(parts.smooth, parts.rough) if singular else parts.smooth
