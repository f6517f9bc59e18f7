"""Figures 2 and 11: the two contact patch tests, drawn from the meshes themselves."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as Picture
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

from cea.arrays import Floats
from cea.contact.formulations import Greville, Grid
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.timing import StageTimer
from comparisons.paper.figure import Figure, Mesh, Tables, as_lagrange, quoted
from comparisons.paper.patch_test import INTERFACE, SIDES, PatchTest
from comparisons.study.result import StudyResult
from comparisons.study.session import Session
from scenes.building.build import build_bodies, build_interfaces
from scenes.spec.reading import Scene, with_contact

_SEEN = {"lower": ("x_max", "y_min"), "upper": ("x_max", "y_min", "z_max")}
"""Faces turned towards the viewer, by body."""
_OF_SIDE = {"a": "upper.z_min", "b": "lower.z_max"}
_LOOKS = {"upper": ("#F6E3D6", r"$\Omega^{(a)}$"), "lower": ("#DCE8F2", r"$\Omega^{(b)}$")}
_POINTS = {"Greville points of a": Greville(), "grid points of a": Grid(9)}
_PAPER = {"height of a": 4.5, "E": 1e5, "nu": 0.0, "pressure": 1000.0}
"""Numbers of section 3 that hold for both settings."""


@dataclass(frozen=True)
class Setting(Figure):
    """The setting of a contact patch test.

    Parameters
    ----------
    case
        A case of the patch test with its meshes.
    paper
        Numbers of the paper beside those that both settings have.
    """

    case: PatchTest
    paper: Mapping[str, float] = field(default_factory=dict)

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """The scene."""
        return {"scene": self.case.on(mesh).scene(mesh)}

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Mesh both bodies; corners of the cells of every face, and the points of side a."""
        scene: Scene = session.scene["scene"]
        bodies = build_bodies(scene, StageTimer())
        faces = {
            f"{n}.{s}": cells(side) for n, b in bodies.items() for s, side in b.surfaces.items()
        }
        for name, corners in faces.items():
            session.keep(name, corners)
        length, width = np.ptp(faces["upper.z_min"].reshape(-1, 3), axis=0)[:2]
        material = scene.bodies["upper"].material
        paper = {**_PAPER, **self.paper}
        numbers = [
            quoted(what, paper.get(what), value, unit)
            for what, value, unit in (
                ("length of the interface", length, "m"),
                ("width of the interface", width, "m"),
                ("height of a", np.ptp(faces["upper.x_max"][..., 2]), "m"),
                ("height of b", np.ptp(faces["lower.x_max"][..., 2]), "m"),
                ("E", material.E, "N/m²"),
                ("nu", material.nu, ""),
                ("pressure", scene.loads[0].pressure, "N/m²"),
                *((f"elements of {side}", len(faces[face]), "") for side, face in _OF_SIDE.items()),
            )
        ]
        for what, rule in _POINTS.items():
            own = rule if mesh == "NURBS" else as_lagrange(rule)
            interfaces = build_interfaces(
                with_contact(scene, formulation=own), bodies, StageTimer()
            )
            remark = "" if own is rule else own.label
            points = len(interfaces[INTERFACE].points)
            numbers.append(quoted(what, paper.get(what), points, "", remark))
        return {"numbers": numbers}


def cells(surface: Surface) -> Floats:
    """Corners (m) of the cells of a surface in an order of space, (cells, corners, 3)."""
    found = surface.cells()
    n, corners, parameters = found.corners.shape
    at = SurfaceCoordinates(
        np.repeat(found.element, corners), found.corners.reshape(-1, parameters)
    )
    x = surface.position(at).reshape(n, corners, -1)
    return x[np.lexsort(np.round(x.mean(axis=1), 9).T[::-1])]


def drawn(setting: Setting, mesh: Mesh, result: StudyResult) -> Picture:
    """The blocks in space, and both meshes of the interface one upon the other."""
    labels = {"figure": setting.name, "mesh": mesh}
    figure = Picture(figsize=(9.5, 4.8), layout="constrained")
    figure.suptitle(f"{setting.title}, {mesh}", fontsize=10)
    _draw_blocks(figure, lambda name: result.array(labels, name))
    _draw_interface(figure.add_subplot(1, 2, 2), lambda name: result.array(labels, name))
    return figure


def _draw_blocks(figure: Picture, faces: Any) -> None:
    axes: Any = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    for body, (colour, label) in reversed(_LOOKS.items()):
        for surface in _SEEN[body]:
            polygons = faces(f"{body}.{surface}")
            look = {"facecolors": colour, "edgecolors": "#303840", "linewidths": 0.8}
            axes.add_collection3d(Poly3DCollection(polygons, **look))
        middle = faces(f"{body}.x_max")[..., 2].mean()
        axes.text(4.5, -0.2, middle, label, ha="center", fontsize=12)
    (length, width, top), arrow = faces("upper.z_max").reshape(-1, 3).max(axis=0), 1.8
    tips = np.linspace(0.15, 0.85, 3)
    x, y = (part.ravel() for part in np.meshgrid(tips * length, tips * width))
    axes.quiver(x, y, top + arrow, 0, 0, -arrow, color="#8A3B12", linewidth=1.0)
    axes.text(1.06 * length, 0, top / 2, r"$\Gamma_C$", fontsize=12)
    axes.set(xlim=(0, length), ylim=(0, width), zlim=(0, top + arrow))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    axes.set_box_aspect((length, width, top + arrow))
    axes.view_init(elev=22.0, azim=-55.0)


def _draw_interface(axes: Axes, faces: Any) -> None:
    handles = []
    for side, colour, style in SIDES:
        corners = faces(_OF_SIDE[side])[..., :2]
        lines = LineCollection(
            list(edges(corners)), colors=colour, linestyles=style, linewidths=1.4
        )
        axes.add_collection(lines)
        label = rf"mesh of $\Gamma_C^{{({side})}}$, {len(corners)} cells"
        handles.append(Line2D([], [], color=colour, linestyle=style, label=label))
    axes.autoscale()
    axes.set_aspect("equal")
    axes.set(xlabel="x (m)", ylabel="y (m)", title="the interface from above")
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)


def edges(corners: Floats) -> Floats:
    """Edges of cells (n, corners, 2), each once, shape (edges, 2, 2): dashes drawn twice close."""
    pairs = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    order = np.lexsort((np.round(pairs[..., 1], 9), np.round(pairs[..., 0], 9)))
    pairs = np.take_along_axis(pairs, order[..., None], axis=1)
    return pairs[np.unique(np.round(pairs, 9).reshape(-1, 4), axis=0, return_index=True)[1]]


_ON: tuple[Mesh, ...] = ("NURBS", "hexahedra")
SETTINGS = (
    Setting(
        *("2", "Figure 2: contact patch test", PatchTest(Greville())),
        {"Greville points of a": 25.0, "grid points of a": 81.0},
        meshes=_ON,
    ),
    Setting(
        *("11", "Figure 11: second contact patch test", PatchTest(Greville(), elements=(5, 3))),
        meshes=_ON,
    ),
)
"""Settings of the two patch tests. Elements are not in the text: 25 Greville points are those of
3 x 3 quadratic spans; the second mesh is in a picture only, this one is a guess."""
