"""Pictures of modes: bodies deformed at the phase of largest deflection, coloured by magnitude."""

from pathlib import Path
from typing import Any

import numpy as np
import pyvista

from cea.body import Floats, VolumeSample
from cea.errors import InputError
from cea.modes import Complexes
from comparisons.match import complex_displacement
from comparisons.report.numbers import backend_name
from comparisons.run import SceneResult
from comparisons.scene import ComplexEigenvalueAnalysis

_WINDOW = (1500, 900)
_DEFLECTION = 0.05
"""Largest deflection drawn, relative to the diagonal of the scene."""
_MERGED = 1e-6
"""Sample points nearer than this, relative to the diagonal, are one point."""
_FEATURE_ANGLE = 30.0
_CELL_TYPES = {
    (2, 3): pyvista.CellType.TRIANGLE,
    (2, 4): pyvista.CellType.QUAD,
    (3, 4): pyvista.CellType.TETRA,
    (3, 8): pyvista.CellType.HEXAHEDRON,
}


def draw_modes(result: SceneResult, count: int, out: Path) -> list[Path]:
    """Draw the most unstable modes, or the first ones where none is unstable.

    Parameters
    ----------
    result
        A complex eigenvalue analysis.
    count
        Number of pictures at most.
    out
        Folder for the PNG files ``mode_<backend>_<number of the mode>.png``.

    Returns
    -------
    list of Path
        The files, the most unstable mode first; rank 0 writes them.

    Raises
    ------
    InputError
        When the scene has no modes.
    """
    if result.modes is None:
        raise InputError("output.pictures", count, "0 for a static analysis: it has no modes")
    bodies = result.system.bodies
    backend = "+".join(sorted({spec.backend for spec in result.scene.bodies.values()}))
    samples = {name: body.volume_sample(2) for name, body in bodies.items()}
    is_root = next(iter(bodies.values())).comm.rank == 0
    if is_root:
        out.mkdir(parents=True, exist_ok=True)
    files = []
    for mode in chosen_modes(result, count):
        vector = result.modes.vector(mode)
        dofs = {
            name: complex_displacement(result.system, name, *vector, everywhere=False)
            for name in bodies
        }
        for part in vector:
            part.destroy()
        file = out / f"mode_{backend}_{mode + 1}.png"
        files.append(file)
        if is_root:
            title = (
                f"{backend_name(backend)}, mode {mode + 1}: "
                f"{result.modes.frequencies[mode]:.2f} Hz, "
                f"growth rate {result.modes.growth_rates[mode]:+.2f} 1/s"
            )
            shapes = {name: samples[name].values @ dofs[name] for name in bodies}
            _draw(samples, shapes, title, file)
    return files


def chosen_modes(result: SceneResult, count: int) -> list[int]:
    """Numbers, from 0, of the most unstable modes; of the first ones where none is unstable."""
    assert result.modes is not None
    assert isinstance(result.scene.analysis, ComplexEigenvalueAnalysis)
    unstable = np.flatnonzero(result.modes.unstable(result.scene.analysis.growth_threshold))
    if not len(unstable):
        return list(range(min(count, len(result.modes.eigenvalues))))
    order = np.argsort(-result.modes.growth_rates[unstable], kind="stable")
    return unstable[order][:count].tolist()


def largest_deflection(shape: Complexes) -> tuple[Floats, float]:
    """Real displacement at the phase in which some point deflects most, and that deflection.

    abs(Re(u e^(i phi)))^2 = (abs(u)^2 + Re(u.u e^(2 i phi))) / 2 is largest at a point where
    phi = -arg(u.u) / 2. Of the two signs, the one that makes the largest component positive.

    Parameters
    ----------
    shape
        Complex displacements, shape (n, dim).
    """
    square = np.einsum("ij,ij->i", shape, shape)
    deflection = np.sqrt((np.einsum("ij,ij->i", shape.conj(), shape).real + np.abs(square)) / 2)
    at = int(np.argmax(deflection))
    real = (shape * np.exp(-0.5j * np.angle(square[at]))).real
    return real * np.sign(real[at][np.argmax(np.abs(real[at]))]), float(deflection[at])


