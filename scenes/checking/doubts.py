"""What is probably not meant: numbers of other units, motions too large, bodies inside each other.

Warnings, never refusals. Numbers are doubted as those of SI units. A scene with units = "other", or
whose every E and rho is near one as in scenes without units, is left alone: its run says so once,
among what it left out.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import combinations
from math import inf
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from cea.arrays import Floats
from cea.body import Body
from cea.body.space import StraightCells
from cea.errors import ResultWarning
from cea.ranks import made_on_first
from cea.system.coupled import CoupledSystem
from scenes.spec.reading import Scene

_SOFTEST = 1e3
"""E (N/m^2) below which a solid is softer than any that brakes, clutches or tyres are made of."""
_HEAVIEST = 1e6
"""rho (kg/m^3) beyond that of any matter on earth, fifty times that of platinum."""
_SOUND = (50.0, 20e3)
"""Speeds of sound sqrt(E / rho) (m/s) of solids: 52 of soft rubber (E 3e6 N/m^2, rho 1,100 kg/m^3),
17,700 of diamond (1.1e12, 3,515)."""
_LENGTHS = (1e-5, 100.0)
"""Length (m) of the longest side: from parts of micromachines to rails."""
_STRAIN = 0.1
"""Strain of which the quadratic terms that linear elasticity leaves out, e^2 / 2 of the
Green-Lagrange strain e + e^2 / 2 (Wriggers, Nonlinear Finite Element Methods, 2008), are 5 %."""
_NEAR_ONE = (1e-3, 1e2)
"""Range of E and rho in scenes without units."""
_ASKED = "a scene whose numbers are not in SI units says units = 'other'"
_FLAT = 1e-12
"""Volume of a simplex, relative to a cube about it, below which it is one of a collapsed cell."""
_SIMPLICES = {
    (2, 3): [[0, 1, 2]],
    (2, 4): [[0, 1, 2], [0, 2, 3]],
    (3, 4): [[0, 1, 2, 3]],
    (3, 8): [[0, 6, i, j] for i, j in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))],
}
"""Corners of the simplices of a cell by dimension and number of its points, in VTK order."""


def left_alone(scene: Scene) -> str:
    """Why the numbers of a scene are none in SI units; "" where they are taken to be."""
    if scene.units == "other":
        return "units = 'other'"
    low, high = _NEAR_ONE
    materials = [body.material for body in scene.bodies.values()]
    numbers = [n for each in materials for n in (each.means[0], each.rho) if n is not None]
    near_one = all(low <= n <= high for n in numbers)
    return "every E and rho is near one, as in scenes without units" if near_one else ""


def doubtful_numbers(scene: Scene) -> Iterator[ResultWarning]:
    """Materials that no solid has in SI units, and bodies that are too large or too small."""
    for name, body in scene.bodies.items() if not left_alone(scene) else ():
        E, rho = body.material.means[0], body.material.rho
        speed, (slow, fast) = float(np.sqrt(E / (rho or inf))), _SOUND
        doubts = {
            "E": (E, E < _SOFTEST, f"E below {_SOFTEST:g} N/m^2"),
            "rho": (rho, rho is not None and rho > _HEAVIEST, f"rho over {_HEAVIEST:g} kg/m^3"),
        }
        if rho is not None and not any(doubted for _, doubted, _ in doubts.values()):
            bound = f"a speed of sound below {slow:g} or over {fast:g} m/s"
            doubts["sqrt(E/rho)"] = speed, not slow <= speed <= fast, bound
        for field, (value, doubted, bound) in doubts.items():
            if doubted:
                told = f"bodies.{name}.material.{field} = {value:g}: no solid has {bound}; {_ASKED}"
                data = {"body": name, "field": field, "value": value}
                yield ResultWarning("doubtful-units", told, data)
        length, (low, high) = max(body.lengths), _LENGTHS
        if not low <= length <= high:
            told = f"bodies.{name} is {length:.3g} m long, not {low:g} to {high:g} m; {_ASKED}"
            yield ResultWarning("doubtful-size", told, {"body": name, "length": length})


def doubtful_motions(scene: Scene, system: CoupledSystem, x: Any) -> Iterator[ResultWarning]:
    """Displacements larger than their body and strains that linear elasticity has no right to."""
    for name, body in system.bodies.items() if not left_alone(scene) else ():
        full = system.displacement(x, name, everywhere=False)
        cells = body.space.volume_cells().straight()
        found = made_on_first(body.comm, partial(_motion, cells, full))
        motion, length, strain = body.comm.bcast(found)
        if motion > length:
            told = (
                f"bodies.{name} is displaced by {motion:.3g} m, more than its length {length:.3g} m"
            )
            data = {"body": name, "displacement": motion, "length": length}
            yield ResultWarning("large-displacement", told, data)
        if strain > _STRAIN:
            told = f"bodies.{name} is strained by up to {strain:.3g}: only small strains are right"
            yield ResultWarning("large-strain", told, {"body": name, "strain": strain})


def _motion(sample: StraightCells, full: Floats) -> tuple[float, float, float]:
    """Largest displacement (m), length of the body (m), largest mean principal strain of a cell."""
    u = sample.values @ full.reshape(-1, sample.points.shape[1])
    x, moved = sample.points[sample.cells], u[sample.cells]
    gradient = np.linalg.pinv(x - x.mean(axis=1, keepdims=True)) @ moved
    strains = np.linalg.eigvalsh(0.5 * (gradient + gradient.transpose(0, 2, 1)))
    lengths = np.ptp(sample.points, axis=0)
    motion = np.linalg.norm(u, axis=1).max()
    return float(motion), float(lengths.max()), float(np.abs(strains).max())


def overlapping_bodies(scene: Scene, bodies: Mapping[str, Body]) -> Iterator[ResultWarning]:
    """Pairs of bodies without a contact, one with middles of cells in the other; collective."""
    joined = [{side.split(".")[0] for side in (c.a, c.b)} for c in scene.contacts.values()]
    pairs = [pair for pair in combinations(bodies, 2) if set(pair) not in joined]
    names = dict.fromkeys(name for pair in pairs for name in pair)  # in one order on all ranks
    samples = {name: bodies[name].space.volume_cells().straight() for name in names}
    for one, other in pairs:
        counted = partial(_middles_inside, samples[one], samples[other])
        cells = bodies[one].comm.bcast(made_on_first(bodies[one].comm, counted))
        if cells:
            told = f"bodies.{one} and bodies.{other} overlap by {cells} elements without a contact"
            data = {"body": one, "other": other, "elements": cells}
            yield ResultWarning("bodies-overlap", told, data)


def _middles_inside(one: StraightCells, other: StraightCells) -> int:
    return _inside(one, other) + _inside(other, one)


def _inside(one: StraightCells, other: StraightCells) -> int:
    """How many cells of one have their middle in straight cells of the other."""
    middles = one.points[one.cells].mean(axis=1)
    dim = middles.shape[1]
    simplices = other.cells[:, _SIMPLICES[dim, other.cells.shape[1]]].reshape(-1, dim + 1)
    corners = other.points[simplices]
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    edges = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    solid = np.abs(np.linalg.det(edges)) > _FLAT * radii**dim
    near = KDTree(middles).query_ball_point(centres[solid], radii[solid])
    point = np.array([i for some in near for i in some], dtype=np.int64)
    simplex = np.flatnonzero(solid).repeat([len(some) for some in near])
    away = (middles[point] - corners[simplex, 0])[:, :, None]
    parts = np.linalg.solve(edges[simplex], away)[:, :, 0]
    within = (parts > 0).all(axis=1) & (parts.sum(axis=1) < 1)
    return len(np.unique(point[within]))
