"""What theory says that a refinement takes off from the error of an eigenvalue.

The smooth part of a solution and its singular one, where edges of the scene are singular, fall
apart from each other:

- elements f times as many along every direction: by f^(2 p), and f^(2 s) with the exponent s of the
  displacements at a clamped edge;
- a degree p + 1: from an error e to e^((p + 1) / p), as of smooth splines, whose error is
  (phase / 2 pi)^(2 p) to a factor near 1 (:mod:`scenes.resolution`), and to a few times less than
  Lagrange elements reach; of the singular part by ((p + 1) / p)^(4 s);
- a layer more towards singular edges: of the singular part the ratio of the layers to 2 s.

The part that falls more slowly is the one that is left at the end: it alone counts.
"""

from math import log

from scenes.refinement import RATIO, Resolution

_EXPONENT = 0.7
"""Of displacements at a clamped edge (Williams 1952), between 0.6 and 0.75 for usual nu."""
_LARGEST_ERROR = 0.1
"""Relative error from which on a mode is not resolved, and a higher degree helps no more."""
_SMALLEST_ERROR = 1e-15
_MOST = log(1e4)
"""Most that one step is trusted to take off, as a logarithm."""


def reduction(old: Resolution, new: Resolution, error: float, *, singular: bool) -> float:
    """Logarithm of the factor by which an error falls.

    Parameters
    ----------
    old, new
        Resolutions before and after.
    error
        Relative error of the eigenvalue before.
    singular
        Whether edges of the scene are singular.
    """
    more = log(new.density / old.density)
    left = log(min(max(error, _SMALLEST_ERROR), _LARGEST_ERROR))
    finer = left - 2 * old.degree * more
    for degree in range(old.degree, new.degree):
        finer *= (degree + 1) / degree
    smooth = left - finer
    if not singular:
        return min(smooth, _MOST)
    layered = more - (new.layers - old.layers) * log(RATIO)
    rough = 2 * _EXPONENT * layered + 4 * _EXPONENT * log(new.degree / old.degree)
    return min(smooth, rough, _MOST)
