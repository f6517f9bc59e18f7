"""Boxes of nodes that stand for the meshes of bodies, from which sizes are estimated."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, pi, prod

import numpy as np

from cea.mesh import SIMPLICES
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from meshes.shapes import Annulus, Disc, Hub, Ring, Shape, VentilatedDisc
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh

_SIMPLEX = 0.55
"""Couplings of a node of simplices, relative to one of boxes."""
_PACKING = {2: 1.0, 3: 0.95}
"""Boxes along a length, in target edge lengths, that have the nodes of an unstructured mesh."""
TINY = 1e-12
"""Factor on elements below which there are none."""
_CLOSED = (Annulus, Hub, Disc, Ring)


@dataclass(frozen=True)
class NodeGrid:
    """Nodes of a body as a box of them.

    Parameters
    ----------
    counts
        Nodes along each direction.
    couplings
        Nodes along each direction that one node is coupled to, on average.
    widths
        Layers of nodes that part a body across each direction.
    """

    counts: tuple[float, ...]
    couplings: tuple[float, ...]
    widths: tuple[float, ...]


def node_grids(body: BodySpec, scale: float) -> Iterator[NodeGrid]:
    """Boxes of nodes that stand for the mesh of a body: one, or one for each of its patches."""
    dim = len(body.geometry.directions)
    closed = isinstance(body.geometry, _CLOSED)
    if isinstance(body.geometry, MeshFile):
        yield _grid_of_file(body.geometry, body.fe_degree or body.geometry.order, scale)
    elif body.backend == "fe" and body.mesh.fe is not None:
        fe = body.mesh.fe
        along = elements_along(body, fe, scale)
        ends = [0.0 if closed and name == "theta" else 1.0 for name in body.geometry.directions]
        counts = [fe.degree * n + end for n, end in zip(along, ends, strict=True)]
        near = (fe.degree + 2.0) * (_SIMPLEX if fe.cell in SIMPLICES else 1.0) ** (1 / dim)
        yield NodeGrid(tuple(counts), (near,) * dim, (1.0,) * dim)
        if fe.layers:
            yield _grid_of_layers(body, fe, counts, near)
    elif body.mesh.iga is not None:
        iga = body.mesh.iga
        continuity = iga.continuity or tuple(p - 1 for p in iga.degree)
        new = [p - c for p, c in zip(iga.degree, continuity, strict=True)]
        couplings = [2.0 * (p + 1) - m for p, m in zip(iga.degree, new, strict=True)]
        widths = [c + 1.0 for c in continuity]
        for inner in _knots_of_patches(body.geometry):
            counts = [
                m * (max(1.0, scale * n) + k) + c + 1
                for m, n, k, c in zip(new, iga.elements, inner, continuity, strict=True)
            ]
            least = [min(a, b) for a, b in zip(couplings, counts, strict=True)]
            yield NodeGrid(tuple(counts), tuple(least), tuple(widths))


def _grid_of_layers(body: BodySpec, fe: FeMesh, counts: Sequence[float], near: float) -> NodeGrid:
    """Nodes that layers towards edges bring: two cells each in all that meet in an edge."""
    ends = dict(zip(body.geometry.directions, body.geometry.extent, strict=True))
    meeting = sum(1 + sum(x not in ends[d] for d, x in edge.items()) for edge in fe.edges)
    across = [2.0 * fe.layers * meeting * fe.degree, float(fe.degree)]
    along = [n for d, n in zip(ends, counts, strict=True) if d not in fe.edges[0]]
    dim = len(ends)
    return NodeGrid((*across, *along), (near,) * dim, (1.0,) * dim)


def _grid_of_file(file: MeshFile, degree: int, scale: float) -> NodeGrid:
    """Nodes of the elements of a file, in a box of the proportions of the body."""
    lengths = box_lengths(file)
    dim = len(lengths)
    nodes = file.num_nodes * (degree / file.order) ** dim
    if file.fills_in:
        nodes = max(nodes, float(file.num_cells * degree**dim))
    even = (nodes * scale**dim / prod(lengths)) ** (1 / dim)
    near = (degree + 2.0) * (_SIMPLEX if file.is_simplex else 1.0) ** (1 / dim)
    counts = tuple(max(1.0, even * length) for length in lengths)
    return NodeGrid(counts, (near,) * dim, (1.0,) * dim)


def elements_along(body: BodySpec, mesh: FeMesh, scale: float) -> list[float]:
    """Elements along each direction; of an unstructured mesh, of a box of equal volume."""
    if mesh.elements is not None:
        return [max(1.0, scale * n) for n in mesh.elements]
    size = (mesh.size or inf) / max(scale, TINY)
    if isinstance(body.geometry, VentilatedDisc):
        size = body.geometry.mean_size(size)
    lengths = box_lengths(body.geometry)
    return [max(1.0, _PACKING[len(lengths)] * length / size) for length in lengths]


def _knots_of_patches(shape: Shape) -> list[tuple[int, ...]]:
    """Knots inside each patch that a geometry brings along; a shape counts as one patch."""
    if isinstance(shape, NurbsFile):
        return _knots_of_patches(shape.given)
    if not isinstance(shape, Patches):
        return [(0,) * len(shape.directions)]
    return [
        tuple(len(knots) - 2 * p - 2 for knots, p in zip(patch.knots, patch.degrees, strict=True))
        for patch in shape.patches
    ]


def box_lengths(shape: Shape) -> list[float]:
    """Lengths (m) of a box that stands for a shape: of an arc, at its middle radius."""
    if isinstance(shape, NurbsFile):
        return box_lengths(shape.given)
    if isinstance(shape, Patches):
        points = np.concatenate([p.points.reshape(-1, len(p.degrees)) for p in shape.patches])
        return np.ptp(points, axis=0).tolist()
    if isinstance(shape, VentilatedDisc):
        return list(shape.lengths)
    spans = {n: high - low for n, (low, high) in zip(shape.directions, shape.extent, strict=True)}
    if "theta" in spans:
        low, high = shape.extent[0]
        spans["theta"] *= pi / 180 * 0.5 * (low + high)
    return list(spans.values())
