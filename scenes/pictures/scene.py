"""Picture of a scene before a run: bodies, surface names, supports, contact points."""

from pathlib import Path

import numpy as np
import pyvista

from cea.files import write_whole
from cea.petsc import MPI
from scenes.checking.check import Inspection
from scenes.pictures.drawing import SUBDIVISIONS, bar, picture, png, view_of
from scenes.pictures.grids import in_space, outside, sharp_edges

_ARROWS = 24
"""Largest number of friction arrows per contact."""
_LENGTH = 0.04
"""Length of an arrow, relative to the diagonal of the scene."""
_CLOSED = 1e-6
"""Smallest range of the colour scale of gaps, relative to the diagonal."""
_LIFT = 2e-3
"""Offset of points drawn on a surface from it, relative to the diagonal."""
_LEGEND = "blue: fixed; light blue: partly supported; red arrows: friction on side a"
_HELD, _PARTLY, _FRICTION = "#1F3A5F", "#6C8EBF", "#C0392B"


def draw_scene(inspection: Inspection, file: str | Path) -> Path:
    """Draw an inspected scene to a PNG file, written by rank 0; collective.

    Bodies are translucent. Surfaces have their names, supported surfaces blue points, contacts
    their points coloured by the gap, and arrows of the friction direction on side a.
    """
    cells = [body.space.volume_cells() for body in inspection.bodies.values()]
    distances = {name: half.initial_gap for name, half in inspection.halves.items()}
    if MPI.COMM_WORLD.rank > 0:
        return Path(file)
    surfaces = [outside(each, {}, SUBDIVISIONS) for each in cells]
    points = np.concatenate([surface.points for surface in surfaces])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))

    def add(plotter: pyvista.Plotter) -> None:
        for surface in surfaces:
            plotter.add_mesh(surface, color="#B9C7D6", opacity=0.4, ambient=0.25)
            edges = sharp_edges(surface)
            if edges.n_points:
                plotter.add_mesh(edges, color="#303840", line_width=2)
        _add_surfaces(plotter, inspection, size)
        _add_contacts(plotter, inspection, distances, size)
        plotter.add_text(_LEGEND, position="upper_left", font_size=10, color="#222222")

    view = view_of([surface.points for surface in surfaces])
    return write_whole(png(picture(add, inspection.scene.name, view, points)), Path(file))


def _add_surfaces(plotter: pyvista.Plotter, inspection: Inspection, size: float) -> None:
    """Draw names of surfaces, and points on supported ones, dark if every component is held."""
    for name, body in inspection.bodies.items():
        supports = inspection.scene.bodies[name].supports
        for surface_name, surface in body.surfaces.items():
            points = surface.grid(4)
            x = in_space(points.x) + _LIFT * size * in_space(points.normal)
            for support in supports:
                if support.surface == surface_name:
                    held = len(set(support.components)) in (0, surface.dim)
                    cloud, colour = pyvista.PolyData(x), _HELD if held else _PARTLY
                    plotter.add_mesh(cloud, color=colour, point_size=9)
            plotter.add_point_labels(  # one by one: labels of one call may be omitted
                x[[len(x) // 2]],
                [f"{name}.{surface_name}"],
                font_size=13,
                text_color="#222222",
                shape_color="white",
                shape_opacity=0.75,
                point_size=7,
                point_color="#222222",
                always_visible=True,
            )


def _add_contacts(
    plotter: pyvista.Plotter,
    inspection: Inspection,
    distances: dict[str, np.ndarray],
    size: float,
) -> None:
    """Draw contact points coloured by the gap, and friction directions."""
    widest = max([_CLOSED * size, *(float(np.abs(gap).max()) for gap in distances.values())])
    for name, half in inspection.halves.items():
        points = half.interface.points
        cloud = pyvista.PolyData(in_space(points.x))
        cloud.point_data["gap"] = distances[name]
        plotter.add_mesh(
            cloud,
            scalars="gap",
            cmap="coolwarm",
            clim=(-widest, widest),
            point_size=6,
            scalar_bar_args=bar("distance of the sides (m)", "%.2g"),
        )
        if half.friction is not None:
            chosen = np.linspace(0, len(points) - 1, min(_ARROWS, len(points))).astype(int)
            arrows = pyvista.PolyData(in_space(points.x[chosen]))
            along = half.friction.along(points.x[chosen], points.normal[chosen])
            arrows.point_data["friction"] = in_space(along)
            glyphs = arrows.glyph(orient="friction", scale=False, factor=_LENGTH * size)
            plotter.add_mesh(glyphs, color=_FRICTION)
