"""Outsides of bodies as triangles on their curved elements, light enough for a page.

The boundary faces of the cells of a body are divided evenly; what is inside is left out.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise, product
from math import comb

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.body import Body
from cea.volume import VolumeCells

_MERGED = 1e-6
"""Points nearer than this, relative to the diagonal of a body, are one point."""
_OFF_GRID = 0.2113
"""Shift of the lattice on which points are merged: round numbers fall on no border of it."""
_FINEST = 6
"""Times a face is divided at most."""
_SHARP = np.cos(np.radians(30.0))
"""Cosine between the normals of triangles that meet in a sharp edge, at most."""


@dataclass(frozen=True)
class Skin:
    """Outside of a body.

    Parameters
    ----------
    points
        Positions (m), shape (n, dim).
    triangles
        Point numbers, shape (m, 3), counterclockwise seen from outside.
    edges
        Pairs of point numbers along edges of elements, shape (k, 2).
    sharp
        Pairs of point numbers along sharp edges of the body, shape (l, 2).
    values
        Values of the scalar basis functions of the body at the points, shape
        (n, num_scalar_dofs).
    """

    points: Floats
    triangles: Ints
    edges: Ints
    sharp: Ints
    values: csr_array


def skins(bodies: Mapping[str, Body], points: int) -> dict[str, Skin]:
    """Outsides of bodies, divided as finely as a number of points allows; collective.

    Parameters
    ----------
    bodies
        Bodies by name.
    points
        Points that all outsides should have together. Corners of elements always are points,
        however many they are.
    """
    cells = {name: body.volume_cells() for name, body in bodies.items()}
    faces = {name: _boundary_faces(each) for name, each in cells.items()}
    corners = sum(len(face) for face in faces.values())
    # Each division adds about as many points as there are small faces.
    division = int(np.clip(np.sqrt(points / max(corners, 1)), 1, _FINEST))
    return {name: _skin(cells[name], faces[name], division) for name in bodies}


def _skin(cells: VolumeCells, faces: Ints, division: int) -> Skin:
    """Outside of a body from lattice points of its boundary faces, shape (faces, points)."""
    triangular = cells.simplex
    basis = _basis(cells.kind, triangular, cells.degree, division)
    weights = cells.weights[faces]
    shares = basis[None] * weights[:, None, :]
    shares /= shares.sum(axis=2, keepdims=True)
    every = np.einsum("fei,fid->fed", shares, cells.points[faces]).reshape(-1, _dim(cells))
    first, number = _merged(every)
    local = number.reshape(len(faces), -1)
    rows = shares.reshape(-1, faces.shape[1])[first]
    columns = faces[first // basis.shape[0]]
    pointers = np.arange(0, rows.size + 1, faces.shape[1])
    combined = csr_array(
        (rows.ravel(), columns.ravel(), pointers), shape=(len(first), len(cells.points))
    )
    triangles = local[:, _triangles(triangular, division)].reshape(-1, 3)
    triangles = triangles[_distinct(triangles)]
    pairs = np.sort(local[:, _outline(triangular, division)].reshape(-1, 2), axis=1)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return Skin(
        points=every[first],
        triangles=triangles,
        edges=pairs,
        sharp=sharp_edges(every[first], triangles),
        values=csr_array(combined @ cells.values),
    )


def _dim(cells: VolumeCells) -> int:
    return cells.points.shape[1]


def _distinct(triangles: Ints) -> Ints:
    """Numbers of triangles with three corners: those at a pole of a patch may have fewer."""
    a, b, c = triangles.T
    return np.flatnonzero((a != b) & (b != c) & (c != a))


def _merged(points: Floats) -> tuple[Ints, Ints]:
    """First of each group of equal points, and the group of each."""
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    grid = np.round(points / (_MERGED * size) + _OFF_GRID).astype(np.int64)
    _, first, number = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    return first, number.reshape(-1)


def _boundary_faces(cells: VolumeCells) -> Ints:
    """Lattice points of the faces that one cell alone has, shape (faces, points of a face).

    In 2D the cells themselves are what is seen.
    """
    if _dim(cells) == 2:
        return cells.cells
    local = np.array(list(_local_faces(cells.simplex, cells.degree)))
    faces = cells.cells[:, local].reshape(-1, local.shape[1])
    corners = faces[:, _corners(cells.simplex, cells.degree)]
    used, place = np.unique(corners, return_inverse=True)
    group = _merged(cells.points[used])[1][place.reshape(corners.shape)]
    _, first, count = np.unique(
        np.sort(group, axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[np.sort(first[count == 1])]


def _local_faces(simplex: bool, p: int) -> Iterator[Ints]:
    """Lattice points of each face of a cell, its own lattice in C order, outward normal."""
    if simplex:
        number = {point: i for i, point in enumerate(_lattice(3, p))}
        for place in (
            lambda a, b: (0, b, a),
            lambda a, b: (a, 0, b),
            lambda a, b: (b, a, 0),
            lambda a, b: (p - a - b, a, b),
        ):
            yield np.array([number[place(a, b)] for a, b in _lattice(2, p)])
        return
    lattice = np.arange((p + 1) ** 3).reshape(p + 1, p + 1, p + 1)
    for axis in range(3):
        low, high = (np.take(lattice, end, axis) for end in (0, p))
        # The two directions left turn about the axis, but for the middle one against it.
        inward, outward = (high, low) if axis == 1 else (low, high)
        yield inward.T.ravel()
        yield outward.ravel()


def _lattice(dim: int, p: int) -> list[tuple[int, ...]]:
    """Points of a lattice on a simplex in C order."""
    return [point for point in product(range(p + 1), repeat=dim) if sum(point) <= p]


def _corners(simplex: bool, p: int) -> list[int]:
    """Corners among the lattice points of a face."""
    return [0, p, (p + 1) * (p + 2) // 2 - 1] if simplex else [0, p, (p + 1) * p, (p + 1) ** 2 - 1]


def _basis(kind: str, triangular: bool, p: int, division: int) -> Floats:
    """Functions of the lattice points of a face at those of its division."""
    if triangular:
        nodes, at = (np.array(_lattice(2, n)) / n for n in (p, division))
        powers = np.array(_lattice(2, p))
        monomials = [np.prod(x[:, None, :] ** powers[None], axis=2) for x in (at, nodes)]
        return np.linalg.solve(monomials[1].T, monomials[0].T).T
    x = np.linspace(0.0, 1.0, division + 1)
    if kind == "bezier":
        line = np.array([comb(p, i) * x**i * (1 - x) ** (p - i) for i in range(p + 1)]).T
    else:
        exponents = np.arange(p + 1)
        nodes = np.linspace(0.0, 1.0, p + 1)
        line = np.linalg.solve((nodes[:, None] ** exponents).T, (x[:, None] ** exponents).T).T
    return np.kron(line, line)


def _triangles(triangular: bool, n: int) -> Ints:
    """Triangles between the points of a divided face, shape (m, 3)."""
    if triangular:
        number = {point: i for i, point in enumerate(_lattice(2, n))}
        up = [((a, b), (a + 1, b), (a, b + 1)) for a, b in _lattice(2, n - 1)]
        down = [((a + 1, b), (a + 1, b + 1), (a, b + 1)) for a, b in _lattice(2, n - 1)]
        whole = [each for each in (*up, *down) if all(point in number for point in each)]
        return np.array([[number[point] for point in each] for each in whole])
    grid = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (
        part.ravel() for part in (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    )
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def _outline(triangular: bool, n: int) -> Ints:
    """Pairs of neighbours along the edges of a divided face, shape (k, 2)."""
    if triangular:
        number = {point: i for i, point in enumerate(_lattice(2, n))}
        sides = [
            [number[0, i] for i in range(n + 1)],
            [number[i, 0] for i in range(n + 1)],
            [number[i, n - i] for i in range(n + 1)],
        ]
    else:
        grid = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
        sides = [side.tolist() for side in (grid[0], grid[-1], grid[:, 0], grid[:, -1])]
    return np.array([pair for side in sides for pair in pairwise(side)])


def sharp_edges(points: Floats, triangles: Ints) -> Ints:
    """Edges of one triangle alone, or between two whose normals differ by more than 30 degrees.

    Parameters
    ----------
    points
        Positions (m), shape (n, dim).
    triangles
        Point numbers, shape (m, 3).

    Returns
    -------
    ndarray
        Pairs of point numbers, shape (k, 2).
    """
    space = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    a, b, c = (space[corner] for corner in triangles.T)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0, lengths, 1.0)
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, number, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    owner = np.repeat(np.arange(len(triangles)), 3)[np.argsort(number.reshape(-1), kind="stable")]
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    twice = count == 2
    flat = np.zeros(len(edges), dtype=bool)
    first = start[twice]
    flat[twice] = np.einsum("ij,ij->i", normals[owner[first]], normals[owner[first + 1]]) > _SHARP
    return edges[~flat]
