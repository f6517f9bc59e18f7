"""Refinement of scenes: richer spaces; more elements along every direction, graded to edges.

In :func:`refined` scenes bodies of mesh files keep their cells and change the degree. Every contact
becomes mortar, which does not add to the discretisation error of the meshes at any stiffness.

Meshes are graded towards edges with singular stresses. Stresses are singular along the edges
between a clamped and a free face, along re-entrant edges, and along the boundary of a contact that
is stiff compared with its bodies. They are not singular at a roller support, which is a plane of
symmetry.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import prod
from typing import Any, Literal, get_args

from cea.contact.formulations import Mortar
from cea.errors import InputError, require
from cea.mesh import SIMPLICES
from meshes.breaks import CLOSED, RATIO, breaks_of, fewest, fit, layered
from meshes.mesh_file import MeshFile
from meshes.placement import Placement
from meshes.shapes import Hub, Shape
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import Backend, BodySpec, FeMesh, IgaMesh, MeshSpec
from scenes.spec.consistency import consistent
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_COMPONENTS = {"r": ("radial",), "theta": ("circumferential",), "z": ("z", "axial")}
"""Other names of the components along a direction."""
_STIFF = 1.0
"""p L / E above which a contact is treated as a rigid joint, with the least length L of the body of
side a and the smaller Young's modulus E."""
_WITHIN = 1e-9
"""Least distance of an inner coordinate from the ends of a range, relative to the range."""

_HIGHEST = {"fe": 4, "iga": 8}
"""Highest degree of each backend."""

Enrichment = Literal["degree", "bisection", "smooth"]
Place = tuple[str, float]
"""A direction and a coordinate along it."""
Edge = tuple[Place, Place]
"""The two coordinates of an edge."""


@dataclass(frozen=True)
class Resolution:
    """Degree, density and layers of a refined scene."""

    degree: int  # of the elements of every shape
    density: float  # factor of the numbers of elements along every direction
    layers: int = 0  # number of geometric layers towards singular edges
    file_degree: int | None = None  # on the cells of mesh files; None for the default degree

    def __post_init__(self) -> None:
        require(self.density > 0, "density", self.density, "greater than 0")


def on_backend_of_shapes(scene: Scene, backend: Backend) -> Scene:
    """Return the scene with every shape on one backend; mesh files keep Lagrange elements."""
    shapes = [name for name, body in scene.bodies.items() if not from_file(body)]
    return scene.change({f"bodies.{name}.backend": backend for name in shapes})


def from_file(body: BodySpec) -> bool:
    """Whether the cells of a body are those of a mesh file."""
    return isinstance(body.geometry, MeshFile)


def has_singular_edges(scene: Scene) -> bool:
    """Whether layers have an effect: a body has singular edges and a structured mesh."""
    meshes = {name: body.division for name, body in scene.bodies.items()}
    structured = [name for name, mesh in meshes.items() if mesh is not None and mesh.elements]
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


def richer_scene(scene: Scene, by: Enrichment | None = "degree") -> Scene:
    """Return the scene with the space of every body enriched; shapes and contacts do not change.

    The new spaces contain the old ones, with three exceptions: curved Lagrange cells, whose
    geometry is refined too to include its error; NURBS of higher continuity; and bisection of
    elements ``through`` given coordinates, if the number of elements of a part does not double.

    Parameters
    ----------
    scene
        The scene to enrich.
    by
        ``"degree"``: one degree higher; NURBS keep their continuity.
        ``"bisection"``: twice the elements along each direction.
        ``"smooth"``: one degree and one continuous derivative higher, which adds few unknowns;
        NURBS only.
        None: a choice that also shows the errors of singular solutions at moderate cost. In the
        plane bisection; in three dimensions one degree higher, smooth for NURBS, and bisection at
        the highest degree.

    Raises
    ------
    InputError
        If a degree is already the highest, or the mesh to bisect has no numbers of elements.
    """
    known = get_args(Enrichment)
    require(by is None or by in known, "by", by, " or ".join(map(repr, known)))
    bodies = scene.bodies.items()
    enriched = {name: _enriched(f"bodies.{name}.mesh", body, by) for name, body in bodies}
    return replace(scene, bodies=enriched)


