"""One analysis of the crowned pad: a kind of mesh, a formulation and a load."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cea.contact.formulations import (
    Botella,
    Formulation,
    GaussPointToSurface,
    Greville,
    Grid,
    Mortar,
    NodeToSurface,
    Segments,
)
from comparisons.paper.common.families import BACKEND_OF, Family
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene, load_scene
from scenes.spec.scene import on_backend

CONTACT, PAD, DISC = "pad_disc", "pad", "disc"
"""Names in the scene."""
FACE, COUNTER = "bottom", "top"
"""Sides of the contact: of the pad, where points lie, and of the disc."""
EXACT, COLLOCATION, QUADRATURE = "segments", "collocation", "GPTS 3 × 3"
"""Labels of the exact integration, and of what the paper sets against each other."""
WEIGHTED = "collocation, area weights"
"""Label of collocation whose points bear the area that is theirs, not equal parts of it."""
FINER = "segments, finer mesh"
"""Label of the exact integration on the finer mesh."""

PRESSURES = (1e5, 4e5, 2e6)
"""Pressures on the back of the pad (N/m^2)."""

_COMMON: Mapping[str, Formulation] = {
    EXACT: Segments(),
    "mortar": Mortar(),
    QUADRATURE: GaussPointToSurface(3),
}
_OWN: Mapping[str, Mapping[str, Formulation]] = {
    "iga": {
        COLLOCATION: Greville(),
        WEIGHTED: Greville("area"),
        "Botella": Botella(),
        "grid": Grid(10),
    },
    "fe": {COLLOCATION: NodeToSurface(), WEIGHTED: NodeToSurface("tributary"), "grid": Grid(4)},
}
_REFINED = (1.5, 1.5, 1.5)
"""Factors on the elements of the finer mesh."""


@dataclass(frozen=True)
class CrownedCase:
    """One analysis.

    Parameters
    ----------
    formulation
        Points and weights on the pad.
    pressure
        On the back of the pad (N/m^2).
    finer
        Whether on the finer mesh.
    """

    formulation: Formulation
    pressure: float
    finer: bool = False

    def scene(self, family: Family) -> Scene:
        """The scene on a kind of mesh; tetrahedra are hexahedra divided into six."""
        scene = on_backend(load_scene("crowned_pad"), BACKEND_OF[family])
        contact = replace(scene.contacts[CONTACT], formulation=self.formulation)
        (load,) = scene.loads
        return replace(
            scene,
            bodies={
                name: replace(
                    body, mesh=_mesh(body, family, _REFINED if self.finer else (1.0,) * 3)
                )
                for name, body in scene.bodies.items()
            },
            contacts={CONTACT: contact},
            loads=(replace(load, pressure=self.pressure),),
        )


def formulations(family: Family) -> dict[str, Formulation]:
    """Formulations by label that a kind of mesh has; the exact integration first."""
    return {**_COMMON, **_OWN[BACKEND_OF[family]]}


def _mesh(body: BodySpec, family: Family, factors: tuple[float, ...]) -> MeshSpec:
    def finer(elements: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(round(f * n) for f, n in zip(factors, elements, strict=True))

    if family == "NURBS":
        iga = body.mesh.iga
        assert isinstance(iga, IgaMesh)
        return MeshSpec(iga=replace(iga, elements=finer(iga.elements)))
    fe = body.mesh.fe
    assert isinstance(fe, FeMesh)
    assert fe.elements is not None
    cell = "tetrahedron" if family == "tetrahedra" else fe.cell
    return MeshSpec(fe=replace(fe, cell=cell, elements=finer(fe.elements)))
