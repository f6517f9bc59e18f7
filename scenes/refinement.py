"""Refinement of scenes: more elements along every direction, layers at singular edges.

Bodies of mesh files keep their cells and change the degree. Every contact becomes mortar, which
does not add to the discretisation error of the meshes at any stiffness.

Meshes are graded towards edges with singular stresses. Stresses are singular along the edges
between a clamped and a free face, along re-entrant edges, and along the boundary of a contact that
is stiff compared with its bodies. They are not singular at a roller support, which is a plane of
symmetry.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import prod

from cea.contact.formulations import Mortar
from cea.errors import InputError
from cea.mesh import SIMPLICES
from meshes.breaks import CLOSED, RATIO, breaks_of, fewest, fit, layered
from meshes.mesh_file import MeshFile
from meshes.placement import Placement
from meshes.shapes import Hub, Shape
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import Backend, BodySpec
from scenes.spec.consistency import consistent
from scenes.spec.contact import ContactSpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene

_COMPONENTS = {"r": ("radial",), "theta": ("circumferential",), "z": ("z", "axial")}
"""Other names of the components along a direction."""
_STIFF = 1.0
"""p L / E above which a contact is treated as a rigid joint, with the least length L of the body of
side a and the smaller Young's modulus E."""
_WITHIN = 1e-9
"""Least distance of an inner coordinate from the ends of a range, relative to the range."""

Place = tuple[str, float]
"""A direction and a coordinate along it."""
Edge = tuple[Place, Place]
"""The two coordinates of an edge."""


@dataclass(frozen=True)
class SingularEdges:
    """Singular edges of one body."""

    edges: tuple[dict[str, float], ...] = ()  # by coordinates along two directions
    # coordinates inside the body where the pressure ends, which become element boundaries
    through: dict[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def towards(self) -> dict[str, tuple[float, ...]]:
        """Coordinates of the edges, towards which elements are graded, by direction."""
        return _by_direction([place for edge in self.edges for place in edge.items()])

    def __bool__(self) -> bool:
        return bool(self.edges)


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
    structured = [
        name
        for name, body in scene.bodies.items()
        if body.division is not None and getattr(body.division, "size", None) is None
    ]
    return any(singular_edges(scene, name) for name in structured)


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
        elements = tuple(max(1, round(n * density)) for n in finer.elements or ())
        finer = replace(finer, elements=elements)
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
    of_one_direction = len({frozenset(edge) for edge in edges.edges}) == 1
    if isinstance(mesh, FeMesh) and mesh.cell not in SIMPLICES and of_one_direction:
        # Only the cells at the edges are divided: Lagrange cells need no tensor product mesh.
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


def singular_edges(scene: Scene, name: str) -> SingularEdges:
    """Return the singular edges of a body, and inner coordinates at which the pressure ends.

    The result is empty if no edge is singular, or the shape has no faces normal to coordinates.
    """
    body = scene.bodies[name]
    faces = []  # that are clamped, or sides a of stiff contacts
    for support in body.supports:
        clamped = len(set(support.components)) in (0, body.dim)
        if clamped and support.components != ("normal",):
            faces.append(support.surface)
    for contact in scene.contacts.values():
        owner, surface = contact.sides[0]
        if owner == name and _is_stiff(scene, contact):
            faces.append(surface)
    found = [edge for face in faces for edge in _edges(body, face)]
    found += [*_re_entrant(body.geometry), *_boundaries_on(scene, name, stiff=True)]
    inner = [place for _, place in _boundaries_on(scene, name, stiff=False)]
    edges = tuple(dict(edge) for edge in dict.fromkeys(found))
    return SingularEdges(edges, _by_direction(inner))


def _by_direction(places: list[Place]) -> dict[str, tuple[float, ...]]:
    directions = dict.fromkeys(direction for direction, _ in places)
    return {d: tuple(sorted({x for name, x in places if name == d})) for d in directions}


def _ranges(shape: Shape) -> dict[str, tuple[float, float]]:
    return dict(zip(shape.directions, shape.extent, strict=True))


def _is_stiff(scene: Scene, contact: ContactSpec) -> bool:
    """Whether a contact is nearly rigid; assumed if its stiffness is not a number."""
    bodies = [scene.bodies[name] for name, _ in contact.sides]
    lengths = sorted(bodies[0].lengths)
    p = contact.p
    if contact.P is not None:  # divided by the approximate area of the largest face
        p = contact.P / prod(lengths[1:])
    if not isinstance(p, int | float):
        return True
    return bool(p * lengths[0] > _STIFF * min(body.material.means[0] for body in bodies))


def _edges(body: BodySpec, surface: str) -> Iterator[Edge]:
    """Yield the edges of a face whose adjacent faces are free."""
    shape, face, held = body.geometry, body.faces.get(surface), _held(body)
    if face is None:
        return
    at = face.direction, face.at
    for direction, ends in _ranges(shape).items():
        if direction == face.direction or (isinstance(shape, CLOSED) and direction == "theta"):
            continue
        yield from ((at, (direction, ends[end])) for end in (0, 1) if (direction, end) not in held)


def _held(body: BodySpec) -> set[tuple[str, int]]:
    """Return the direction and end of each face that is supported along its normal."""
    held = set()
    for support in body.supports:
        if (face := body.faces.get(support.surface)) is not None:
            along = {"normal", face.direction, *_COMPONENTS.get(face.direction, ())}
            if not support.components or along & set(support.components):
                held.add((face.direction, face.end))
    return held


def _boundaries_on(scene: Scene, name: str, *, stiff: bool) -> Iterator[Edge]:
    """Yield the edges of sides a that lie inside a side b on this body.

    Only those of stiff contacts if ``stiff``, else all. They are found only if both bodies have the
    default placement and the same directions.
    """
    body, as_shaped = scene.bodies[name], Placement()
    for contact in scene.contacts.values():
        (name_of_a, _), (owner, surface) = contact.sides
        other = scene.bodies[name_of_a]
        face = body.faces.get(surface) if owner == name else None
        aligned = body.geometry.directions == other.geometry.directions
        aligned = aligned and body.placement == other.placement == as_shaped
        if face is None or not aligned or (stiff and not _is_stiff(scene, contact)):
            continue
        at, theirs = (face.direction, face.at), _ranges(other.geometry)
        for direction, (low, high) in _ranges(body.geometry).items():
            closed = isinstance(other.geometry, CLOSED) and direction == "theta"
            margin = _WITHIN * (high - low)
            for coordinate in () if closed or direction == face.direction else theirs[direction]:
                if low + margin < coordinate < high - margin:
                    yield at, (direction, coordinate)


def _re_entrant(shape: Shape) -> Iterator[Edge]:
    """Yield the re-entrant edges between the ring of a hub and its thicker part."""
    if isinstance(shape, Hub):
        for z, end in ((shape.bottom, shape.hub_bottom), (shape.top, shape.hub_top)):
            if z != end:
                yield ("r", shape.hub_radius), ("z", z)
