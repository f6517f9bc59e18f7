"""Structured meshes: lattices of nodes between breaks, their cells and their named sides."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cea.errors import require
from cea.mesh import Floats, Ints
from meshes.breaks import Breaks
from meshes.nodes import interpolate_arc
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring, Shape

Region = tuple[slice | int, ...]
"""Part of a lattice: a range of its cells along a direction, or the number of a break across it."""

_ALL = slice(None)


@dataclass(frozen=True)
class Lattice:
    """Block of cells.

    Parameters
    ----------
    node
        Numbers of the nodes, ``order`` from break to break, one array axis for each direction.
    solids
        Regions that are filled with cells.
    sides
        Named sides, each with its region.
    """

    node: Ints
    solids: tuple[Region, ...]
    sides: tuple[tuple[str, Region], ...]

    def cells(self, region: Region, offsets: Ints, order: int) -> Ints:
        """Nodes of the cells of a region, (n_cells, n_nodes).

        Parameters
        ----------
        region
            The region.
        offsets
            Place of each node of a cell on the lattice, from 0 to ``order``, (n_nodes, dim).
        order
            Lattice steps across a cell.
        """
        node = self.node
        for axis, part in reversed(list(enumerate(region))):
            count = (self.node.shape[axis] - 1) // order
            if isinstance(part, int):
                node = np.take(node, range(count + 1)[part] * order, axis=axis)
            else:
                start, stop, _ = part.indices(count)
                node = np.take(node, np.arange(start * order, stop * order + 1), axis=axis)
        corners = np.meshgrid(*(np.arange(0, n - 1, order) for n in node.shape), indexing="ij")
        return node[tuple(c.reshape(-1, 1) + offsets[:, d] for d, c in enumerate(corners))]


def lattices(shape: Shape, breaks: Breaks, order: int) -> tuple[Floats, list[Lattice]]:
    """Nodes (m), (n, dim), and lattices of a shape.

    Inner nodes of a ring, too, lie on the circle of their lattice line. A disc is five blocks: a
    square whose corners lie on the circle of the break nearest to half the radius, divided as its
    quarters are, takes the place of the breaks along r inside that circle; between the square and
    the rim the lattice lines pass over from the straight to the round.

    Raises
    ------
    InputError
        When the breaks do not suit a disc.
    """
    if isinstance(shape, Disc):
        points, nodes = _disc(shape, breaks, order)
    else:
        points, nodes = _plane(shape, breaks, order)
    if len(breaks) == 3:
        z = _divided(breaks[2], order)
        nodes = [node[..., None] + len(points) * np.arange(len(z)) for node in nodes]
        points = np.column_stack([np.tile(points, (len(z), 1)), np.repeat(z, len(points))])
    if isinstance(shape, Hub):
        return points, [_hub(shape, breaks, nodes[0])]
    whole: Region = (_ALL,) * len(breaks)
    if isinstance(shape, Disc):
        faces: list[tuple[str, Region]] = [("bottom", (_ALL, _ALL, 0)), ("top", (_ALL, _ALL, -1))]
        rim: tuple[str, Region] = ("outer", (-1, _ALL, _ALL))
        square, ring = nodes
        return points, [
            Lattice(square, (whole,), tuple(faces)),
            Lattice(ring, (whole,), (rim, *faces)),
        ]
    closed = isinstance(shape, Annulus | Ring)
    ends = [(axis, end) for axis in range(len(breaks)) for end in (0, -1)]
    ends = [(axis, end) for axis, end in ends if not (closed and axis == 1)]
    walls = [(*whole[:axis], end, *whole[axis + 1 :]) for axis, end in ends]
    return points, [Lattice(nodes[0], (whole,), tuple(zip(shape.surfaces, walls, strict=True)))]


def _divided(line: Floats, order: int) -> Floats:
    """Breaks with each interval divided in ``order`` equal parts."""
    parts = line[:-1, None] + np.diff(line)[:, None] * np.arange(order) / order
    return np.append(parts.ravel(), line[-1])


def _plane(shape: Shape, breaks: Breaks, order: int) -> tuple[Floats, list[Ints]]:
    """Points (m), (n, 2), and numbers on the lattice of the first two directions."""
    first = _divided(breaks[0], order)
    if isinstance(shape, Box | Rectangle):
        grid = np.stack(np.meshgrid(first, _divided(breaks[1], order), indexing="ij"), axis=-1)
    else:
        grid = first[:, None, None] * interpolate_arc(np.radians(breaks[1]), order)
    if isinstance(shape, Annulus | Ring | Hub):
        points = grid[:, :-1].reshape(-1, 2)
        open_ring = np.arange(len(points)).reshape(len(first), -1)
        return points, [np.concatenate([open_ring, open_ring[:, :1]], axis=1)]
    points = grid.reshape(-1, 2)
    return points, [np.arange(len(points)).reshape(grid.shape[:2])]


def _disc(shape: Disc, breaks: Breaks, order: int) -> tuple[Floats, list[Ints]]:
    """Points (m), (n, 2), and lattices of the square in the middle and of the ring around it."""
    radii, angles = breaks[0], breaks[1]
    require(len(radii) > 2, "breaks of r", radii, "two elements at least, one of them the square")
    quarter = np.searchsorted(angles, np.array([0.0, 90.0, 180.0, 270.0, 360.0]) - 1e-9)
    sides = np.diff(quarter)
    matching = sides[0] == sides[2] and sides[1] == sides[3]
    require(
        bool(matching),
        "breaks of theta",
        angles,
        "as many in a quarter of a disc as in that across",
    )
    core = 1 + int(np.abs(radii[1:-1] - shape.outer_radius / 2).argmin())
    corner = radii[core]

    # Share of its side of the square at each lattice line of a quarter.
    shares = []
    for start, stop in pairwise(quarter):
        line = _divided(angles[start : stop + 1], order)
        shares.append((line - line[0]) / (line[-1] - line[0]))
    below, above = shares[0][:, None], 1 - shares[2][::-1, None]
    left, right = 1 - shares[3][::-1], shares[1]
    # Where the line from side 0 to side 2 crosses that from side 1 to side 3.
    du, dv = above - below, right - left
    u = (below + left * du) / (1 - du * dv)
    v = left + u * dv
    square = corner * np.stack([1 - u - v, u - v], axis=-1)
    middle = np.arange(square[..., 0].size).reshape(square.shape[:2])
    rim = np.concatenate([middle[:-1, 0], middle[-1, :-1], middle[:0:-1, -1], middle[0, :0:-1]])

    inner = square.reshape(-1, 2)[rim]
    outer = shape.outer_radius * interpolate_arc(np.radians(angles), order)[:-1]
    along = (_divided(radii[core:], order)[1:] - corner) / (shape.outer_radius - corner)
    ring = inner + along[:, None, None] * (outer - inner)
    around = square[..., 0].size + np.arange(ring[..., 0].size).reshape(ring.shape[:2])
    around = np.concatenate([rim[None], around])
    around = np.concatenate([around, around[:, :1]], axis=1)
    return np.concatenate([square.reshape(-1, 2), ring.reshape(-1, 2)]), [middle, around]


def _hub(shape: Hub, breaks: Breaks, node: Ints) -> Lattice:
    """Lattice of hub and ring, empty above and below the ring."""
    wall = int(np.abs(breaks[0] - shape.hub_radius).argmin())
    low, high = (int(np.abs(breaks[2] - z).argmin()) for z in (shape.bottom, shape.top))
    within, beyond, ring = slice(0, wall), slice(wall, None), slice(low, high)
    sides: list[tuple[str, Region]] = [
        ("bore", (0, _ALL, _ALL)),
        ("outer", (-1, _ALL, ring)),
        ("bottom", (beyond, _ALL, low)),
        ("top", (beyond, _ALL, high)),
        ("hub_bottom", (within, _ALL, 0)),
        ("hub_top", (within, _ALL, -1)),
        ("hub_side", (wall, _ALL, slice(0, low))),
        ("hub_side", (wall, _ALL, slice(high, None))),
    ]
    return Lattice(node, ((within, _ALL, _ALL), (beyond, _ALL, ring)), tuple(sides))
