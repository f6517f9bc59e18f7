"""How short the waves of modes are for their elements, from the modes themselves.

Along the edges of the elements of a surface, phi^2 = int |du/dxi|^2 / int |u|^2 with xi from 0 to 1
in each is the square of the phase that a wave passes through in an element. Its relative error of
frequency on uniform elements of degree p is, for small phi,

    1/2 (p! / (2 p)!)^2 phi^(2p) / (2 p + 1)      Lagrange elements (Ainsworth 2004)
    1/2 |B_2p| / (2 p)! phi^(2p)                  smooth splines (Hughes, Reali & Sangalli 2008)

with the Bernoulli numbers B: phi^2 / 24 where p = 1, phi^4 / 1440 where p = 2, for both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial, pi

import numpy as np
from numpy.typing import NDArray
from scipy.special import bernoulli

from cea.arrays import Complexes, Floats
from cea.surface import Surface
from cea.surface_points import SurfaceCells, SurfaceCoordinates

_NYQUIST = 0.8
"""Part of the shortest wave that has a function for each half up to which a wave is one at all."""

Shapes = Callable[[SurfaceCoordinates], Complexes]
"""Displacements of all modes at points of a surface, shape (n, dim, modes)."""


@dataclass(frozen=True)
class Waves:
    """Modes on one surface.

    Parameters
    ----------
    phases
        Largest phase phi of each mode over the directions of the elements, shape (modes,).
    amplitudes
        Root mean square of their displacements, shape (modes,).
    """

    phases: Floats
    amplitudes: Floats


def waves(surface: Surface, shapes: Shapes) -> Waves:
    """Phases in the elements of a surface; collective where the shapes are."""
    cells = surface.cells()
    steps = max(2, cells.degree)
    at, layout = _along_edges(cells, steps)
    u = shapes(at)
    u = u.reshape(*layout, *u.shape[1:])  # cells, edges, points, components, modes
    middle = 0.5 * (u[:, :, 1:] + u[:, :, :-1])
    change = steps**2 * _squares(np.diff(u, axis=2))
    size = _squares(middle)
    phases = np.sqrt(change / np.maximum(size, np.finfo(float).tiny)).max(axis=0)
    return Waves(phases, np.sqrt(size.sum(axis=0) / (len(at) or 1)))


def _squares(values: Complexes) -> Floats:
    """Sums of squares for each edge of a cell and each mode."""
    return (np.abs(values) ** 2).sum(axis=(0, 2, 3))


def _along_edges(
    cells: SurfaceCells, steps: int
) -> tuple[SurfaceCoordinates, tuple[int, int, int]]:
    """Equally spaced points along an edge of each cell for each of its directions."""
    corners = cells.corners
    edges = corners.shape[2]
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    points = np.stack(
        [
            corners[:, i, None] * (1 - t) + corners[:, i + 1, None] * t
            for i in range(edges)  # one along curves, two along surfaces
        ],
        axis=1,
    )
    layout = points.shape[:3]
    element = np.repeat(cells.element, edges * (steps + 1))
    return SurfaceCoordinates(element, points.reshape(-1, corners.shape[2])), layout


def unresolved(phases: Floats, degree: int, *, smooth: bool, error: float) -> NDArray[np.bool_]:
    """Which waves are too short for elements of a degree."""
    shortest = _NYQUIST * pi * (1 if smooth else degree)
    return (dispersion(phases, degree, smooth=smooth) > error) | (phases > shortest)


def dispersion(phases: Floats, degree: int, *, smooth: bool) -> Floats:
    """Relative errors of frequency that elements of a degree make of waves of given phases."""
    twice = 2 * degree
    if smooth:
        factor = abs(bernoulli(twice)[twice]) / factorial(twice)
    else:
        factor = (factorial(degree) / factorial(twice)) ** 2 / (twice + 1)
    return 0.5 * factor * phases**twice
