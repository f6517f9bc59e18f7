"""A picture of a scene before it is run: bodies, named surfaces, supports, contact points."""

from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact
from cea.files import write_whole
from cea.petsc import MPI
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from scenes.checking.check import Inspection, gaps
from scenes.pictures.drawing import SUBDIVISIONS, aim, view_of
from scenes.pictures.grids import in_space, merged, outside, sharp_edges

_WINDOW = (1100, 900)
"""Width and height of each of both panels (pixels)."""
_DIVIDED = 4
"""Parts of each cell of a surface along each direction, as drawn."""
_ARROWS = 24
"""Arrows of a contact, at most."""
_LENGTH = 0.06
"""Length of an arrow, relative to the diagonal of what is drawn of the contacts."""
_AROUND = 0.25
"""What is seen around the contact points, relative to their diagonal."""
_ROOM = 0.15
"""Room that a name takes, relative to the diagonal."""
_DOTS = 200.0
"""Size of points times the root of their number (pixels)."""
_CLOSED = 1e-6
"""Gaps below this, relative to the diagonal, have the colour of none."""
_LIFT = 2e-3
"""Distance of what is drawn on a surface from it, relative to the diagonal."""
_PANELS = (
    ("bodies, surfaces, supports", "dark: held; light blue: held in part"),
    ("contact points", "grey: normals of a; red: friction on a"),
)
"""Title and legend of each panel."""
_COLOURS = ("#B9C7D6", "#D9C9A5", "#BCD4B8", "#D8BBC4", "#C5BEDC", "#BFD7D9")
_HELD, _PARTLY, _NORMAL, _FRICTION = "#1F3A5F", "#6C8EBF", "#444444", "#C0392B"


def draw_scene(inspection: Inspection, file: str | Path) -> Path:
    """Draw a scene that was looked at; collective.

    Left: bodies with the names of their surfaces, held surfaces dark where every component is held
    and light where some are. Right: bodies translucent, contact points coloured by the distance
    between the sides, outward normals of side a grey, the direction of friction on a red.

    Parameters
    ----------
    inspection
        The scene, its bodies and contact points.
    file
        The PNG file, which rank 0 writes.

    Returns
    -------
    Path
        The file.
    """
    cells = [body.volume_cells() for body in inspection.bodies.values()]
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
                edges = sharp_edges(surface)
                colour = _COLOURS[number % len(_COLOURS)]
                plotter.add_mesh(
                    surface, color=colour, opacity=0.22 if panel else 1.0, ambient=0.25
                )
                if edges.n_points:
                    plotter.add_mesh(edges, color="#303840", line_width=2)
            plotter.add_text(f"{inspection.scene.name}: {title}", font_size=14, color="#222222")
            plotter.add_text(legend, position="lower_left", font_size=10, color="#222222")
            if panel == 0:
                _add_supports(plotter, inspection, size)
                _add_names(plotter, inspection.bodies, view, size)
                seen = points
            else:
                seen = _surroundings(inspection.halves.values(), points)
                _add_contacts(plotter, inspection.halves, distances, seen)
            aim(plotter.camera, view, seen, _WINDOW)
        plotter.enable_anti_aliasing("msaa", multi_samples=8)
        image = Image.fromarray(plotter.screenshot(return_img=True))
        plotter.close()
    stream = BytesIO()
    image.save(stream, format="png")
    write_whole(stream.getvalue(), Path(file))
    return Path(file)


def _add_supports(plotter: Any, inspection: Inspection, size: float) -> None:
    """Held surfaces, dark where no component is free."""
    for name, spec in inspection.scene.bodies.items():
        for support in spec.supports:
            surface = inspection.bodies[name].surfaces[support.surface]
            colour = _PARTLY if 0 < len(set(support.components)) < surface.dim else _HELD
            mesh = _surface_mesh(surface, _LIFT * size)
            plotter.add_mesh(mesh, color=colour, opacity=0.75, line_width=9)


def _surroundings(halves: Iterable[Contact], points: Floats) -> Floats:
    """Corners of a box around the contact points (m), shape (n, 3); all points where none is."""
    touching = [in_space(half.interface.points.x) for half in halves]
    if not touching:
        return points
    every = np.concatenate(touching)
    low, high = every.min(axis=0), every.max(axis=0)
    room = _AROUND * np.linalg.norm(high - low)
    low, high = (
        np.maximum(low - room, points.min(axis=0)),
        np.minimum(high + room, points.max(axis=0)),
    )
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)


