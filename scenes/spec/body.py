"""What a scene says of a body."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from cea.material import (
    AnisotropicMaterial,
    IsotropicMaterial,
    OrthotropicMaterial,
    TransverselyIsotropicMaterial,
)
from cea.rotation import Rotation
from cea.supports.boundary import Spring
from meshes.mesh_file import MeshFile
from meshes.placement import Placement
from meshes.shapes import Shape
from scenes.spec.mesh import MeshSpec
from scenes.spec.motion import DampingSpec
from scenes.spec.support import SupportSpec

Backend = Literal["fe", "iga"]

Material = Annotated[
    Annotated[IsotropicMaterial, Tag("isotropic")]
    | Annotated[OrthotropicMaterial, Tag("orthotropic")]
    | Annotated[TransverselyIsotropicMaterial, Tag("transversely_isotropic")]
    | Annotated[AnisotropicMaterial, Tag("anisotropic")],
    Discriminator(
        lambda given: (
            given.get("kind", "isotropic")
            if isinstance(given, dict)
            else getattr(given, "kind", None)
        )
    ),
]


@dataclass(frozen=True)
class BodySpec:
    """A body: backend, geometry, meshes, material, supports, damping, rotation.

    Parameters
    ----------
    backend
        ``fe``, Lagrange elements, or ``iga``, NURBS.
    geometry
        Its shape, in coordinates of its own.
    material
        Linear elasticity, isotropic if no ``kind`` is given.
    mesh
        How it is divided, for each backend that it is to be run on.
    supports
        Displacements that are held.
    springs
        Elastic foundations of surfaces.
    placement
        Where the shape stands in space.
    damping
        Rayleigh and modal damping.
    rotation
        Steady rotation about its own axis, seen from the frame at rest.
    """

    backend: Backend
    geometry: Annotated[Shape, Field(discriminator="shape")]
    material: Material
    mesh: MeshSpec = field(default_factory=MeshSpec)
    supports: tuple[SupportSpec, ...] = ()
    springs: tuple[Spring, ...] = ()
    placement: Placement = field(default_factory=Placement)
    damping: DampingSpec | None = None
    rotation: Rotation | None = None

    @property
    def circulates(self) -> bool:
        """Whether damping is carried along by a rotation."""
        return self.rotation is not None and self.damping is not None

    @property
    def rotates_in_equilibrium(self) -> bool:
        """Whether forces of a rotation act on displacements that are at rest in space."""
        convective = self.rotation is not None and self.rotation.convective_stiffness
        return convective or self.circulates

    @property
    def fe_degree(self) -> int | None:
        """Degree of its Lagrange elements; None where it has none."""
        if isinstance(self.geometry, MeshFile):
            least = 2 if self.geometry.is_divided else 1  # straight tetrahedra are too stiff
            return self.mesh.degree or max(self.geometry.order, least)
        return self.mesh.fe.degree if self.mesh.fe is not None else None
