"""A block in the corner of a seat: one contact whose surfaces turn a corner."""

from collections.abc import Iterator
from math import inf
from typing import Any

import numpy as np
from scipy.linalg import eigvals
from scipy.special import roots_legendre

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.mesh_files import OfMeshFile
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense, formula
from comparisons.stability.parts.scenes import (
    Scene,
    body,
    changed,
    contact,
    patch,
    rectangle,
    scene,
)
from comparisons.stability.parts.ways import MORTAR, WAYS, chosen

_MU = 0.3
_RIGID = 1e7
"""E at which bodies are rigid beside a contact of p = 1 N/m^3."""
_HELD = [{"surface": "base"}]


def _splines(p: float, together: bool, E: float = 1.0) -> Scene:
    """Both bodies as NURBS patches, one contact over the corner or one for each face."""
    block = patch([[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]])
    block["faces"] = {
        "below": [[0, 1, 0]],
        "left": [[0, 0, 0]],
        "corner": [[0, 1, 0], [0, 0, 0]],
    }
    seat = patch([[-0.5, -0.5], [0.0, -0.5]], [[-0.5, 0.0], [0.0, 0.0]])
    for low, high in (((0.0, -0.5), (1.5, 0.0)), ((-0.5, 0.0), (0.0, 1.5))):
        part = patch([[low[0], low[1]], [high[0], low[1]]], [[low[0], high[1]], [high[0], high[1]]])
        seat["patches"] += part["patches"]
    seat["faces"] = {
        "base": [[0, 1, 0], [1, 1, 0]],
        "floor": [[1, 1, 1]],
        "wall": [[2, 0, 1]],
        "corner": [[1, 1, 1], [2, 0, 1]],
    }
    bodies = {
        "block": body(block, (4, 4), E=E),
        "seat": body(seat, (3, 3), E=E, supports=_HELD),
    }
    if together:
        return scene(bodies, contact=_contact("block.corner", "seat.corner", (1.0, 1.0), p))
    return scene(
        bodies,
        floor=_contact("block.below", "seat.floor", (1.0, 0.0), p),
        wall=_contact("block.left", "seat.wall", (0.0, 1.0), p),
    )


def _facets() -> Scene:
    """Both rigid bodies as rectangles, which become a block and a seat in a mesh file."""
    support = [{"surface": "y_min"}]
    return scene(
        {
            "block": body(rectangle((1.0, 1.0)), (4, 4), E=_RIGID),
            "seat": body(rectangle((2.0, 2.0), (-0.5, -0.5)), (8, 8), E=_RIGID, supports=support),
        },
        contact=_contact("block.corner", "seat.corner", (1.0, 1.0), 1.0),
    )


def _contact(a: str, b: str, push: tuple[float, float], p: float) -> Scene:
    return contact(a, b, p=p, mu=_MU, friction_direction_on_a={"vector": list(push)})


def _rigid() -> list[complex]:
    """Lambda (1/s) of a rigid unit block in a rigid seat, rho = 1, p = 1, about its corner.

    Of motions m the gap is n.m and the slip k.m; both faces add p (n.m_i + mu k.m_i) (n.m_j).
    """
    stiffness = np.zeros((3, 3))
    for s, w in zip(*roots_legendre(3), strict=True):
        along, weight = (1 + s) / 2, w / 2
        for position, closed, slid in (
            (np.array([along, 0.0]), np.array([0.0, -1.0]), np.array([1.0, 0.0])),
            (np.array([0.0, along]), np.array([-1.0, 0.0]), np.array([0.0, 1.0])),
        ):
            turned = np.array([-position[1], position[0]])
            gap, slip = (np.append(each, each @ turned) for each in (closed, slid))
            stiffness += weight * np.outer(gap - _MU * slip, gap)
    centre = 0.5
    mass = np.array([[1.0, 0.0, -centre], [0.0, 1.0, centre], [-centre, centre, 2 / 3]])
    values = 1j * np.sqrt(eigvals(stiffness, mass).astype(complex))
    return [complex(value) for value in values]


@case("A contact whose surfaces turn a corner", subject="geometry")
def contact_corner() -> Iterator[Run]:
    """What is right of one contact for each face is right of one over both."""
    exact: dict[str, Any] = {"reference": formula(_rigid()), "tolerance": 1e-6}
    window = {"analysis.max_frequency": 1.0}
    for way in chosen(WAYS, "segments", "mortar", "GPTS, penalty", "GPTS, saddle"):
        if way.backend == "iga":
            data = changed(way.of(_splines(1.0, True, _RIGID)), window)
            yield Run("rigid bodies", way, OfScene(data), **exact)
            continue
        data = changed(way.of(_facets()), window)
        corner = {"block": ("x_min", "y_min"), "seat": ("notch",)}
        problem = OfMeshFile(data, notches={"seat": (0.0, 0.0)}, surfaces={"corner": corner})
        yield Run("rigid bodies", way, problem, **exact)
    for way in chosen(WAYS, backend="iga"):
        one, two = (way.of(_splines(1.0, together)) for together in (True, False))
        yield Run("as a contact for each face", way, OfScene(one), dense(two))
    for way in chosen(MORTAR, "mortar, saddle", backend="iga"):
        one, two = (way.of(_splines(inf, together)) for together in (True, False))
        yield Run("tied, as a tie for each face", way, OfScene(one), dense(two))