def _draw(
    samples: dict[str, VolumeSample], shapes: dict[str, Complexes], title: str, file: Path
) -> None:
    real, largest = largest_deflection(np.concatenate(list(shapes.values())))
    ends = np.cumsum([len(shape) for shape in shapes.values()])[:-1]
    parts = dict(zip(shapes, np.split(real / largest, ends), strict=True))
    points = np.concatenate([_three(sample.points) for sample in samples.values()])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    drawn = np.concatenate([points, points + _DEFLECTION * size * _three(real / largest)])

    # Off screen, VTK looks for a display, fails, and says so before it goes on without one.
    with pyvista.vtk_verbosity("off"):
        plotter = pyvista.Plotter(off_screen=True, window_size=list(_WINDOW))
        plotter.set_background("white")
        for name, sample in samples.items():
            _add_body(plotter, sample, parts[name], size)
        text = plotter.add_title(title, font_size=15, color="#222222")
        text.SetPosition(0.5, 0.93)
        _aim(plotter.camera, _view(samples, points), drawn)
        plotter.enable_anti_aliasing("ssaa")
        plotter.screenshot(str(file))
        plotter.close()


def _add_body(plotter: Any, sample: VolumeSample, displacement: Floats, size: float) -> None:
    """Add a body deformed and coloured, with its edges, and the faint edges it has at rest."""
    kind = _CELL_TYPES[sample.points.shape[1], sample.cells.shape[1]]
    grid = pyvista.UnstructuredGrid({kind: sample.cells}, _three(sample.points))
    grid.point_data["displacement"] = _three(displacement)
    # Cells sampled one by one do not share points; without sharing every cell has an outside.
    skin = grid.clean(tolerance=_MERGED * size).extract_surface(algorithm="dataset_surface")
    edges = skin.extract_feature_edges(_FEATURE_ANGLE, manifold_edges=False)
    if edges.n_points:
        plotter.add_mesh(edges.copy(), color="#9A9A9A", line_width=3, opacity=0.6)
    for mesh in (skin, edges):
        mesh.points = mesh.points + _DEFLECTION * size * mesh.point_data["displacement"]
    skin.point_data["deflection"] = np.linalg.norm(skin.point_data["displacement"], axis=1)
    if edges.n_points:
        plotter.add_mesh(edges, color="#303840", line_width=3)
    plotter.add_mesh(
        skin,
        scalars="deflection",
        cmap="YlGnBu",
        clim=(0.0, 1.0),
        smooth_shading=True,
        split_sharp_edges=True,
        feature_angle=_FEATURE_ANGLE,
        ambient=0.25,
        scalar_bar_args={
            "title": "displacement / largest\n",
            "color": "#222222",
            "vertical": False,
            "width": 0.3,
            "height": 0.085,
            "position_x": 0.35,
            "position_y": 0.02,
            "title_font_size": 21,
            "label_font_size": 19,
            "n_labels": 3,
            "fmt": "%.1f",
        },
    )


def _view(samples: dict[str, VolumeSample], points: Floats) -> Floats:
    """Unit vector towards the camera: above the side of the scene where its smallest body sits."""
    smallest = min(samples.values(), key=lambda s: float(np.prod(np.ptp(s.points, axis=0))))
    if smallest.points.shape[1] == 2:
        return np.array([0.0, 0.0, 1.0])
    offset = smallest.points.mean(axis=0) - (points.min(axis=0) + points.max(axis=0)) / 2
    beside = np.hypot(offset[0], offset[1]) > 0.05 * np.linalg.norm(np.ptp(points, axis=0))
    azimuth = np.arctan2(offset[1], offset[0]) - np.pi / 6 if beside else -np.pi / 3
    elevation = np.copysign(np.radians(38.0), offset[2])
    flat = np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])


def _aim(camera: Any, view: Floats, points: Floats) -> None:
    """Fill the middle of the window with some points, seen along a direction from far away."""
    upright = np.array([0.0, 1.0, 0.0]) if view[2] == 1 else np.array([0.0, 0.0, 1.0])
    right = np.cross(upright, view)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(view, right), view])
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, depth = high - low
    # Room above for the title and below for the bar of colours.
    scale = 0.5 * max(height / 0.72, width * _WINDOW[1] / _WINDOW[0] / 0.9)
    focus = axes.T @ ((low + high) / 2 - [0.0, 0.06 * scale, 0.0])
    camera.enable_parallel_projection()
    camera.focal_point = focus
    camera.position = focus + 2 * depth * view
    camera.up = axes[1]
    camera.parallel_scale = scale
    camera.clipping_range = (0.5 * depth, 4 * depth)


def _three(vectors: Floats) -> Floats:
    """Vectors with z = 0 added in 2D, shape (n, 3)."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
