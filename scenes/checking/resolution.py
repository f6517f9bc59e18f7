"""Modes whose waves are too short for the elements of a contact."""

from collections.abc import Callable, Mapping
from functools import partial
from math import factorial, pi

import numpy as np
from numpy.typing import NDArray
from scipy.special import bernoulli

from cea.arrays import Complexes, Floats
from cea.body import Body
from cea.errors import ResultWarning
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from scenes.checking.warnings import warning
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

_SHORT = 0.02
"""Relative error of frequency from which a mode is too short for its mesh."""
_STILL = 0.1
"""Amplitude of a side, relative to that of the other, below which its waves do not count."""
_NYQUIST = 0.8
"""Part of the shortest wave that has a function for each half up to which a wave is one at all."""

Shapes = Callable[[SurfaceCoordinates], Complexes]
"""Displacements of all modes at points of a surface, shape (n, dim, modes)."""


def short_modes(
    scene: Scene,
    bodies: Mapping[str, Body],
    shapes: Callable[[str, SurfaceCoordinates], Complexes],
    count: int,
) -> tuple[ResultWarning, ...]:
    """Modes whose waves are too short for the elements of a contact; collective."""
    short, worst = np.zeros(count, dtype=bool), 0.0
    for spec in scene.contacts.values() if count else ():
        sides = {}
        for place in (spec.a, spec.b):
            body, surface = place.split(".")
            sides[body] = _waves(bodies[body].surfaces[surface], partial(shapes, place))
        largest = np.max([amplitudes for _, amplitudes in sides.values()], axis=0)
        for body, (phases, amplitudes) in sides.items():
            found = _unresolved(phases, scene.bodies[body])
            found &= amplitudes > _STILL * largest
            short |= found
            worst = max(worst, float(phases[found].max(initial=0.0)))
    if not short.any():
        return ()
    numbers, elements = (np.flatnonzero(short) + 1).tolist(), 2 * np.pi / worst
    told = "modes {modes} have waves of down to {elements_per_wave:.2g} elements of their contact"
    return (warning("short-modes", told, modes=numbers, elements_per_wave=elements),)


def _waves(surface: Surface, shapes: Shapes) -> tuple[Floats, Floats]:
    """Largest phase phi of each mode over the directions of the elements, and its amplitude.

    Along the edges of the elements of a surface, phi^2 = int |du/dxi|^2 / int |u|^2 with xi from 0
    to 1 in each is the square of the phase that a wave passes through in an element. The amplitude
    is the root mean square of the displacements; collective where the shapes are.
    """
    cells = surface.cells()
    steps, corners = max(2, cells.degree), cells.corners
    edges = corners.shape[2]  # one along curves, two along surfaces
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    points = np.stack(
        [corners[:, i, None] * (1 - t) + corners[:, i + 1, None] * t for i in range(edges)], axis=1
    )
    element = np.repeat(cells.element, edges * (steps + 1))
    u = shapes(SurfaceCoordinates(element, points.reshape(-1, edges)))
    u = u.reshape(*points.shape[:3], *u.shape[1:])  # cells, edges, points, components, modes
    change = steps**2 * _squares(np.diff(u, axis=2))
    size = _squares(0.5 * (u[:, :, 1:] + u[:, :, :-1]))
    phases = np.sqrt(change / np.maximum(size, np.finfo(float).tiny)).max(axis=0)
    return phases, np.sqrt(size.sum(axis=0) / (len(element) or 1))


def _squares(values: Complexes) -> Floats:
    """Sums of squares for each edge of a cell and each mode."""
    return (np.abs(values) ** 2).sum(axis=(0, 2, 3))


def _unresolved(phases: Floats, body: BodySpec) -> NDArray[np.bool_]:
    """Which waves are too short for the elements of a body.

    The relative error of their frequency on uniform elements of degree p is, for small phi,

        1/2 (p! / (2 p)!)^2 phi^(2p) / (2 p + 1)      Lagrange elements (Ainsworth 2004)
        1/2 |B_2p| / (2 p)! phi^(2p)          smooth splines (Hughes, Reali & Sangalli 2008)

    with the Bernoulli numbers B: phi^2 / 24 where p = 1, phi^4 / 1440 where p = 2, for both.
    """
    degree, twice = body.degree, 2 * body.degree
    shortest = _NYQUIST * pi * (1 if body.smooth else degree)
    if body.smooth:
        factor = abs(bernoulli(twice)[twice]) / factorial(twice)
    else:
        factor = (factorial(degree) / factorial(twice)) ** 2 / (twice + 1)
    return (0.5 * factor * phases**twice > _SHORT) | (phases > shortest)
