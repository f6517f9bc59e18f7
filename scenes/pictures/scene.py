"""Picture of a scene before a run: bodies, surface names, supports, contact points."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.files import write_whole
from cea.petsc import MPI
from cea.surface import Surface
from scenes.checking.check import Inspection, gaps
from scenes.pictures.drawing import SUBDIVISIONS, aim, bar, png, view_of
from scenes.pictures.grids import in_space, merged, outside, sharp_edges

_WINDOW = (1100, 900)
"""Width and height of each of the two panels (pixels)."""
_ARROWS = 24
"""Largest number of arrows of each kind per contact."""
_LENGTH = 0.06
"""Length of an arrow, relative to the diagonal of the right panel's view."""
_AROUND = 0.25
"""Margin around the contact points in the right panel, relative to their diagonal."""
_DOTS = 200.0
"""Size of points (pixels) times the square root of their number."""
_CLOSED = 1e-6
"""Smallest range of the colour scale of gaps, relative to the diagonal."""
_LIFT = 2e-3
"""Offset of points drawn on a surface from it, relative to the diagonal."""
_PANELS = (
    ("bodies, surfaces, supports", "dark: fixed; light blue: partly supported"),
    ("contact points", "grey: normals of a; red: friction on a"),
)
"""Title and legend of each panel."""
_COLOURS = ("#B9C7D6", "#D9C9A5", "#BCD4B8", "#D8BBC4", "#C5BEDC", "#BFD7D9")
_HELD, _PARTLY, _NORMAL, _FRICTION = "#1F3A5F", "#6C8EBF", "#444444", "#C0392B"


def draw_scene(inspection: Inspection, file: str | Path) -> Path:
    """Draw an inspected scene to a PNG file, written by rank 0; collective.

    The left panel shows bodies with the names of their surfaces, and supported surfaces, dark if
    every component is held and light otherwise. The right panel shows translucent bodies, contact
    points coloured by the gap, outward normals of side a (grey) and the friction direction on side
    a (red).
    """
    cells = [body.space.volume_cells() for body in inspection.bodies.values()]
    distances = {name: gaps(half) for name, half in inspection.halves.items()}
    if MPI.COMM_WORLD.rank > 0:
        return Path(file)
    surfaces = [outside(merged(each), {}, SUBDIVISIONS) for each in cells]
    points = np.concatenate([surface.points for surface in surfaces])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    view = view_of([surface.points for surface in surfaces])
    with pyvista.vtk_verbosity("off"):
        window = [2 * _WINDOW[0], _WINDOW[1]]
        plotter = pyvista.Plotter(off_screen=True, window_size=window, shape=(1, 2))
        plotter.set_background("white")
        for panel, (title, legend) in enumerate(_PANELS):
            plotter.subplot(0, panel)
            for number, surface in enumerate(surfaces):
                colour, edges = _COLOURS[number % len(_COLOURS)], sharp_edges(surface)
                opacity = 0.22 if panel else 1.0
                plotter.add_mesh(surface, color=colour, opacity=opacity, ambient=0.25)
                if edges.n_points:
                    plotter.add_mesh(edges, color="#303840", line_width=2)
            plotter.add_text(f"{inspection.scene.name}: {title}", font_size=14, color="#222222")
            plotter.add_text(legend, position="lower_left", font_size=10, color="#222222")
            if panel == 0:
                _add_supports(plotter, inspection, size)
                _add_names(plotter, inspection, view)
                seen = points
            else:
                seen = _box_around(inspection.halves, points)
                _add_contacts(plotter, inspection.halves, distances, seen)
            aim(plotter.camera, view, seen, _WINDOW)
        plotter.enable_anti_aliasing("msaa", multi_samples=8)
        image = Image.fromarray(plotter.screenshot(return_img=True))
        plotter.close()
    return write_whole(png(image), Path(file))


def _points_on(surface: Surface) -> tuple[Floats, Floats]:
    """Return points of a grid on a surface (m) and outward normals there, (n, 3) each."""
    points = surface.grid(4)
    return in_space(points.x), in_space(points.normal)


def _add_supports(plotter: Any, inspection: Inspection, size: float) -> None:
    """Draw points on supported surfaces, dark if every component is held."""
    for name, spec in inspection.scene.bodies.items():
        for support in spec.supports:
            surface = inspection.bodies[name].surfaces[support.surface]
            colour = _PARTLY if 0 < len(set(support.components)) < surface.dim else _HELD
            x, normal = _points_on(surface)
            cloud = pyvista.PolyData(x + _LIFT * size * normal)
            plotter.add_mesh(cloud, color=colour, point_size=9, render_points_as_spheres=True)


def _add_names(plotter: Any, inspection: Inspection, view: Floats) -> None:
    """Draw the names of the surfaces, each at a point that faces the camera."""
    for name, body in inspection.bodies.items():
        for surface_name, surface in body.surfaces.items():
            x, normal = _points_on(surface)
            aside = np.linalg.norm(x - x.mean(axis=0), axis=1)
            best = np.argmax(normal @ view - aside / aside.max())
            plotter.add_point_labels(  # one by one: labels of one call may be omitted
                x[[best]],
                [f"{name}.{surface_name}"],
                font_size=13,
                text_color="#222222",
                shape_color="white",
                shape_opacity=0.75,
                point_size=7,
                point_color="#222222",
                always_visible=True,
            )


def _box_around(halves: Mapping[str, Contact], points: Floats) -> Floats:
    """Return the corners (m), (8, 3), of a box around the contact points; else ``points``."""
    if not halves:
        return points
    every = np.concatenate([in_space(half.interface.points.x) for half in halves.values()])
    low, high = every.min(axis=0), every.max(axis=0)
    room = _AROUND * np.linalg.norm(high - low)
    ends = np.stack([low - room, high + room]).clip(points.min(axis=0), points.max(axis=0))
    return np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 3)


def _add_contacts(
    plotter: Any, halves: Mapping[str, Contact], distances: Mapping[str, Floats], seen: Floats
) -> None:
    """Draw contact points coloured by gap, normals and friction directions."""
    size = float(np.linalg.norm(np.ptp(seen, axis=0)))
    largest = [float(np.abs(gap).max(initial=0.0)) for gap in distances.values()]
    widest = max([_CLOSED * size, *largest])
    for name, half in halves.items():
        points = half.interface.points
        cloud = pyvista.PolyData(in_space(points.x))
        cloud.point_data["gap"] = distances[name]
        plotter.add_mesh(
            cloud,
            scalars="gap",
            cmap="coolwarm",
            clim=(-widest, widest),
            point_size=max(4.0, min(10.0, _DOTS / np.sqrt(len(points)))),
            render_points_as_spheres=True,
            scalar_bar_args=bar("distance of the sides (m)", "%.2g"),
        )
        chosen = np.linspace(0, len(points) - 1, min(_ARROWS, len(points))).astype(int)
        x, normal = points.x[chosen], points.normal[chosen]
        arrows = [(x, normal, 0.6, _NORMAL)]
        if half.friction is not None:
            inside = x - 0.2 * _LENGTH * size * normal  # else hidden by the points
            arrows.append((inside, half.friction.along(x, normal), 1.0, _FRICTION))
        for at, vectors, length, colour in arrows:
            cloud = pyvista.PolyData(in_space(at))
            cloud.point_data["vectors"] = in_space(vectors)
            factor = length * _LENGTH * size
            glyphs = cloud.glyph(orient="vectors", scale=False, factor=factor)
            plotter.add_mesh(glyphs, color=colour)