def _add_names(plotter: Any, bodies: Mapping[str, Body], view: Floats, size: float) -> None:
    """Names of the surfaces, each on its surface, where it is seen and far from other names."""
    across = np.linalg.svd(view[None])[2][1:]
    places: list[Floats] = []
    names = []
    for name, body in bodies.items():
        for surface_name, surface in body.surfaces.items():
            centres, normals = _cell_centres(surface)
            flat = centres @ across.T
            others = np.array(places).reshape(-1, 3) @ across.T
            apart = np.linalg.norm(flat[:, None] - others[None], axis=2).min(axis=1, initial=size)
            score = np.minimum(apart / size, _ROOM) + _ROOM * np.minimum(normals @ view, 0.1)
            middle = np.linalg.norm(centres - centres.mean(axis=0), axis=1) / size
            places.append(centres[np.argmax(score - 0.1 * _ROOM * middle)])
            names.append(f"{name}.{surface_name}")
    for place, name in zip(places, names, strict=True):  # together some would be left out
        plotter.add_point_labels(
            place[None],
            [name],
            font_size=13,
            text_color="#222222",
            shape_color="white",
            shape_opacity=0.75,
            point_size=7,
            point_color="#222222",
            always_visible=True,
        )


def _add_contacts(
    plotter: Any, halves: Mapping[str, Contact], distances: Mapping[str, Floats], seen: Floats
) -> None:
    """Contact points by their gap, normals and directions of friction."""
    size = float(np.linalg.norm(np.ptp(seen, axis=0)))
    if not halves:
        return
    widest = max(float(np.abs(gap).max(initial=0.0)) for gap in distances.values())
    widest = max(widest, _CLOSED * size)
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
            scalar_bar_args=_BAR,
        )
        chosen = _spread(points.x)
        x, normal = points.x[chosen], points.normal[chosen]
        _add_arrows(plotter, x, normal, 0.6 * _LENGTH * size, _NORMAL)
        if half.friction is not None:
            direction = half.friction.direction.at(x, normal)
            inside = x - 0.2 * _LENGTH * size * normal  # points would hide what lies among them
            _add_arrows(plotter, inside, direction, _LENGTH * size, _FRICTION)


_BAR = {
    "title": "distance of the sides (m)\n",
    "color": "#222222",
    "vertical": False,
    "width": 0.4,
    "height": 0.08,
    "position_x": 0.45,
    "position_y": 0.02,
    "title_font_size": 20,
    "label_font_size": 17,
    "n_labels": 3,
    "fmt": "%.2g",
}


def _add_arrows(plotter: Any, x: Floats, vectors: Floats, length: float, colour: str) -> None:
    arrows = pyvista.PolyData(in_space(x))
    arrows.point_data["vectors"] = in_space(vectors)
    glyphs = arrows.glyph(orient="vectors", scale=False, factor=length)
    plotter.add_mesh(glyphs, color=colour)


def _spread(x: Floats) -> Sequence[int]:
    """Numbers of some points that lie far from each other: each the farthest from those before."""
    chosen, far = [0], np.full(len(x), np.inf)
    for _ in range(min(_ARROWS, len(x)) - 1):
        far = np.minimum(far, np.linalg.norm(x - x[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(far)))
    return chosen


def _cell_centres(surface: Surface) -> tuple[Floats, Floats]:
    """Middle of each cell of a surface (m) and outward normals there, shape (n, 3) each."""
    cells = surface.cells()
    at = SurfaceCoordinates(cells.element, cells.corners.mean(axis=1))
    return in_space(surface.position(at)), in_space(surface.normal(at))


def _surface_mesh(surface: Surface, lift: float) -> Any:
    """A surface in flat pieces, or a curve in straight ones, a little outside of itself."""
    cells = surface.cells()
    weights, pieces = _pieces(cells.corners.shape[1])
    xi = np.einsum("pc,ncd->npd", weights, cells.corners)
    at = SurfaceCoordinates(np.repeat(cells.element, len(weights)), xi.reshape(-1, xi.shape[-1]))
    x = in_space(surface.position(at) + lift * surface.normal(at))
    every = (pieces[None] + len(weights) * np.arange(len(xi))[:, None, None]).reshape(
        -1, pieces.shape[1]
    )
    lists = np.column_stack([np.full(len(every), every.shape[1]), every]).ravel()
    return pyvista.PolyData(x, **{"lines" if every.shape[1] == 2 else "faces": lists})


def _pieces(corners: int) -> tuple[Floats, np.ndarray]:
    """Points of a cell as weights of its corners (points, corners), and the pieces they bound."""
    t = np.linspace(0.0, 1.0, _DIVIDED + 1)
    number = np.arange(_DIVIDED)
    if corners == 2:
        return np.column_stack([1 - t, t]), np.column_stack([number, number + 1])
    if corners == 3:
        return np.eye(3), np.array([[0, 1, 2]])
    u, v = (each.ravel() for each in np.meshgrid(t, t, indexing="ij"))
    i, j = (each.ravel() for each in np.meshgrid(number, number, indexing="ij"))
    first = (_DIVIDED + 1) * i + j
    weights = np.column_stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    return weights, np.column_stack([first, first + _DIVIDED + 1, first + _DIVIDED + 2, first + 1])
