"""Supports of a Lagrange body: directions held at its interpolation nodes."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.supports.boundary import Support
from cea.supports.constraints import Constraints
from cea.supports.directions import Directions, merged
from cea.supports.elimination import constrain
from fe_cea.facets import FacetBasis
from fe_cea.surface import FESurface

_CREASE = np.cos(np.deg2rad(40.0))
"""Facets whose normals at a node differ by more are faces that meet at an edge of the body."""


def nodal_constraints(
    V: Any,
    surfaces: Mapping[str, FESurface],
    supports: Sequence[Support],
    num_scalar_dofs: int,
    field: str,
) -> Constraints:
    """Hold the directions of the supports at every node of their surfaces.

    The normal at a node is the mean over the facets there that belong to surfaces on rollers and
    turn by less than 40 degrees from one to the next, as facets of one curved face do; faces that
    meet at a sharper edge hold a direction each. Facets of a round rim are polynomials: normal to
    them, a rotation about the axis is held as weakly as they err from a circle, by radial not at
    all.
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
    """Nodes of every facet of a surface: scalar dofs, positions, outward normals."""
    at, _ = surface.cells().coordinates(points)
    trace = surface.trace(at)
    # A Lagrange function is one at its own node, zero at the others of its facet.
    own = trace.data.reshape(len(at), -1).argmax(axis=1)
    dofs = trace.indices.reshape(len(at), -1)[np.arange(len(at)), own].astype(np.int64)
    return dofs, surface.position(at), surface.normal(at)


def _mean_normals(normals: Directions, field: str) -> Directions:
    """One direction for all normals that are near at a node, held by each of their supports."""
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
