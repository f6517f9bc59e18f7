"""Pictures of a mode made of its files for ParaView alone, as any program would read them."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from cea.arrays import Complexes, Floats
from cea.files import write_whole
from scenes.pictures.drawing import DEFLECTION, aim, largest_deflection, view_of

_WINDOW = (1800, 800)
_HALF_WINDOW = (_WINDOW[0] // 2, _WINDOW[1])
_SUBDIVISIONS = 2
"""Times VTK halves the edges of curved cells to draw them flat."""
_FEATURE_ANGLE = 30.0
_FILLED = 1.8
"""Width of the mark of a contact point relative to the room that it has; smoothing halves it."""
_MARGIN = 0.03
"""How far edges of the bodies are shown around the contact, relative to its diagonal."""
_BAR = {
    "color": "#222222",
    "vertical": False,
    "width": 0.5,
    "height": 0.085,
    "position_x": 0.25,
    "position_y": 0.02,
    "title_font_size": 21,
    "label_font_size": 19,
    "n_labels": 3,
    "fmt": "%.1f",
}


def draw_files(modes: Path, contacts: Path, file: Path) -> None:
    """Draw the first mode of the files that :func:`scenes.export.paraview.write_paraview` wrote.

    The phase is that of largest deflection; displacement and pressure are relative to the largest.

    Parameters
    ----------
    modes, contacts
        ``.pvd`` files of the bodies and of the contact points, penalty form.
    file
        The PNG file.
    """
    bodies, points = (list(pyvista.read(collection)) for collection in (modes, contacts))
    skins = [
        body.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=_SUBDIVISIONS)
        for body in bodies
    ]
    shape = np.concatenate([_complex(skin, "displacement") for skin in skins])
    turned, largest = largest_deflection(shape)
    phase = np.vdot(shape, turned) / np.vdot(shape, shape)
    edges = [skin.extract_feature_edges(_FEATURE_ANGLE, manifold_edges=False) for skin in skins]
    with pyvista.vtk_verbosity("off"):
        plotter = pyvista.Plotter(
            off_screen=True, window_size=list(_WINDOW), shape=(1, 2), border=False
        )
        plotter.set_background("white")
        plotter.enable_anti_aliasing("ssaa")
        _draw_bodies(plotter, skins, phase, largest)
        _write(plotter, _told(bodies[0]))
        plotter.subplot(0, 1)
        _draw_pressure(plotter, points, phase, edges)
        _write(plotter, "contact pressure")
        image = Image.fromarray(plotter.screenshot(return_img=True))
        plotter.close()
    stream = BytesIO()
    image.save(stream, format="png")
    write_whole(stream.getvalue(), file)


def _complex(grid: Any, name: str) -> Complexes:
    return grid.point_data[f"{name}_real"] + 1j * grid.point_data[f"{name}_imag"]


def _told(body: Any) -> str:
    """Kind of cells, number, frequency and growth rate of a mode, as its file tells them."""
    kind = pyvista.CellType(body.celltypes[0]).name.replace("_", " ").capitalize()
    number, frequency, growth = (
        body.field_data[name][0] for name in ("mode", "frequency", "growth rate")
    )
    return f"{kind}, mode {number:.0f}: {frequency:.2f} Hz, growth rate {growth:+.2f} 1/s"


def _write(plotter: Any, title: str) -> None:
    text = plotter.add_title(title, font_size=11, color="#222222")
    text.SetPosition(0.5, 0.93)


def _draw_bodies(plotter: Any, skins: list[Any], phase: complex, largest: float) -> None:
    """Deformed bodies, coloured by the magnitude of their displacement."""
    at_rest = [np.array(skin.points) for skin in skins]
    size = float(np.linalg.norm(np.ptp(np.concatenate(at_rest), axis=0)))
    for skin in skins:
        u = (phase * _complex(skin, "displacement")).real
        deformed = skin.copy()
        deformed.points = skin.points + DEFLECTION * size / largest * u
        deformed.point_data["deflection"] = np.linalg.norm(u, axis=1) / largest
        plotter.add_mesh(
            deformed,
            scalars="deflection",
            cmap="YlGnBu",
            clim=(0.0, 1.0),
            smooth_shading=True,
            split_sharp_edges=True,
            ambient=0.25,
            scalar_bar_args=_BAR | {"title": "displacement / largest\n"},
        )
    aim(plotter.camera, view_of(at_rest), np.concatenate(at_rest), _HALF_WINDOW)


def _draw_pressure(plotter: Any, contacts: list[Any], phase: complex, edges: list[Any]) -> None:
    """Contact pressure at the contact points, seen from side a, and edges of the bodies at rest."""
    pressures = [(phase * _complex(points, "pressure")).real for points in contacts]
    largest = max(float(np.abs(pressure).max()) for pressure in pressures)
    seen: Floats = np.concatenate([points.points for points in contacts])
    normal = np.concatenate([points.point_data["normal"] for points in contacts]).mean(axis=0)
    aim(plotter.camera, -normal / np.linalg.norm(normal), seen, _HALF_WINDOW)
    pixels = _WINDOW[1] / (2 * plotter.camera.parallel_scale)
    for points, pressure in zip(contacts, pressures, strict=True):
        room = np.sqrt(points.point_data["weight"].mean())
        coloured = pyvista.PolyData(points.points)
        coloured.point_data["pressure"] = pressure / largest
        plotter.add_mesh(
            coloured,
            scalars="pressure",
            cmap="RdBu_r",
            clim=(-1.0, 1.0),
            point_size=_FILLED * room * pixels,
            reset_camera=False,
            lighting=False,
            scalar_bar_args=_BAR | {"title": "pressure / largest\n"},
        )
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = _MARGIN * np.linalg.norm(high - low)
    box = np.stack([low - margin, high + margin], axis=1).ravel()
    for lines in edges:
        near = lines.clip_box(box, invert=False)
        if near.n_points:
            plotter.add_mesh(near, color="#9A9A9A", line_width=2, reset_camera=False)
