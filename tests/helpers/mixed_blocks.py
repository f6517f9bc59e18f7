"""Boxes divided into hexahedra, wedges, pyramids and tetrahedra that match across faces."""

from itertools import product

import numpy as np

from meshes.files.content import block
from meshes.files.elements import KINDS

CUBE = [tuple(corner) for corner in KINDS["hexahedron8"].reference.astype(int).tolist()]
WEDGES = [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)]
PYRAMIDS = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]


def mixed_cells(elements=(3, 2, 3)):
    """Corners of elements by cell, as points of a lattice of even numbers from 0."""
    cells = {"hexahedron": [], "wedge": [], "pyramid": [], "tetrahedron": []}
    for place in product(*map(range, elements)):
        at = np.array(CUBE) * 4 + 4 * np.array(place)
        kind = (place[0] + place[2]) % 3  # whole columns along y, so that wedges match
        if kind == 0:
            cells["hexahedron"].append(at)
        elif kind == 1:
            turned = 4 * (np.array(CUBE)[:, [1, 2, 0]] + np.array(place))  # wedges along y
            cells["wedge"] += [turned[list(wedge)] for wedge in WEDGES]
        else:
            middle = at.mean(axis=0).astype(int)
            cells["pyramid"] += [np.vstack([at[list(face)], middle]) for face in PYRAMIDS]
    # a pyramid becomes two tetrahedra where its base lies on the boundary
    low = [p for p in cells["pyramid"] if (p[:4, 1] == 0).all()]
    cells["pyramid"] = [p for p in cells["pyramid"] if not (p[:4, 1] == 0).all()]
    cells["tetrahedron"] += [p[list(t)] for p in low for t in ((0, 1, 2, 4), (0, 2, 3, 4))]
    return {cell: np.array(corners) for cell, corners in cells.items()}


def mixed_blocks(order, seed=0, move=lambda x: x, nodes=None):
    """Points, moved, and blocks of elements whose nodes are numbered at random."""
    counts = {1: [8, 6, 5, 4], 2: [20, 15, 13, 10]}[order] if nodes is None else nodes
    kinds = dict(zip(("hexahedron", "wedge", "pyramid", "tetrahedron"), counts, strict=True))
    cells = mixed_cells()
    listed = {
        cell: np.stack([at[:, list(group)].mean(axis=1) for group in
                        KINDS[f"{cell}{kinds[cell]}"].groups], axis=1)
        for cell, at in cells.items()
    }  # fmt: skip
    every = np.concatenate([at.reshape(-1, 3) for at in listed.values()])
    points, rows = np.unique(every, axis=0, return_inverse=True)
    number = np.random.default_rng(seed).permutation(len(points))
    moved = np.empty_like(points)
    moved[number] = move(points / 4)
    ends = np.cumsum([at.shape[0] * at.shape[1] for at in listed.values()])[:-1]
    blocks = []
    for (cell, at), own in zip(listed.items(), np.split(number[rows.ravel()], ends), strict=True):
        nodes_of = own.reshape(at.shape[:2])
        blocks.append(block(cell, f"{cell}{kinds[cell]}", np.arange(len(at)) + 1, nodes_of))
    return moved, blocks
