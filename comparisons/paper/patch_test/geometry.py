"""Figures 2 and 11: the two contact patch tests, drawn from the meshes themselves."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

from cea.arrays import Floats
from cea.contact.formulations import Greville, Grid
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.timing import StageTimer
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.figure import Data, Number
from comparisons.paper.common.style import SIDES, drawing
from comparisons.paper.patch_test.case import INTERFACE, PatchTestCase
from scenes.building.build import build_bodies, build_interfaces
from scenes.spec.body import Backend
from scenes.spec.plain import as_data
from scenes.spec.reading import Scene
from scenes.spec.scene import with_contact

_SEEN = {"upper": ("x_max", "y_min", "z_max"), "lower": ("x_max", "y_min")}
"""Faces turned towards the viewer, by body."""
_FACES = {"upper": "#F6E3D6", "lower": "#DCE8F2"}
_LABELS = {"upper": r"$\Omega^{(a)}$", "lower": r"$\Omega^{(b)}$"}
_FE_REMARKS = {
    "Greville points of a": "nodes in place of Greville points",
    "grid points of a": "a grid on each facet",
}
_VIEW = {"elev": 22.0, "azim": -55.0}


@dataclass(frozen=True)
class SettingFigure:
    """The setting of a contact patch test.

    Parameters
    ----------
    name, title
        Number of the figure, and what it shows.
    remark
        What in it is not the paper's.
    case
        A case of the patch test with its meshes.
    quoted
        Numbers of the paper by what they are, as :meth:`numbers` names them.
    """

    name: str
    title: str
    remark: str
    case: PatchTestCase
    quoted: Mapping[str, float]

    def inputs(self, backend: Backend) -> Data:
        """The scene."""
        return {"scene": as_data(self.case.on(backend)[0].scene(backend))}

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Mesh both bodies; corners of the cells of every face, and the points of side a."""
        progress.step(f"figure {self.name}, {backend}")
        scene = self.case.on(backend)[0].scene(backend)
        bodies = build_bodies(scene, StageTimer(progress.stage))
        faces = {
            name: {surface: _cells(body.surfaces[surface]) for surface in sorted(body.surfaces)}
            for name, body in bodies.items()
        }
        points = {}
        for formulation in (Greville(), Grid(9)):
            case = replace(self.case, formulation=formulation).on(backend)[0]
            counted = with_contact(scene, formulation=case.formulation)
            interface = build_interfaces(counted, bodies, StageTimer(progress.stage))[INTERFACE]
            points[formulation.method] = len(interface.points)
        return {
            "faces": faces,
            "points": points,
            "elements": {side: s.cells().element.size for side, s in _sides(scene, bodies)},
            "size": np.ptp(np.array(faces["upper"]["z_min"]).reshape(-1, 3), axis=0).tolist(),
            "height": {
                name: float(np.ptp(np.array(corners["x_max"])[..., 2]))
                for name, corners in faces.items()
            },
            "area": bodies["upper"].surfaces["z_min"].area,
            "E": scene.bodies["upper"].material.E,
            "nu": scene.bodies["upper"].material.nu,
            "pressure": scene.loads[0].pressure,
        }

    def numbers(self, data: Data) -> list[Number]:
        """Sizes, material, load and points of the setting."""
        ours: dict[str, tuple[float, str]] = {
            "length of the interface": (data["size"][0], "m"),
            "width of the interface": (data["size"][1], "m"),
            "height of a": (data["height"]["upper"], "m"),
            "height of b": (data["height"]["lower"], "m"),
            "E": (data["E"], "N/m²"),
            "nu": (data["nu"], ""),
            "pressure": (data["pressure"], "N/m²"),
            "elements of a": (data["elements"]["a"], ""),
            "elements of b": (data["elements"]["b"], ""),
            "Greville points of a": (data["points"]["greville"], ""),
            "grid points of a": (data["points"]["grid"], ""),
        }
        remarks = _FE_REMARKS if data["backend"] == "fe" else {}
        return [
            Number(what, self.quoted.get(what), value, unit, remarks.get(what, ""))
            for what, (value, unit) in ours.items()
        ]

    def note(self, data: Data) -> str:
        """What in it is not the paper's."""
        return self.remark

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw the blocks in space, and both meshes of the interface one upon the other."""
        file = stem.with_suffix(".png")
        with drawing(file, (9.5, 4.8)) as figure:
            figure.suptitle(data["title"], fontsize=10)
            _draw_blocks(figure, data)
            _draw_interface(figure.add_subplot(1, 2, 2), data)
        return [file]

    def tables(self, data: Data, stem: str) -> list[Table]:
        """Mesh lines: corners of the cells of every face."""
        names = ("body", "surface", "cell", "x", "y", "z")
        rows = [
            (body, surface, cell, *corner)
            for body, faces in data["faces"].items()
            for surface, cells in faces.items()
            for cell, corners in enumerate(cells)
            for corner in corners
        ]
        return [Table(f"{stem}_mesh", self.title, tuple(Column(n, n) for n in names), rows)]


def _sides(scene: Scene, bodies: Mapping[str, Any]) -> list[tuple[str, Surface]]:
    contact = scene.contacts[INTERFACE]
    return [
        (side, bodies[body].surfaces[surface])
        for side, (body, surface) in (("a", contact.a.split(".")), ("b", contact.b.split(".")))
    ]


def _cells(surface: Surface) -> list[Any]:
    """Corners (m) of the cells of a surface, (cells, corners, 3) as nested lists, in an order."""
    cells = surface.cells()
    n, corners, parameters = cells.corners.shape
    at = SurfaceCoordinates(
        np.repeat(cells.element, corners), cells.corners.reshape(-1, parameters)
    )
    x = surface.position(at).reshape(n, corners, -1)
    order = np.lexsort(np.round(x.mean(axis=1), 9).T[::-1])
    return x[order].tolist()


def _draw_blocks(figure: Figure, data: Data) -> None:
    axes: Any = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    for body in ("lower", "upper"):
        for surface in _SEEN[body]:
            polygons = np.array(data["faces"][body][surface])
            axes.add_collection3d(
                Poly3DCollection(
                    polygons, facecolors=_FACES[body], edgecolors="#303840", linewidths=0.8
                )
            )
    length, width, height = data["size"][0], data["size"][1], data["height"]
    total = height["upper"] + height["lower"]
    for middle, body in ((height["lower"] / 2, "lower"), (total - height["upper"] / 2, "upper")):
        axes.text(length / 2, -0.02 * width, middle, _LABELS[body], ha="center", fontsize=12)
    tips = np.linspace(0.15, 0.85, 3)
    x, y = (part.ravel() for part in np.meshgrid(tips * length, tips * width))
    arrow = 0.2 * total
    axes.quiver(x, y, total + arrow, 0, 0, -arrow, color="#8A3B12", linewidth=1.0)
    axes.text(length / 2, width / 2, total + 1.3 * arrow, f"{data['pressure']:g} N/m²", ha="center")
    axes.text(1.06 * length, 0, height["lower"], r"$\Gamma_C$", fontsize=12)
    axes.set(xlim=(0, length), ylim=(0, width), zlim=(0, total + arrow))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    axes.set_box_aspect((length, width, total + arrow))
    axes.view_init(**_VIEW)


def _draw_interface(axes: Axes, data: Data) -> None:
    surfaces = {"a": ("upper", "z_min"), "b": ("lower", "z_max")}
    handles = []
    for side, colour, style in SIDES:
        body, surface = surfaces[side]
        cells = np.array(data["faces"][body][surface])[..., :2]
        axes.add_collection(
            LineCollection(list(_edges(cells)), colors=colour, linestyles=style, linewidths=1.4)
        )
        label = rf"mesh of $\Gamma_C^{{({side})}}$, {len(cells)} cells"
        handles.append(Line2D([], [], color=colour, linestyle=style, label=label))
    axes.autoscale()
    axes.set_aspect("equal")
    axes.set(xlabel="x (m)", ylabel="y (m)", title="the interface from above")
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)


def _edges(cells: Floats) -> Floats:
    """Edges of cells (n, corners, 2), each once, shape (edges, 2, 2): dashes drawn twice close."""
    edges = np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    flipped = edges[:, ::-1]
    falls = np.round(edges[:, 1] - edges[:, 0], 9)
    backwards = (falls[:, 0] < 0) | ((falls[:, 0] == 0) & (falls[:, 1] < 0))
    edges = np.where(backwards[:, None, None], flipped, edges)
    return edges[np.unique(np.round(edges, 9).reshape(-1, 4), axis=0, return_index=True)[1]]


_PAPER = {
    "height of a": 4.5,
    "E": 1e5,
    "nu": 0.0,
    "pressure": 1000.0,
}
"""Numbers of section 3 that hold for both settings."""

GEOMETRY_FIGURES = (
    SettingFigure(
        "2",
        "Figure 2: contact patch test",
        "Elements are not in the text: 25 Greville points are those of 3 × 3 quadratic spans.",
        PatchTestCase(Greville(), 1e6),
        _PAPER | {"Greville points of a": 25.0, "grid points of a": 81.0},
    ),
    SettingFigure(
        "11",
        "Figure 11: second contact patch test, the meshes of both sides exchanged",
        "The paper gives the second mesh in a picture only; this one is a guess.",
        PatchTestCase(Greville(), 1e6, elements=(5, 3)),
        _PAPER,
    ),
)
"""Settings of the two patch tests."""