def _enriched(field: str, body: BodySpec, by: Enrichment | None) -> BodySpec:
    """Return a body with its space enriched; ``field`` is the path of its mesh."""
    mesh, highest = body.division, _HIGHEST[body.backend]
    degree = max(mesh.degree) if isinstance(mesh, IgaMesh) else body.fe_degree or 0
    if by is None:
        by = "smooth" if body.backend == "iga" else "degree"
        if mesh is not None and mesh.elements and (body.dim == 2 or degree >= highest):
            by = "bisection"
    if by == "smooth" and body.backend == "fe":
        raise InputError("by", by, "'degree' or 'bisection' for Lagrange elements")
    allowed = f"below {highest} to be raised; bisect elements instead"
    require(by == "bisection" or degree < highest, f"{field}.degree", degree, allowed)
    if mesh is None:
        require(by == "degree", field, by, "'degree': cells of a mesh file cannot be bisected")
        return replace(body, mesh=replace(body.mesh, degree=degree + 1))
    finer: FeMesh | IgaMesh
    if by == "bisection":
        if mesh.elements is None:
            allowed = "left out, with elements given instead, for bisection"
            raise InputError(f"{field}.fe.size", getattr(mesh, "size", None), allowed)
        finer = replace(mesh, elements=tuple(2 * n for n in mesh.elements))
    elif isinstance(mesh, IgaMesh):
        continuity = mesh.continuities if by == "degree" else mesh.continuity
        if by == "smooth" and continuity is not None:
            continuity = tuple(c + 1 for c in continuity)
        finer = replace(mesh, degree=tuple(q + 1 for q in mesh.degree), continuity=continuity)
    else:
        curved = mesh.geometry_degree
        geometry = None if curved is None else min(curved + 1, highest)
        finer = _of_degree(body, replace(mesh, geometry_degree=geometry), degree + 1)
    own: Any = {body.backend: finer}
    return replace(body, mesh=replace(body.mesh, **own))


def _of_degree(body: BodySpec, mesh: FeMesh, degree: int) -> FeMesh:
    """Return a mesh with elements of another degree, with cells that the shape of the body has."""
    curved = mesh.geometry_degree
    if isinstance(body.geometry, VentilatedDisc):
        curved = min(curved or degree, MAX_CURVED)
    return replace(mesh, degree=degree, geometry_degree=curved)


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
    assert mesh is not None, "the scene was checked on this backend"
    finer: FeMesh | IgaMesh
    if isinstance(mesh, FeMesh):
        finer = _of_degree(body, mesh, resolution.degree)
    else:
        finer = replace(mesh, degree=(resolution.degree,) * body.dim, continuity=None)
    if isinstance(finer, FeMesh) and finer.size is not None:
        finer = replace(finer, size=finer.size / density)
    else:
        elements = tuple(max(1, round(n * density)) for n in finer.elements or ())
        finer = replace(finer, elements=elements)
        finer = _with_breaks(finer, scene, name, resolution.layers)
    own: Any = {body.backend: finer}
    return replace(body, mesh=MeshSpec(**own))


def _with_breaks(mesh: FeMesh | IgaMesh, scene: Scene, name: str, layers: int) -> FeMesh | IgaMesh:
    """Return a structured mesh that fits contact boundaries, with layers at singular edges."""
    shape, edges = scene.bodies[name].geometry, singular_edges(scene, name)
    inner = [place for _, place in _boundaries_on(scene, name, stiff=False)]
    given = [(direction, x) for direction, values in mesh.through.items() for x in values]
    through = by_direction([*given, *inner])
    least = fewest(shape, through)
    elements = tuple(map(max, mesh.elements or (), least))
    if not layers or not edges:
        return replace(mesh, elements=elements, through=through)
    towards = by_direction([place for edge in edges for place in edge.items()])
    of_one_direction = len({frozenset(edge) for edge in edges}) == 1
    if isinstance(mesh, FeMesh) and mesh.cell not in SIMPLICES and of_one_direction:
        # Only the cells at the edges are divided: Lagrange cells need no tensor product mesh.
        new = replace(mesh, through=through, edges=edges, layers=layers)
        while not fit(shape, breaks_of(shape, elements, new.boundaries), edges):
            counts = zip(shape.directions, elements, strict=True)
            elements = tuple(n + (direction in towards) for direction, n in counts)
        return replace(new, elements=elements)
    along = zip(shape.directions, breaks_of(shape, elements, through), strict=True)
    breaks = {d: layered(each, towards.get(d, ()), layers, RATIO) for d, each in along}
    return replace(
        mesh,
        elements=tuple(len(each) - 1 for each in breaks.values()),
        through={d: tuple(each[1:-1].tolist()) for d, each in breaks.items()},
    )


def singular_edges(scene: Scene, name: str) -> tuple[dict[str, float], ...]:
    """Return the singular edges of a body, each as its coordinates by direction.

    There are none if no edge is singular, or the shape has no faces normal to coordinates.
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
    return tuple(dict(edge) for edge in dict.fromkeys(found))


def by_direction(places: list[Place]) -> dict[str, tuple[float, ...]]:
    """Return the coordinates of places by direction, sorted."""
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
