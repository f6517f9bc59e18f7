"""The paper's disc and pad (sections 3 and 4), mu = 0.7; disc knots follow the pad boundary."""

from dataclasses import dataclass, replace
from typing import Any, Literal

from cea.contact.formulations import Form, Formulation, GaussPointToSurface, Greville, Grid
from comparisons.paper.figure import BACKENDS, MOST_LAGRANGE, Mesh, as_lagrange
from scenes.spec.body import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene, load_scene

DISC, PAD = "disc", "pad"
"""Names of the bodies."""
LOW, MIDDLE, HIGH = 1e9, 1e12, 1e14
"""Contact stiffnesses (N/m) at which the formulations of the paper are different, identical and
nearly identical."""
MAX_FREQUENCY = 15.5e3
"""Highest frequency (Hz). The paper shows 15 kHz, near which some formulations have modes; none has
a mode near this value."""

Boundary = Literal["traced", "ignored", "refined"]
"""Whether element boundaries of the disc follow the pad boundary, also with refinement there."""

_SPANS_KEPT_TO = 3  # degree up to which NURBS meshes are not coarsened; degree 5 would take 9 GB
_SIZES = {DISC: 0.010, PAD: 0.0075}  # edges of tetrahedra (m), for about the dofs of the NURBS
_REFINED = {"r": 0.003, "theta": 1.5}
"""Distances of added element boundaries on both sides of the pad's boundary (m, degrees)."""


@dataclass(frozen=True)
class DiscPad:
    """One analysis of disc and pad.

    Elements are enlarged with the degree (NURBS: beyond degree 3), so that dofs stay the same.
    """

    formulation: Formulation  # points and weights on the pad
    P: float = LOW  # global contact stiffness (N/m)
    form: Form = "penalty"
    degree: int = 2  # of both bodies in every direction
    full_pass: bool = False
    boundary: Boundary = "traced"  # mesh of the disc at the boundary of the pad
    divided: bool = False  # hexahedra divided into six tetrahedra, which can follow it

    def on(self, mesh: Mesh) -> "DiscPad":
        """Return the case as it is on a kind of mesh."""
        if mesh == "NURBS":
            return replace(self, divided=False)
        divided = self.divided and mesh == "tetrahedra"
        boundary = self.boundary if divided or mesh == "hexahedra" else "ignored"
        formulation = as_lagrange(self.formulation)
        return replace(self, formulation=formulation, boundary=boundary, divided=divided)

    def exists_on(self, mesh: Mesh) -> bool:
        """Whether a kind of mesh has elements of this degree."""
        return mesh == "NURBS" or self.degree <= MOST_LAGRANGE

    @property
    def label(self) -> str:
        """Label that is unique among cases of one contact stiffness."""
        words = {
            "divided hexahedra": self.divided,
            f"degree {self.degree}": True,
            self.formulation.label: True,
            "full pass": self.full_pass,
            "saddle form": self.form == "saddle",
            f"pad boundary {self.boundary}": self.boundary != "traced",
        }
        return ", ".join(word for word, said in words.items() if said)

    def scene(self, mesh: Mesh) -> Scene:
        """Return the scene of the case on a kind of mesh."""
        case = self.on(mesh)
        scene = load_scene("disc_pad", backend=BACKENDS[mesh])
        changes: dict[str, Any] = {"analysis.max_frequency": MAX_FREQUENCY}
        for field in ("formulation", "P", "form", "full_pass"):
            changes[f"contacts.pad_disc.{field}"] = getattr(case, field)
        for name, body in scene.bodies.items():
            changes[f"bodies.{name}.mesh"] = case._mesh(body.mesh, name, mesh)
        return scene.change(changes)

    def _mesh(self, spec: Any, name: str, mesh: Mesh) -> MeshSpec:
        degree = self.degree
        if mesh == "tetrahedra" and not self.divided:
            return MeshSpec(fe=FeMesh("tetrahedron", degree, size=_SIZES[name] * degree / 2))
        through = {} if self.boundary == "ignored" else spec.iga.through
        added = (0, 0, 0)
        if through and self.boundary == "refined":
            through = {
                axis: tuple(e + side * _REFINED[axis] for e in edges for side in (-1, 0, 1))
                for axis, edges in through.items()
            }
            added = (4, 4, 0)
        nurbs = mesh == "NURBS"
        factor = min(1.0, _SPANS_KEPT_TO / degree) if nurbs else 2 / degree
        counts = zip((spec.iga if nurbs else spec.fe).elements, added, strict=True)
        elements: Any = tuple(max(1, round(factor * n)) + more for n, more in counts)
        if nurbs:
            return MeshSpec(iga=IgaMesh((degree,) * 3, elements, through=through))
        cell: Any = "tetrahedron" if self.divided else "hexahedron"
        return MeshSpec(fe=FeMesh(cell, degree, elements=elements, through=through))


GPTS = DiscPad(GaussPointToSurface(5))
LUMPED = DiscPad(GaussPointToSurface(5, lumped=True))
COLLOCATION = DiscPad(Greville())
GRID = DiscPad(Grid(10))
