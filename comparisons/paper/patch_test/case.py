"""One run of the contact patch test: a discretisation, a formulation and a contact stiffness.

Section 3 of the paper: E = 1e5 N/m^2, nu = 0, a pressure of 1000 N/m^2 on top, so that the normal
stress on the interface is -1000 N/m^2 exactly. A discretisation is told by the oscillation of the
normal stress: its largest minus its smallest value over the interface.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import floor, log10
from pathlib import Path

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.formulations import Formulation, Greville, Grid, NodeToSurface
from cea.system.contact_stresses import pressure_along, stress_map
from comparisons.kit.numbers import number
from comparisons.paper.common.families import FAMILIES, Family
from comparisons.paper.common.figure import Data, as_lists
from scenes import run_static
from scenes.spec.body import Backend
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene, load_scene
from scenes.spec.scene import on_backend, with_contact

EXACT = -1000.0
"""Normal stress on the interface (N/m^2)."""
INTERFACE = "interface"
"""Name of the contact in the scene."""

_MAP_SAMPLES = 61
_MAP_DIGITS = 3
"""Digits kept of what a map shows, the oscillation of the normal stress."""
_FE_GRID = 4
_HIGHEST_LAGRANGE = 4
_WIDTH = 9.0
"""Width of the interface (m), along which tetrahedra have as many edges as others elements."""


@dataclass(frozen=True)
class PatchTestCase:
    """One run of the contact patch test.

    Parameters
    ----------
    formulation
        Points and weights on side a.
    P
        Global contact stiffness (N/m).
    degree, continuity
        Of both bodies in every direction.
    elements
        Elements along each side of the interface, of a and of b.
    mesh
        Kind of mesh.
    quoted
        Oscillation in the paper (N/m^2), in words where it has only those; None where it says
        nothing.
    remark
        What a reader must know to compare it, in a few words.
    """

    formulation: Formulation
    P: float
    degree: int = 2
    continuity: int = 1
    elements: tuple[int, int] = (3, 5)
    mesh: Family = "NURBS"
    quoted: float | str | None = field(default=None, compare=False)
    remark: str = field(default="", compare=False)

    def on(self, backend: Backend) -> tuple["PatchTestCase", ...]:
        """The case on every kind of mesh that a backend has."""
        return tuple(self.on_mesh(mesh) for mesh in FAMILIES[backend])

    def on_mesh(self, mesh: Family) -> "PatchTestCase":
        """The case on a kind of mesh.

        Lagrange elements are continuous and no more, have nodes for Greville abscissae, and a grid
        on every facet: 10 x 10 points over 3 x 3 facets for the paper's 9 x 9.
        """
        if mesh == "NURBS":
            return self
        formulation = self.formulation
        if isinstance(formulation, Greville):
            formulation = NodeToSurface()
        elif isinstance(formulation, Grid):
            formulation = Grid(_FE_GRID)
        return replace(self, continuity=0, formulation=formulation, mesh=mesh)

    @property
    def space(self) -> str:
        """Degree and continuity in the paper's notation."""
        return f"D{self.degree}C{self.continuity}"

    @property
    def rule(self) -> str:
        """Name of the formulation."""
        return self.formulation.label

    @property
    def label(self) -> str:
        """What tells it from other cases."""
        unstructured = "tetrahedra, " if self.mesh == "tetrahedra" else ""
        return f"{unstructured}{self.space}, {self.rule}, P = {number(self.P, 1)}"

    def scene(self, backend: Backend) -> Scene:
        """The scene of the case."""
        scene = on_backend(load_scene(Path("patch_test")), backend)
        bodies = {
            name: replace(scene.bodies[name], mesh=self._mesh_spec(n))
            for name, n in zip(("upper", "lower"), self.elements, strict=True)
        }
        scene = replace(scene, bodies=bodies)
        return with_contact(scene, formulation=self.formulation, P=self.P, form="penalty")

    def _mesh_spec(self, n: int) -> MeshSpec:
        """Both meshes of a body; the one that its backend does not use says nothing."""
        elements = (n, n, 1)
        degree = min(self.degree, _HIGHEST_LAGRANGE)
        return MeshSpec(
            fe=FeMesh("tetrahedron", degree, size=_WIDTH / n)
            if self.mesh == "tetrahedra"
            else FeMesh("hexahedron", degree, elements=elements),
            iga=IgaMesh((self.degree,) * 3, elements, (self.continuity,) * 3),
        )


def run_case(
    case: PatchTestCase, backend: Backend, bodies: Mapping[str, Body] | None = None
) -> tuple[Data, Mapping[str, Body]]:
    """Run a case.

    Parameters
    ----------
    case
        The case.
    backend
        Backend of both bodies.
    bodies
        Bodies of an earlier case of the same discretisation.

    Returns
    -------
    dict
        Plain data: oscillations, the stresses and p g along the diagonal of side a, and a map of
        each side.
    dict
        The bodies, for other cases.
    """
    scene = case.scene(backend)
    result = run_static(scene, bodies=bodies)
    sides = result.stresses[INTERFACE]
    x, system = result.displacement, result.system
    area = result.interfaces[INTERFACE].a.area
    plane = stress_map(system, INTERFACE, x, _MAP_SAMPLES)
    along = pressure_along(system, INTERFACE, x, case.P / area, result.analysis.samples)
    data = {
        "mesh": case.mesh,
        "space": case.space,
        "rule": case.rule,
        "P": case.P,
        "points": len(result.interfaces[INTERFACE].points),
        "dofs": system.size,
        "oscillation": {side: stress.oscillation for side, stress in sides.items()},
        "oscillation_of_p_gap": float(np.ptp(along[np.isfinite(along)])),
        "seconds": result.timer.total,
        "line": {"arc": as_lists(sides["a"].arc), "p_gap": as_lists(along)}
        | {side: as_lists(stress.sigma_n_along) for side, stress in sides.items()},
        "map": {"x": as_lists(plane.u), "y": as_lists(plane.v)}
        | {side: as_lists(shown(stress)) for side, stress in plane.sigma_n.items()},
    }
    return data, system.bodies


def shown(stress: Floats) -> Floats:
    """A map rounded to the digits kept of its range, so that it is small when compressed."""
    extent = float(np.ptp(stress[np.isfinite(stress)]))
    return np.round(stress, _MAP_DIGITS - floor(log10(extent))) if extent else stress


def worse(case: Data) -> float:
    """Oscillation on the worse side (N/m^2)."""
    return max(case["oscillation"].values())
