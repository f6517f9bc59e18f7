"""Refinement of scenes: more elements along every direction, layers at singular edges.

Bodies of mesh files keep their cells and change the degree. Every contact becomes mortar, which
does not add to the discretisation error of the meshes at any stiffness.
"""

from dataclasses import dataclass, replace

from cea.contact.formulations import Mortar
from cea.errors import InputError
from cea.mesh import SIMPLICES
from meshes.breaks import breaks_of, fewest, layered
from meshes.edge_layers import RATIO, fit
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.refinement.singular_edges import SingularEdges, singular_edges
from scenes.spec.body import Backend, BodySpec
from scenes.spec.consistency import consistent
from scenes.spec.contact import ContactSpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class Resolution:
    """Degree, density and layers of a refined scene."""

    degree: int  # of the elements of every shape
    density: float  # factor of the numbers of elements along every direction
    layers: int = 0  # number of geometric layers towards singular edges
    file_degree: int | None = None  # on the cells of mesh files; None for the default degree

    def __post_init__(self) -> None:
        if not self.density > 0:
            raise InputError("density", self.density, "greater than 0")


def on_backend_of_shapes(scene: Scene, backend: Backend) -> Scene:
    """Return the scene with every shape on one backend; mesh files keep Lagrange elements."""
    shapes = [name for name, body in scene.bodies.items() if not from_file(body)]
    return scene.change({f"bodies.{name}.backend": backend for name in shapes})


def from_file(body: BodySpec) -> bool:
    """Whether the cells of a body are those of a mesh file."""
    return isinstance(body.geometry, MeshFile)


def has_singular_edges(scene: Scene) -> bool:
    """Whether layers have an effect: a body has singular edges and a structured mesh."""
    return any(
        singular_edges(scene, name) and _is_structured(body) for name, body in scene.bodies.items()
    )


def refined(scene: Scene, backend: Backend, resolution: Resolution) -> Scene:
    """Return the refined scene on one backend with mortar contacts; the scene has density 1.

    Raises
    ------
    SceneError
        If the refined scene is invalid, or a body has no mesh for the backend.
    """
    given = on_backend_of_shapes(scene, backend)
    contacts = {name: _accurate(contact) for name, contact in given.contacts.items()}
    bodies = {name: _refined(given, name, resolution) for name in given.bodies}
    return consistent(replace(given, bodies=bodies, contacts=contacts))


def moved_to_mortar(scene: Scene) -> dict[str, str]:
    """Return the contacts whose formulation refinement changes, with the original method."""
    return {
        name: contact.formulation.method
        for name, contact in scene.contacts.items()
        if _accurate(contact) != contact
    }


def _accurate(contact: ContactSpec) -> ContactSpec:
    """Return a contact as mortar in a half pass; bonded and mortar contacts are unchanged."""
    if contact.formulation.coupling == "bonded" or isinstance(contact.formulation, Mortar):
        return contact
    return replace(contact, formulation=Mortar(), full_pass=False)


def _is_structured(body: BodySpec) -> bool:
    """Whether the mesh of a body is structured along the coordinates of its shape."""
    return body.division is not None and getattr(body.division, "size", None) is None


def _layers_at_edges(body: BodySpec, edges: SingularEdges) -> bool:
    """Whether layers can be confined to the cells at the edges of a body.

    Lagrange cells need no tensor product mesh: if all edges run along one direction, or in the
    plane, only the cells at the edges are divided (:mod:`meshes.edge_layers`).
    """
    mesh = body.division
    boxes = isinstance(mesh, FeMesh) and mesh.cell not in SIMPLICES and _is_structured(body)
    return boxes and len({frozenset(edge) for edge in edges.edges}) == 1


def _refined(scene: Scene, name: str, resolution: Resolution) -> BodySpec:
    body, density = scene.bodies[name], resolution.density
    if from_file(body):
        return replace(body, mesh=replace(body.mesh, degree=resolution.file_degree))
    mesh = body.division
    if mesh is None:
        raise InputError(f"bodies.{name}.mesh.{body.backend}", None, f"needed for {body.backend!r}")
    finer: FeMesh | IgaMesh
    if isinstance(mesh, FeMesh):
        finer = replace(mesh, degree=resolution.degree)
    else:
        degree = (resolution.degree,) * len(body.geometry.directions)
        finer = replace(mesh, degree=degree, continuity=None)
    if isinstance(finer, FeMesh) and finer.size is not None:
        finer = replace(finer, size=finer.size / density)
        if isinstance(body.geometry, VentilatedDisc):
            curved = min(finer.geometry_degree or finer.degree, MAX_CURVED)
            finer = replace(finer, geometry_degree=curved)
    else:
        finer = replace(
            finer, elements=tuple(max(1, round(n * density)) for n in finer.elements or ())
        )
        if _is_structured(body):
            finer = _with_breaks(finer, scene, name, resolution.layers)
    mesh_spec = MeshSpec(fe=finer) if isinstance(finer, FeMesh) else MeshSpec(iga=finer)
    return replace(body, mesh=mesh_spec)


def _with_breaks(mesh: FeMesh | IgaMesh, scene: Scene, name: str, layers: int) -> FeMesh | IgaMesh:
    """Return a structured mesh that fits contact boundaries, with layers at singular edges."""
    body, edges = scene.bodies[name], singular_edges(scene, name)
    shape, through = body.geometry, dict(mesh.through)
    for direction, values in edges.through.items():
        through[direction] = tuple(sorted({*through.get(direction, ()), *values}))
    least = fewest(shape, through)
    elements = tuple(map(max, mesh.elements or (), least))
    if not layers or not edges:
        return replace(mesh, elements=elements, through=through)
    if isinstance(mesh, FeMesh) and _layers_at_edges(body, edges):
        new = replace(mesh, through=through, edges=edges.edges, layers=layers)
        while not fit(shape, breaks_of(shape, elements, new.boundaries), edges.edges):
            elements = tuple(
                n + (d in edges.towards) for d, n in zip(shape.directions, elements, strict=True)
            )
        return replace(new, elements=elements)
    along = zip(shape.directions, breaks_of(shape, elements, through), strict=True)
    breaks = {d: layered(each, edges.towards.get(d, ()), layers, RATIO) for d, each in along}
    return replace(
        mesh,
        elements=tuple(len(each) - 1 for each in breaks.values()),
        through={d: tuple(each[1:-1].tolist()) for d, each in breaks.items()},
    )
