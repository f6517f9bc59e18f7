"""Scenes refined: more elements along directions, higher degrees, layers at singular edges.

Pure: a scene in, a scene out. Meshes that did not match before refinement keep their proportions,
and every contact becomes mortar, the error of which is that of the meshes at any stiffness.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import ceil, exp, log
from typing import Any

from cea.contact.formulations import Mortar
from cea.errors import InputError
from cea.mesh import SIMPLICES
from meshes.breaks import breaks_of, fewest, layered
from meshes.edge_layers import RATIO, fit
from meshes.mesh_file import MeshFile
from scenes.read import Scene
from scenes.refinement_edges import Crowding, crowding
from scenes.spec.body import Backend, BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.variants import on_backend

MAX_DEGREE: dict[Backend, int] = {"fe": 4, "iga": 8}
"""Highest degree of each backend."""


@dataclass(frozen=True)
class BodyResolution:
    """How fine one body is made.

    Parameters
    ----------
    degree
        Degree of its elements.
    densities
        Factor on the elements of the scene along each direction; of unstructured meshes, which
        have one size, all are the same.
    layers
        Geometric layers towards its singular edges.
    """

    degree: int
    densities: tuple[float, ...]
    layers: int = 0


@dataclass(frozen=True)
class Resolution:
    """How fine a scene is made.

    Parameters
    ----------
    degree
        Degree of the elements of all bodies along every direction.
    density
        Factor on the elements of the scene along every direction.
    layers
        Geometric layers towards singular edges.
    bodies
        Bodies with a resolution of their own, by name; the three numbers above then sum them up.
    """

    degree: int
    density: float
    layers: int = 0
    bodies: tuple[tuple[str, BodyResolution], ...] = ()

    def __post_init__(self) -> None:
        for density in (self.density, *(d for _, each in self.bodies for d in each.densities)):
            if not density > 0:
                raise InputError("density", density, "greater than 0")

    def of(self, name: str, directions: int) -> BodyResolution:
        """Resolution of a body with some directions."""
        same = BodyResolution(self.degree, (self.density,) * directions, self.layers)
        return dict(self.bodies).get(name, same)

    def plain(self) -> dict[str, Any]:
        """Plain data."""
        degrees = {name: each.degree for name, each in self.bodies}
        layers = {name: each.layers for name, each in self.bodies}
        own = {"degrees": degrees, "layers_of": layers} if self.bodies else {}
        return {
            "degree": self.degree,
            "density": self.density,
            "layers": self.layers,
            **own,
        }


def mixed(bodies: Mapping[str, BodyResolution]) -> Resolution:
    """Bodies each at a resolution of its own, summed up by the highest and by the mean density."""
    every = [log(d) for each in bodies.values() for d in each.densities]
    return Resolution(
        max(each.degree for each in bodies.values()),
        exp(sum(every) / len(every)),
        max(each.layers for each in bodies.values()),
        tuple(bodies.items()),
    )


def counted(scene: Scene, backend: Backend, resolution: Resolution) -> Resolution:
    """The same meshes, with densities that are the numbers of elements there are."""
    on = on_backend(scene, backend)
    bodies = {}
    for name, body in on.bodies.items():
        own = resolution.of(name, len(body.geometry.directions))
        mesh = body.mesh.fe if backend == "fe" else body.mesh.iga
        if mesh is not None and mesh.elements:
            counts = _counts(on, name, mesh.elements, own.densities)
            densities = tuple(n / given for n, given in zip(counts, mesh.elements, strict=True))
            own = replace(own, densities=densities)
        bodies[name] = own
    return replace(resolution, bodies=tuple(bodies.items()))


def check_refinable(scene: Scene, backend: Backend) -> None:
    """Refuse scenes that cannot be refined on a backend.

    Raises
    ------
    InputError
        When the analysis is static, or a body has a mesh from a file or none of the backend.
    """
    if scene.analysis.kind != "cea":
        raise InputError("analysis.kind", scene.analysis.kind, "'cea', which has eigenvalues")
    for name, body in scene.bodies.items():
        if isinstance(body.geometry, MeshFile):
            allowed = "a shape, which can be meshed anew: cells of a file stay as they are"
            raise InputError(f"bodies.{name}.geometry.file", body.geometry.file, allowed)
    scene.on(backend)


def has_singular_edges(scene: Scene) -> bool:
    """Whether layers make any difference: a body has singular edges and a structured mesh."""
    return any(crowding(scene, name) and structured(body) for name, body in scene.bodies.items())


def refined(scene: Scene, backend: Backend, resolution: Resolution) -> Scene:
    """The scene on one backend at a resolution, contacts as mortar.

    Parameters
    ----------
    scene
        The scene, whose meshes are those of density 1.
    backend
        Backend of every body.
    resolution
        How fine.

    Raises
    ------
    SceneError
        When the meshes cannot be made so, or a body has none of the backend.
    """
    return Refiner(scene, backend).at(resolution).on(backend)


class Refiner:
    """A scene on one backend at many resolutions, of which none is looked at for faults.

    Parameters
    ----------
    scene
        The scene, whose meshes are those of density 1.
    backend
        Backend of every body.
    """

    def __init__(self, scene: Scene, backend: Backend) -> None:
        contacts = {name: _accurate(contact) for name, contact in scene.contacts.items()}
        self._scene = replace(on_backend(scene, backend), contacts=contacts)
        self._bodies: dict[tuple[str, BodyResolution], BodySpec] = {}

    def at(self, resolution: Resolution) -> Scene:
        """The scene at a resolution; bodies that were made so before are not refined anew."""
        bodies = {}
        for name, body in self._scene.bodies.items():
            own = resolution.of(name, len(body.geometry.directions))
            if (name, own) not in self._bodies:
                self._bodies[name, own] = _refined(self._scene, name, own)
            bodies[name] = self._bodies[name, own]
        return replace(self._scene, bodies=bodies)


def moved_to_mortar(scene: Scene) -> dict[str, str]:
    """Contacts whose formulation refinement changes, with the one that the scene gives."""
    return {
        name: contact.formulation.method
        for name, contact in scene.contacts.items()
        if _accurate(contact) != contact
    }


def _accurate(contact: ContactSpec) -> ContactSpec:
    """A contact as mortar in a half pass; one that is bonded as it is."""
    if contact.formulation.coupling == "bonded" or isinstance(contact.formulation, Mortar):
        return contact
    return replace(contact, formulation=Mortar(), full_pass=False)


def structured(body: BodySpec) -> bool:
    """Whether the mesh of a body follows coordinates of its shape."""
    if not hasattr(body.geometry, "extent"):
        return False
    return body.backend == "iga" or (body.mesh.fe is not None and body.mesh.fe.size is None)


def layers_at_edges(body: BodySpec, edges: Crowding) -> bool:
    """Whether layers towards the edges of a body leave the rest of its mesh as it is.

    Lagrange cells need not lie on a lattice: where all edges run along one direction, or in the
    plane, those at the edges alone are divided (:mod:`meshes.edge_layers`).
    """
    cell = body.mesh.fe.cell if body.backend == "fe" and body.mesh.fe is not None else None
    boxes = cell is not None and cell not in SIMPLICES and structured(body)
    return boxes and len({frozenset(edge) for edge in edges.edges}) == 1


def _refined(scene: Scene, name: str, own: BodyResolution) -> BodySpec:
    body = scene.bodies[name]
    mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
    if isinstance(mesh, FeMesh):
        finer: FeMesh | IgaMesh = replace(mesh, degree=own.degree)
    elif mesh is not None:
        degree = (own.degree,) * len(body.geometry.directions)
        finer = replace(mesh, degree=degree, continuity=None)
    else:
        raise InputError(f"bodies.{name}.mesh.{body.backend}", None, f"needed for {body.backend!r}")
    if isinstance(finer, FeMesh) and finer.size is not None:
        finer = replace(finer, size=finer.size / own.densities[0])
    elif structured(body):
        finer = _with_breaks(finer, scene, name, own)
    else:
        elements = _counts(scene, name, finer.elements or (), own.densities)
        finer = replace(finer, elements=elements)
    return replace(body, mesh=_of_backend(finer))


def _of_backend(mesh: FeMesh | IgaMesh) -> MeshSpec:
    return MeshSpec(fe=mesh) if isinstance(mesh, FeMesh) else MeshSpec(iga=mesh)


def _through(scene: Scene, name: str, edges: Crowding) -> dict[str, tuple[float, ...]]:
    """Coordinates that must be element boundaries of a structured mesh."""
    body = scene.bodies[name]
    mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
    through = dict(mesh.through) if mesh is not None else {}
    for direction, values in edges.through.items():
        through[direction] = tuple(sorted({*through.get(direction, ()), *values}))
    return through


def _counts(
    scene: Scene, name: str, given: tuple[int, ...], densities: tuple[float, ...]
) -> tuple[int, ...]:
    """Elements along each direction but for layers, as many as boundaries ask for at least."""
    counts = [_times(n, density) for n, density in zip(given, densities, strict=True)]
    body = scene.bodies[name]
    if structured(body):
        few = fewest(body.geometry, _through(scene, name, crowding(scene, name)))
        counts = [max(n, least) for n, least in zip(counts, few, strict=True)]
    return tuple(counts)


def _with_breaks(
    mesh: FeMesh | IgaMesh, scene: Scene, name: str, own: BodyResolution
) -> FeMesh | IgaMesh:
    """A structured mesh with as many elements as asked for, and layers at singular edges."""
    shape, edges = scene.bodies[name].geometry, crowding(scene, name)
    through = _through(scene, name, edges)
    elements = _counts(scene, name, mesh.elements or (), own.densities)
    if not own.layers or not edges:
        return replace(mesh, elements=elements, through=through)
    if isinstance(mesh, FeMesh) and layers_at_edges(scene.bodies[name], edges):
        new = replace(mesh, through=through, edges=edges.edges, layers=own.layers)
        while not fit(shape, breaks_of(shape, elements, new.boundaries), edges.edges):
            elements = tuple(
                n + (d in edges.towards) for d, n in zip(shape.directions, elements, strict=True)
            )
        return replace(new, elements=elements)
    along = zip(shape.directions, breaks_of(shape, elements, through), strict=True)
    breaks = {d: layered(each, edges.towards.get(d, ()), own.layers, RATIO) for d, each in along}
    return replace(
        mesh,
        elements=tuple(len(each) - 1 for each in breaks.values()),
        through={d: tuple(each[1:-1].tolist()) for d, each in breaks.items()},
    )


def _times(count: int, density: float) -> int:
    return max(1, ceil(count * density - 1e-9))
