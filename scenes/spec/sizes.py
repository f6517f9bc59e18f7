"""Lengths of shapes and counts of nodes, from which sizes of meshes are judged."""

from math import inf, pi, prod

import numpy as np

from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from meshes.shapes import Shape, VentilatedDisc
from scenes.spec.body import BodySpec

MAX_ELEMENTS = 10**6
"""Elements along one direction."""


def box_lengths(shape: Shape) -> list[float]:
    """Lengths (m) of a box that stands for a shape: of an arc, at its middle radius."""
    if isinstance(shape, NurbsFile):
        shape = shape.given
    if isinstance(shape, Patches):
        points = np.concatenate([p.points.reshape(-1, len(p.degrees)) for p in shape.patches])
        return np.ptp(points, axis=0).tolist()
    if isinstance(shape, VentilatedDisc):
        return list(shape.lengths)
    spans = {n: high - low for n, (low, high) in zip(shape.directions, shape.extent, strict=True)}
    if "theta" in spans:
        spans["theta"] *= pi / 180 * 0.5 * sum(shape.extent[0])
    return list(spans.values())


def node_counts(body: BodySpec) -> list[tuple[float, ...]]:
    """Nodes along each direction of boxes that stand for a mesh, one for each patch."""
    shape, fe, iga = body.geometry, body.mesh.fe, body.mesh.iga
    lengths = box_lengths(shape)
    dim = len(lengths)
    if isinstance(shape, MeshFile):
        own = shape.elements
        degree = body.fe_degree or own.order
        nodes = len(own.used) * (degree / own.order) ** dim
        if own.incomplete:
            nodes = max(nodes, float(own.num_cells * degree**dim))
        even = (nodes / prod(lengths)) ** (1 / dim)
        return [tuple(max(1.0, even * length) for length in lengths)]
    if body.backend == "fe" and fe is not None:
        along: list[float] = list(fe.elements or ())
        if not along:  # boxes of the target edge length have about as many nodes
            size = fe.size or inf
            if isinstance(shape, VentilatedDisc):
                size = shape.mean_size(size)
            along = [max(1.0, length / size) for length in lengths]
        return [tuple(fe.degree * n + 1.0 for n in along)]
    if iga is None:
        return []
    given = shape.given if isinstance(shape, NurbsFile) else shape
    inner = [(0,) * dim]  # knots that a geometry brings along
    if isinstance(given, Patches):
        inner = [
            tuple(len(k) - 2 * p - 2 for k, p in zip(patch.knots, patch.degrees, strict=True))
            for patch in given.patches
        ]
    continuity = iga.continuity or tuple(p - 1 for p in iga.degree)
    return [
        tuple(
            float((p - c) * (n + k) + c + 1)
            for p, c, n, k in zip(iga.degree, continuity, iga.elements, knots, strict=True)
        )
        for knots in inner
    ]


def dofs_of(body: BodySpec) -> float:
    """Estimate of the unknowns of a body, supports not taken out."""
    return len(body.geometry.directions) * sum(map(prod, node_counts(body)))
