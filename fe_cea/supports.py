"""Supports of a Lagrange body: constrained directions at its interpolation nodes."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.supports.boundary import Support
from cea.supports.constraints import Constraints, Directions, constrain, merged
from fe_cea.facets import FacetBasis
from fe_cea.surface import FESurface

_CREASE = np.cos(np.deg2rad(40.0))
"""Cosine between normals at a node below which facets belong to different faces."""


def nodal_constraints(
    V: Any,
    surfaces: Mapping[str, FESurface],
    supports: Sequence[Support],
    num_scalar_dofs: int,
    field: str,
) -> Constraints:
    """Return the constraints of the supports at every node of their surfaces.

    The normal at a node is the mean over its facets on surfaces with rollers whose normals differ
    by less than 40 degrees, as on one curved face; faces that meet at a sharper edge constrain one
    direction each. Facets of a circular boundary are polynomials: their normals constrain the
    rotation about the axis weakly, by their deviation from a circle; radial components do not.
    """
    dim = V.mesh.geometry.dim
    points = FacetBasis(V.ufl_element().basix_element).facet.points
    held, rollers = [], []
    for number, support in enumerate(supports):
        dofs, x, normal = _nodes(surfaces[support.surface], points)
        values = support.values(dim)
        if "normal" in support.components:
            rollers.append(Directions.of(dofs, normal, values[0], number))
            continue
        nodes, first = np.unique(dofs, return_index=True)
        for direction, value in zip(
            support.directions(x[first], normal[first]), values, strict=True
        ):
            held.append(Directions.of(nodes, direction, value, number))
    if rollers:
        held.append(_mean_normals(Directions.joined(rollers, dim), field))
    return constrain(num_scalar_dofs, Directions.joined(held, dim), field=field)


def _nodes(surface: FESurface, points: Floats) -> tuple[Ints, Floats, Floats]:
    """Return the nodes of all facets of a surface: scalar dofs, positions, outward normals."""
    at, _ = surface.cells.coordinates(points)
    trace = surface.trace(at)
    # A Lagrange function is one at its own node, zero at the others of its facet.
    own = trace.data.reshape(len(at), -1).argmax(axis=1)
    dofs = trace.indices.reshape(len(at), -1)[np.arange(len(at)), own].astype(np.int64)
    return dofs, surface.position(at), surface.normal(at)


def _mean_normals(normals: Directions, field: str) -> Directions:
    """Return one direction for all near normals at a node, shared by all their supports."""
    label = merged(normals, _CREASE)
    count = label.max(initial=-1) + 1
    mean = np.zeros((count, normals.direction.shape[1]))
    np.add.at(mean, label, normals.direction)
    dofs = np.zeros(count, dtype=np.int64)
    dofs[label] = normals.dof
    directions = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    value = np.zeros(count)
    value[label] = normals.value
    wrong = normals.value[value[label] != normals.value]
    if len(wrong):
        allowed = "the same along normals of faces that join smoothly"
        raise InputError(f"{field}.value", float(wrong[0]), allowed)
    own, support = np.unique(np.column_stack([label, normals.support]), axis=0).T
    return Directions(dofs[own], directions[own], value[own], support)
