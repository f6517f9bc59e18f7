"""Bodies from mesh files, and contacts whose surfaces turn a corner."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.linalg import eigvals

from cea.arrays import Ints
from comparisons.stability.case import REFUSED, Runs, runs
from comparisons.stability.dense import lambdas
from comparisons.stability.problems import Answer, OfScene, StressAnswer
from comparisons.stability.references import formula
from comparisons.stability.scenes import (
    HELD_BELOW,
    Scene,
    body,
    contact,
    layers,
    pad,
    patch,
    rectangle,
    scene,
    up_to,
)
from comparisons.stability.ways import PAIR, SADDLE, WAYS, chosen
from meshes.mesh_file import METRES, Unit

_CPE8R = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]])
"""Places of the nodes of an element of Abaqus, in halves of its sides."""


@dataclass(frozen=True)
class OfMeshFile:
    """A scene of rectangles of quadratic cells, written to a deck of Abaqus and read from it."""

    data: Mapping[str, Any]
    unit: Unit = "m"  # of lengths in the deck
    step: int = 1  # between the numbers of nodes
    geometry: Mapping[str, Any] = field(default_factory=dict)  # fields of every body that differ
    notched: str = ""  # a body without the cells beyond the origin along both axes

    def solve(self, max_frequency: float | None) -> Answer | StressAnswer:
        """Write, read, and solve."""
        data, text, first = deepcopy(dict(self.data)), "", 1
        places = [pair[side] for pair in data["contacts"].values() for side in ("a", "b")]
        with TemporaryDirectory() as folder:
            deck = Path(folder) / "bodies.inp"
            for name, each in data["bodies"].items():
                faces = {place.split(".")[1] for place in places if place.startswith(f"{name}.")}
                faces |= {support["surface"] for support in each["supports"]}
                halves = 2 * np.array(each["mesh"]["fe"]["elements"])
                text += self._part(name, each["geometry"], halves, faces, first)
                first += int(np.prod(halves + 1))
                sets = {"part": name, "faces": {face: f"{name}_{face}" for face in faces}}
                file = {"shape": "mesh_file", "file": str(deck), "unit": self.unit}
                each |= {"geometry": {**file, **sets, **self.geometry}, "mesh": {}}
            deck.write_text(text)
            return OfScene(data).solve(max_frequency)

    def _part(self, name: str, shape: Scene, halves: Ints, faces: set[str], first: int) -> str:
        """Nodes, elements and sets of nodes of a body, numbered from a first number."""
        counts = tuple(halves + 1)
        places = np.indices(counts).reshape(2, -1).T
        origin, size = np.array(shape["origin"]), np.array(shape["size"])
        points = origin + size * places / halves
        corners = places[(places % 2 == 0).all(axis=1) & (places < halves).all(axis=1)]
        if name == self.notched:
            middles = origin + size * (corners + 1) / halves
            corners = corners[middles.min(axis=1) < 0]
        cells = np.ravel_multi_index(tuple((corners[:, None] + _CPE8R).T), counts).T
        used, numbers = np.unique(cells), self.step * (first + np.arange(len(points)))
        above, below = METRES[self.unit]
        at = zip(numbers[used], (points[used] * below / above).tolist(), strict=True)
        lines = ["*NODE", *(f"{number}, {x!r}, {y!r}" for number, (x, y) in at)]
        elements = enumerate(numbers[cells].tolist(), first)
        lines += [f"*ELEMENT, TYPE=CPE8R, ELSET={name}"]
        lines += [", ".join(map(str, [number, *nodes])) for number, nodes in elements]
        on = {"corner": points.min(axis=1) == 0}
        for axis, letter in enumerate("xy"):
            on[f"{letter}_min"] = places[:, axis] == 0
            on[f"{letter}_max"] = places[:, axis] == halves[axis]
        for face in faces:
            lines += [f"*NSET, NSET={name}_{face}", *map(str, numbers[used[on[face][used]]])]
        return "\n".join([*lines, ""])


def mesh_files() -> Runs:
    """Bodies from mesh files."""
    ways = chosen(PAIR, backend="fe")
    files: dict[str, tuple[Scene, dict[str, Any]]] = {
        "metres": (layers(), {}),
        "micrometres": (layers(), {"unit": "um"}),
        "feet": (layers(), {"unit": "ft"}),
        "elements of aspect 1e4": (layers(height=1e-4), {}),
        "node numbers to 1e9": (layers(), {"step": 10**7}),
        "a pad that ends on its base": (pad(), {"unit": "mm"}),
    }
    for row, (data, fields) in files.items():
        yield from runs(row, data, ways, problem=partial(OfMeshFile, **fields))
    for row, name, value in (
        ("no unit", "unit", None),
        ("two bodies as one", "part", None),
        ("a set that is not there", "faces", {"y_min": "nowhere"}),
    ):
        problem = partial(OfMeshFile, geometry={name: value})
        refusal: dict[str, Any] = {"expected": REFUSED, "names": name}
        yield from runs(row, layers(), ways, None, problem=problem, **refusal)


def _corner(p: float, *, together: bool = True, E: float = 1.0) -> Scene:
    """A block in the corner of a seat, one contact over both faces or one for each."""
    block = patch([[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]])
    below, left = [[0, 1, 0]], [[0, 0, 0]]
    block["faces"] = {"below": below, "left": left, "corner": below + left}
    seat = patch([[-0.5, -0.5], [0.0, -0.5]], [[-0.5, 0.0], [0.0, 0.0]])
    for low, high in (((0.0, -0.5), (1.5, 0.0)), ((-0.5, 0.0), (0.0, 1.5))):
        part = patch([[low[0], low[1]], [high[0], low[1]]], [[low[0], high[1]], [high[0], high[1]]])
        seat["patches"] += part["patches"]
    floor, wall, foot = [[1, 1, 1]], [[2, 0, 1]], [[0, 1, 0], [1, 1, 0]]
    seat["faces"] = {"base": foot, "floor": floor, "wall": wall, "corner": floor + wall}
    bodies = {
        "block": body(block, (4, 4), E=E),
        "seat": body(seat, (3, 3), E=E, supports=[{"surface": "base"}]),
    }
    if together:
        return scene(bodies, contact=_push("block.corner", "seat.corner", [1.0, 1.0], p))
    return scene(
        bodies,
        floor=_push("block.below", "seat.floor", [1.0, 0.0], p),
        wall=_push("block.left", "seat.wall", [0.0, 1.0], p),
    )


def _push(a: str, b: str, direction: list[float], p: float) -> Scene:
    return contact(a, b, p=p, friction_direction_on_a={"vector": direction})


def contact_corner() -> Runs:
    """A contact whose surfaces turn a corner."""
    rigid, mu = 1e7, 0.3  # E beside a contact of p = 1 N/m³
    bodies = {
        "block": body(rectangle((1.0, 1.0)), (4, 4), E=rigid),
        "seat": body(rectangle((2.0, 2.0), (-0.5, -0.5)), (8, 8), E=rigid, supports=HELD_BELOW),
    }
    of_file = scene(bodies, contact=_push("block.corner", "seat.corner", [1.0, 1.0], 1.0))
    # Motions of a rigid block along x, along y and about the corner: on a face the gap is n.u, the
    # slip k.u, and its pressure and friction are p (n - mu k) n.u (k the direction of friction).
    K = [[1.0, mu, (mu - 1) / 2], [mu, 1.0, (1 - mu) / 2], [-0.5, 0.5, 2 / 3]]
    M = [[1.0, 0.0, -0.5], [0.0, 1.0, 0.5], [-0.5, 0.5, 2 / 3]]
    true = formula(lambdas(eigvals(K, M)).tolist())
    ways = chosen(WAYS, "segments", "mortar", "GPTS, penalty", "GPTS, saddle")
    file, seat = chosen(ways, backend="fe"), partial(OfMeshFile, notched="seat")
    yield from runs("rigid bodies", up_to(1.0, of_file), file, true, problem=seat, tolerance=1e-6)
    data, iga = up_to(1.0, _corner(1.0, E=rigid)), chosen(ways, backend="iga")
    yield from runs("rigid bodies", data, iga, true, tolerance=1e-6)
    for row, p, some in (
        ("as a contact for each face", 1.0, chosen(WAYS, backend="iga")),
        ("tied, as a tie for each face", inf, chosen(SADDLE, "mortar", backend="iga")),
    ):
        yield from runs(row, _corner(p), some, instead=_corner(p, together=False))
