"""Pictures of modes and scenes, and the VTK grids of bodies that they and ParaView show.

Lagrange elements become VTK Lagrange cells and knot spans VTK rational Bezier cells, without
resampling. Modes are drawn at the phase of their largest deflection, coloured by magnitude.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista
from numpy.typing import NDArray
from PIL import Image
from vtkmodules.vtkCommonDataModel import (
    vtkHigherOrderHexahedron,
    vtkHigherOrderQuadrilateral,
    vtkHigherOrderTetra,
    vtkHigherOrderTriangle,
)

from cea.arrays import Complexes, Floats, Ints
from cea.body import VolumeCells
from cea.files import write_whole
from cea.petsc import MPI

if TYPE_CHECKING:
    from scenes.checking.check import Inspection

_CELL_TYPES = {
    ("lagrange", True, 2): pyvista.CellType.LAGRANGE_TRIANGLE,
    ("lagrange", True, 3): pyvista.CellType.LAGRANGE_TETRAHEDRON,
    ("lagrange", False, 2): pyvista.CellType.LAGRANGE_QUADRILATERAL,
    ("lagrange", False, 3): pyvista.CellType.LAGRANGE_HEXAHEDRON,
    ("bezier", False, 2): pyvista.CellType.BEZIER_QUADRILATERAL,
    ("bezier", False, 3): pyvista.CellType.BEZIER_HEXAHEDRON,
}

_MERGED = 1e-6
"""Distance of points that are merged, relative to the diagonal of a body."""
FEATURE_ANGLE = 30.0
"""Angle between triangles (degrees) above which their common edge is drawn as sharp."""
_SIMPLICES: dict[int, Any] = {2: vtkHigherOrderTriangle, 3: vtkHigherOrderTetra}
_BOXES: dict[int, Any] = {2: vtkHigherOrderQuadrilateral, 3: vtkHigherOrderHexahedron}
_WINDOW = (1500, 900)
DEFLECTION = 0.05
"""Largest deflection drawn, relative to the diagonal of the scene."""
SUBDIVISIONS = 2
"""Number of subdivisions of curved cells in pictures."""
_STEEP = 0.999
"""z component of the view direction above which y is used as the upright direction."""
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


def cell_grid(cells: VolumeCells) -> Any:
    """Return the cells of a body as VTK cells of the same geometry (pyvista ``UnstructuredGrid``).

    Values at the points of the grid are ``cells.values`` times the scalar dofs.
    """
    dim = cells.points.shape[1]
    count, size = cells.cells.shape
    connectivity = np.empty((count, size + 1), dtype=np.int64)
    connectivity[:, 0] = size
    connectivity[:, 1 + _vtk_positions(cells)] = cells.cells
    kinds = np.full(count, _CELL_TYPES[cells.kind, cells.simplex, dim], dtype=np.uint8)
    grid = pyvista.UnstructuredGrid(connectivity.ravel(), kinds, in_space(cells.points))
    if cells.kind == "bezier":
        degrees = np.full((count, 3), float(cells.degree))
        # pyvista would also make them the active scalars, and VTK filters then lose the weights.
        grid.GetPointData().SetRationalWeights(
            pyvista.convert_array(cells.weights, name="RationalWeights")
        )
        grid.GetCellData().SetHigherOrderDegrees(
            pyvista.convert_array(degrees, name="HigherOrderDegrees")
        )
    return grid


def outside(cells: VolumeCells, fields: Mapping[str, Floats], subdivisions: int) -> Any:
    """Return the triangulated outer surface of a body with vectors at points (``PolyData``).

    Coincident points are merged, so that interior faces are found; curved cells are subdivided.
    """
    grid = cell_grid(cells)
    for name, values in fields.items():
        grid.point_data[name] = in_space(values)
    size = float(np.linalg.norm(np.ptp(cells.points, axis=0)))
    surface = grid.clean(tolerance=_MERGED * size).extract_surface(
        nonlinear_subdivision=subdivisions, pass_cellid=True, algorithm="dataset_surface"
    )
    return surface.triangulate()


def sharp_edges(surface: Any) -> Any:
    """Return sharp edges and boundary edges of a triangulated surface (pyvista)."""
    return surface.extract_feature_edges(FEATURE_ANGLE, manifold_edges=False)


def in_space[T: np.generic](vectors: NDArray[T]) -> NDArray[T]:
    """Return vectors of shape (n, 3), with z = 0 added in 2D."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _vtk_positions(cells: VolumeCells) -> Ints:
    """Return the index in the VTK cell of each lattice point of a cell (C order)."""
    p, dim = cells.degree, cells.points.shape[1]
    lattice: Iterable[tuple[int, ...]] = product(range(p + 1), repeat=dim)
    if cells.simplex:
        inside = (point for point in lattice if sum(point) <= p)
        return np.array([_SIMPLICES[dim].Index((*point, p - sum(point)), p) for point in inside])
    return np.array([_BOXES[dim].PointIndexFromIJK(*point, (p,) * dim) for point in lattice])


def png(image: Image.Image) -> bytes:
    """Return an image as the content of a PNG file."""
    stream = BytesIO()
    image.save(stream, format="png")
    return stream.getvalue()


