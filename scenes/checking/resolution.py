"""Warning for modes whose wavelengths are too short for the elements of a contact."""

from collections.abc import Callable, Mapping
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
"""Estimated relative error of the frequency above which a mode is reported as under-resolved."""
_STILL = 0.1
"""Amplitude of a side, relative to the other side, below which its waves are ignored."""
_NYQUIST = 0.8
"""Largest resolved phase, relative to the Nyquist limit of one basis function per half wave."""

Shapes = Callable[[str, SurfaceCoordinates], Complexes]
"""Displacements of all modes at points of a surface "body.surface", (n, dim, modes)."""


def short_modes(
    scene: Scene, bodies: Mapping[str, Body], shapes: Shapes, count: int
) -> tuple[ResultWarning, ...]:
    """Warn of modes whose waves are too short for the elements of a contact; collective."""
    short, worst = np.zeros(count, dtype=bool), 0.0
    for spec in scene.contacts.values() if count else ():
        sides = {}
        for body, name in spec.sides:
            sides[body] = _waves(bodies[body].surfaces[name], f"{body}.{name}", shapes)
        largest = np.max([amplitudes for _, amplitudes in sides.values()], axis=0)
        for body, (phases, amplitudes) in sides.items():
            found = _unresolved(phases, scene.bodies[body])
            found &= amplitudes > _STILL * largest
            short |= found
            worst = max(worst, float(phases[found].max(initial=0.0)))
    if not short.any():
        return ()
    numbers, elements = (np.flatnonzero(short) + 1).tolist(), 2 * np.pi / worst
    told = "modes {modes} have as few as {elements_per_wave:.2g} elements per wave in a contact"
    return (warning("short-modes", told, modes=numbers, elements_per_wave=elements),)


def _waves(surface: Surface, place: str, shapes: Shapes) -> tuple[Floats, Floats]:
    """Return the largest phase phi per element over the element directions, and the amplitude.

    phi^2 = int |du/dxi|^2 / int |u|^2 along the edges of the elements, with xi from 0 to 1 in each
    element, is the squared phase change of a wave over one element. The amplitude is the root mean
    square of the displacements. Both have one entry per mode; collective if ``shapes`` is.
    """
    cells = surface.cells
    steps, corners = max(2, cells.degree), cells.corners
    edges = corners.shape[2]  # one along curves, two along surfaces
    t = np.linspace(0.0, 1.0, steps + 1)[:, None]
    points = np.stack(
        [corners[:, i, None] * (1 - t) + corners[:, i + 1, None] * t for i in range(edges)], axis=1
    )
    element = np.repeat(cells.element, edges * (steps + 1))
    u = shapes(place, SurfaceCoordinates(element, points.reshape(-1, edges)))
    u = u.reshape(*points.shape[:3], *u.shape[1:])  # cells, edges, points, components, modes
    change = steps**2 * _squares(np.diff(u, axis=2))
    size = _squares(0.5 * (u[:, :, 1:] + u[:, :, :-1]))
    phases = np.sqrt(change / np.maximum(size, np.finfo(float).tiny)).max(axis=0)
    return phases, np.sqrt(size.sum(axis=0) / (len(element) or 1))


def _squares(values: Complexes) -> Floats:
    """Sum the squared magnitudes over cells, points and components; (edges, modes)."""
    return (np.abs(values) ** 2).sum(axis=(0, 2, 3))


def _unresolved(phases: Floats, body: BodySpec) -> NDArray[np.bool_]:
    """Return a mask of the waves that are too short for the elements of a body.

    On uniform elements of degree p, the relative error of the frequency for small phi is

        1/2 (p! / (2 p)!)^2 phi^(2p) / (2 p + 1)      Lagrange elements (Ainsworth 2004)
        1/2 |B_2p| / (2 p)! phi^(2p)          smooth splines (Hughes, Reali & Sangalli 2008)

    with the Bernoulli numbers B; both give phi^2 / 24 for p = 1 and phi^4 / 1440 for p = 2.
    """
    degree, twice = body.degree, 2 * body.degree
    shortest = _NYQUIST * pi * (1 if body.smooth else degree)
    if body.smooth:
        factor = abs(bernoulli(twice)[twice]) / factorial(twice)
    else:
        factor = (factorial(degree) / factorial(twice)) ** 2 / (twice + 1)
    return (0.5 * factor * phases**twice > _SHORT) | (phases > shortest)
