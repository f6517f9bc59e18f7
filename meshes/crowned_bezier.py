"""Rational Bezier patches of crowned shapes, exact: fitted at as many points as needed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import comb

from meshes.crowned import Crowned

Floats = NDArray[np.float64]


def crowned_bezier(
    shape: Crowned, degrees: Sequence[int], control_points: Floats, weights: Floats
) -> tuple[tuple[int, ...], Floats, Floats]:
    """Raise the degree of a patch of the base to what the crown needs, and crown it.

    The crowned coordinate times the weight function is a polynomial of the raised degrees, and so
    is known from its values on a grid.

    Parameters
    ----------
    shape
        The crowned shape.
    degrees
        Degrees of the patch of its base, one Bezier element.
    control_points
        Its control points (m), shape (n1, ..., dim), not multiplied by the weights.
    weights
        Its weights, shape (n1, ...).

    Returns
    -------
    degrees : tuple
        Raised degrees: 2 along the directions that are bent.
    control_points : ndarray
        Control points (m) of the crowned patch.
    weights : ndarray
        Its weights.
    """
    raised = tuple(max(p, 2) if axis in shape.bent else p for axis, p in enumerate(degrees))
    net = np.concatenate([control_points * weights[..., None], weights[..., None]], axis=-1)
    for axis, (p, q) in enumerate(zip(degrees, raised, strict=True)):
        net = _along(net, axis, _bernstein(p, np.linspace(0, 1, q + 1)))
    weight = net[..., -1:]
    net = np.concatenate([weight * shape.crown(net[..., :-1] / weight), weight], axis=-1)
    for axis, q in enumerate(raised):
        net = _along(net, axis, np.linalg.inv(_bernstein(q, np.linspace(0, 1, q + 1))))
    return raised, net[..., :-1] / net[..., -1:], net[..., -1]


def _bernstein(degree: int, t: Floats) -> Floats:
    """Values of the Bernstein polynomials, shape (len(t), degree + 1)."""
    k = np.arange(degree + 1)
    return comb(degree, k) * t[:, None] ** k * (1 - t[:, None]) ** (degree - k)


def _along(net: Floats, axis: int, matrix: Floats) -> Floats:
    """Combine control points along one axis."""
    return np.moveaxis(np.tensordot(matrix, net, axes=(1, axis)), 0, axis)
