"""Outsides of bodies with fewer points, for meshes finer than a page can hold."""

from collections.abc import Mapping

import numpy as np
import pyvista

from scenes.pictures.grids import in_space
from scenes.pictures.skin import Skin, sharp_edges

_FEATURE_ANGLE = 15.0
"""Angle between triangles (degrees) from which on their edge is kept as long as possible."""


def reduced(outside: Mapping[str, Skin], points: int) -> dict[str, Skin]:
    """Outsides that have no more points together than allowed, each reduced alike.

    Parameters
    ----------
    outside
        Outsides by the name of their bodies.
    points
        Points they may have together; where they have no more they stay as they are.

    Returns
    -------
    dict
        Their points are some of those given, so that displacements are exact there. Edges of
        elements, which no longer are edges of triangles, are left out where points are.
    """
    total = sum(len(skin.points) for skin in outside.values())
    if total <= points:
        return dict(outside)
    return {name: _reduced(skin, 1 - points / total) for name, skin in outside.items()}


def _reduced(skin: Skin, share: float) -> Skin:
    """An outside without a share of its points."""
    surface = pyvista.PolyData.from_regular_faces(in_space(skin.points), skin.triangles)
    surface.point_data["number"] = np.arange(len(skin.points))
    fewer = surface.decimate_pro(
        share, feature_angle=_FEATURE_ANGLE, preserve_topology=True, boundary_vertex_deletion=False
    )
    kept = np.asarray(fewer.point_data["number"], dtype=np.int64)
    triangles = fewer.regular_faces.astype(np.int64)
    return Skin(
        points=skin.points[kept],
        triangles=triangles,
        edges=np.empty((0, 2), dtype=np.int64),
        sharp=sharp_edges(skin.points[kept], triangles),
        values=skin.values[kept],
    )
