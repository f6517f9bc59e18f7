"""Drawings of modes: deformed bodies at the phase of largest deflection, coloured by magnitude."""

from collections.abc import Callable, Sequence
from io import BytesIO
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from cea.arrays import Complexes, Floats
from scenes.pictures.grids import FEATURE_ANGLE, sharp_edges

_WINDOW = (1500, 900)
DEFLECTION = 0.05
"""Largest deflection drawn, relative to the diagonal of the scene."""
SUBDIVISIONS = 2
"""Number of subdivisions of curved cells in pictures."""
_STEEP = 0.999
"""z component of the view direction above which y is used as the upright direction."""


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