def draw_mode(surfaces: Sequence[Any], title: str) -> Image.Image:
    """Draw a mode; points of the surfaces have displacements ``real`` and ``imaginary``."""
    shapes = [s.point_data["real"] + 1j * s.point_data["imaginary"] for s in surfaces]
    turned, largest = largest_deflection(np.concatenate(shapes))
    at_rest = [np.array(surface.points) for surface in surfaces]
    size = float(np.linalg.norm(np.ptp(np.concatenate(at_rest), axis=0)))
    ends = np.cumsum([len(shape) for shape in shapes])[:-1]
    drawn = np.split(DEFLECTION * size * turned.real / largest, ends)

    def add(plotter: pyvista.Plotter) -> None:
        for surface, u in zip(surfaces, drawn, strict=True):
            surface.point_data["drawn"] = u
            surface.point_data["deflection"] = np.linalg.norm(u, axis=1) / (DEFLECTION * size)
            sharp = sharp_edges(surface)
            if sharp.n_points:
                plotter.add_mesh(sharp, color="#9A9A9A", line_width=3, opacity=0.6)
                plotter.add_mesh(sharp.warp_by_vector("drawn"), color="#303840", line_width=3)
            plotter.add_mesh(
                surface.warp_by_vector("drawn"),
                scalars="deflection",
                cmap="YlGnBu",
                clim=(0.0, 1.0),
                smooth_shading=True,
                split_sharp_edges=True,
                feature_angle=FEATURE_ANGLE,
                ambient=0.25,
                scalar_bar_args=bar("displacement / largest", "%.1f"),
            )

    seen = np.concatenate([*at_rest, *(x + u for x, u in zip(at_rest, drawn, strict=True))])
    return picture(add, title, view_of(at_rest), seen)


def picture(
    add: Callable[[pyvista.Plotter], None], title: str, view: Floats, seen: Floats
) -> Image.Image:
    """Return a picture of what ``add`` adds to a plotter, along ``view``, fitted to points."""
    with pyvista.vtk_verbosity("off"):  # VTK warns that there is no display
        plotter = pyvista.Plotter(off_screen=True, window_size=list(_WINDOW))
        plotter.set_background("white")
        plotter.enable_anti_aliasing("ssaa")
        add(plotter)
        text = plotter.add_title(title, font_size=15, color="#222222")
        text.SetPosition(0.5, 0.93)
        aim(plotter.camera, view, seen)
        image = Image.fromarray(plotter.screenshot(return_img=True))
        plotter.close()
    return image


def largest_deflection(shape: Complexes) -> tuple[Complexes, float]:
    """Return the mode rotated to the phase of its largest deflection, and that deflection.

    abs(Re(u e^(i phi)))^2 = (abs(u)^2 + Re(u.u e^(2 i phi))) / 2 is largest for
    phi = -arg(u.u) / 2 at a point. The sign is chosen such that the largest component there is
    positive. The real part of the returned displacements, (n, dim), is that at this phase.
    """
    square = np.einsum("ij,ij->i", shape, shape)
    deflection = np.sqrt((np.einsum("ij,ij->i", shape.conj(), shape).real + np.abs(square)) / 2)
    at = int(np.argmax(deflection))
    turned = shape * np.exp(-0.5j * np.angle(square[at]))
    real = turned[at].real
    return turned * np.sign(real[np.argmax(np.abs(real))]), float(deflection[at])


def bar(title: str, form: str) -> dict[str, Any]:
    """Return the options of a colour bar below a picture."""
    return {
        "title": f"{title}\n",
        "fmt": form,
        "n_labels": 3,
        "color": "#222222",
        "vertical": False,
        "width": 0.3,
        "height": 0.085,
        "position_x": 0.35,
        "position_y": 0.02,
        "title_font_size": 21,
        "label_font_size": 19,
    }


def view_of(bodies: Sequence[Floats]) -> Floats:
    """Return the unit vector towards the camera, on the side of the smallest body."""
    smallest = min(bodies, key=lambda points: float(np.prod(np.ptp(points, axis=0) + 1e-12)))
    if not np.ptp(np.concatenate(list(bodies))[:, 2:]):  # in the plane
        return np.array([0.0, 0.0, 1.0])
    points = np.concatenate(list(bodies))
    offset = smallest.mean(axis=0) - (points.min(axis=0) + points.max(axis=0)) / 2
    beside = np.hypot(offset[0], offset[1]) > 0.05 * np.linalg.norm(np.ptp(points, axis=0))
    azimuth = np.arctan2(offset[1], offset[0]) - np.pi / 6 if beside else -np.pi / 3
    elevation = np.copysign(np.radians(38.0), offset[2])
    flat = np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])


def aim(camera: Any, view: Floats, points: Floats) -> None:
    """Set a parallel projection along ``view`` that fits the points into the window."""
    upright = np.array([0.0, 1.0, 0.0]) if abs(view[2]) > _STEEP else np.array([0.0, 0.0, 1.0])
    right = np.cross(upright, view)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(view, right), view])
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, depth = high - low
    # Space above for the title and below for the colour bar.
    scale = 0.5 * max(height / 0.72, width * _WINDOW[1] / _WINDOW[0] / 0.9)
    focus = axes.T @ ((low + high) / 2 - [0.0, 0.06 * scale, 0.0])
    camera.enable_parallel_projection()
    camera.focal_point = focus
    far = max(depth, scale)  # flat parts have no depth
    camera.position = focus + 2 * far * view
    camera.up = axes[1]
    camera.parallel_scale = scale
    camera.clipping_range = (0.5 * far, 4 * far)


def draw_scene(inspection: "Inspection", file: str | Path) -> Path:
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


def _add_surfaces(plotter: pyvista.Plotter, inspection: "Inspection", size: float) -> None:
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
    inspection: "Inspection",
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
