"""One complex eigenvalue analysis of disc and pad: a mesh, a formulation and a contact stiffness.

Sections 3 and 4 of the paper: mu = 0.7, the knots of the disc trace the boundary of the pad.
"""

from dataclasses import dataclass, replace
from typing import Literal

from cea.contact.coupling import Form
from cea.contact.formulations import Formulation, Greville, Grid, NodeToSurface
from cea.mesh import Cell
from comparisons.kit.numbers import number
from comparisons.paper.common.families import BACKEND_OF, Family
from comparisons.paper.common.figure import Data
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.plain import as_data
from scenes.spec.reading import Scene, load_scene
from scenes.spec.scene import on_backend

CONTACT = "pad_disc"
"""Name of the contact in the scene."""
DISC, PAD = "disc", "pad"
"""Names of the bodies."""

Boundary = Literal["traced", "ignored", "refined"]
"""Whether element boundaries of the disc follow the boundary of the pad, and are finer there."""

_DIVIDED = "Each hexahedron is divided into six tetrahedra."
"""What tells cases on divided hexahedra in the inputs of figures."""
_HIGHEST_LAGRANGE = 4
_SPANS_KEPT_TO = 3
"""Degree up to which NURBS keep their spans; at degree 5 those would take 9 GB and more."""
_FE_GRID = 4
_REFINED = {"r": 0.003, "theta": 1.5}
"""Distances of more element boundaries on both sides of the pad's boundary (m, degrees)."""


@dataclass(frozen=True)
class Resolution:
    """How finely disc and pad are meshed, and how far up modes are sought.

    Parameters
    ----------
    max_frequency
        Upper end of the modes (Hz): the paper shows 15 kHz, where modes of some formulations lie on
        either side; none is near the default.
    disc_size, pad_size
        Edge lengths of quadratic tetrahedra (m); by default they have about as many dofs as the
        NURBS.
    overrides
        Fields of the scene to be set, as "path.to.field=value".
    """

    max_frequency: float = 15.5e3
    disc_size: float = 0.010
    pad_size: float = 0.0075
    overrides: tuple[str, ...] = ()

    def size(self, body: str) -> float:
        """Edge length of quadratic tetrahedra of a body (m)."""
        return {DISC: self.disc_size, PAD: self.pad_size}[body]


PAPER = Resolution()
"""That of the figures."""


@dataclass(frozen=True)
class CeaCase:
    """One analysis of disc and pad.

    Parameters
    ----------
    formulation
        Points and weights on the pad.
    P
        Global contact stiffness (N/m).
    form
        Contact forces eliminated or unknowns.
    degree
        Of both bodies in every direction. NURBS keep their spans up to degree 3, then spans grow
        with the degree; Lagrange elements always do, so that dofs stay about the same.
    full_pass
        Whether points lie on the disc too.
    boundary
        How the mesh of the disc regards the boundary of the pad; unstructured tetrahedra cannot
        trace it.
    divided
        Whether tetrahedra are hexahedra each divided into six, which can.
    resolution
        Size of the elements and highest frequency.
    """

    formulation: Formulation
    P: float
    form: Form = "penalty"
    degree: int = 2
    full_pass: bool = False
    boundary: Boundary = "traced"
    divided: bool = False
    resolution: Resolution = PAPER

    def on(self, family: Family) -> "CeaCase":
        """The case as a kind of mesh has it: nodes for Greville points, a grid on every facet."""
        if family == "NURBS":
            return replace(self, divided=False)
        formulation = self.formulation
        if isinstance(formulation, Greville):
            formulation = NodeToSurface()
        elif isinstance(formulation, Grid):
            formulation = Grid(_FE_GRID)
        divided = self.divided and family == "tetrahedra"
        traces = divided or family == "hexahedra"
        boundary = self.boundary if traces else "ignored"
        return replace(self, formulation=formulation, boundary=boundary, divided=divided)

    def exists_on(self, family: Family) -> bool:
        """Whether a kind of mesh has elements of the degree."""
        return family == "NURBS" or self.degree <= _HIGHEST_LAGRANGE

    @property
    def rule(self) -> str:
        """Name of the formulation, with its form and passes."""
        name = self.formulation.label + (", full pass" if self.full_pass else "")
        return name + (", saddle form" if self.form == "saddle" else "")

    @property
    def label(self) -> str:
        """What tells it from other cases."""
        boundary = "" if self.boundary == "traced" else f", pad boundary {self.boundary}"
        mesh = "divided hexahedra, " if self.divided else ""
        return f"{mesh}degree {self.degree}, {self.rule}{boundary}, P = {number(self.P, 1)}"

    def scene(self, family: Family) -> Scene:
        """The scene of the case on a kind of mesh."""
        case = self.on(family)
        scene = on_backend(load_scene("disc_pad", case.resolution.overrides), BACKEND_OF[family])
        assert isinstance(scene.analysis, ComplexEigenvalueAnalysis)
        bodies = {
            name: replace(spec, mesh=_mesh(scene, name, family, case))
            for name, spec in scene.bodies.items()
        }
        contact = replace(
            scene.contacts[CONTACT],
            formulation=case.formulation,
            P=case.P,
            form=case.form,
            full_pass=case.full_pass,
        )
        analysis = replace(scene.analysis, max_frequency=case.resolution.max_frequency)
        return replace(
            scene,
            bodies=bodies,
            contacts={CONTACT: contact},
            analysis=analysis,
        )

    def inputs(self, family: Family) -> Data:
        """The case on a kind of mesh as plain data, by which stored figures are found.

        Divided hexahedra stand there as hexahedra, with a word in the description.
        """
        described: Data = as_data(self.scene(family))
        if self.on(family).divided:
            for body in described["bodies"].values():
                body["mesh"]["fe"]["cell"] = "hexahedron"
            described["description"] += f" {_DIVIDED}"
        return described


def _mesh(scene: Scene, name: str, family: Family, case: CeaCase) -> MeshSpec:
    spec = scene.bodies[name].mesh
    assert spec.iga is not None
    assert spec.fe is not None
    assert spec.fe.elements is not None
    if family == "tetrahedra" and not case.divided:
        size = case.resolution.size(name) * case.degree / 2
        return MeshSpec(fe=FeMesh("tetrahedron", case.degree, size=size))
    through = {} if case.boundary == "ignored" else spec.iga.through
    added = 0
    if through and case.boundary == "refined":
        through = {
            axis: tuple(e + side * _REFINED[axis] for e in edges for side in (-1, 0, 1))
            for axis, edges in through.items()
        }
        added = 4
    extra = (added, added, 0)
    if family == "NURBS":
        kept = min(1.0, _SPANS_KEPT_TO / case.degree)
        spans = tuple(
            max(1, round(kept * n)) + more for n, more in zip(spec.iga.elements, extra, strict=True)
        )
        return MeshSpec(iga=IgaMesh((case.degree,) * 3, spans, through=through))
    elements = tuple(
        max(1, round(2 * n / case.degree)) + more
        for n, more in zip(spec.fe.elements, extra, strict=True)
    )
    cell: Cell = "tetrahedron" if case.divided else "hexahedron"
    return MeshSpec(fe=FeMesh(cell, case.degree, elements=elements, through=through))
