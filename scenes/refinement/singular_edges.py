"""Edges with singular stresses, towards which the meshes of a body are graded.

Stresses are singular along the edges between a clamped and a free face, along re-entrant edges, and
along the boundary of a contact that is stiff compared with its bodies. They are not singular at a
roller support, which is a plane of symmetry.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import prod

from meshes.breaks import CLOSED
from meshes.placement import Placement
from meshes.shapes import Hub, Shape
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
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
    body = scene.bodies[name]
    for contact in scene.contacts.values():
        (name_of_a, _), (owner, surface) = contact.sides
        other = scene.bodies[name_of_a]
        face = body.faces.get(surface) if owner == name else None
        if face is None or not _aligned(body, other) or (stiff and not _is_stiff(scene, contact)):
            continue
        at, theirs = (face.direction, face.at), _ranges(other.geometry)
        for direction, (low, high) in _ranges(body.geometry).items():
            closed = isinstance(other.geometry, CLOSED) and direction == "theta"
            margin = _WITHIN * (high - low)
            for coordinate in () if closed or direction == face.direction else theirs[direction]:
                if low + margin < coordinate < high - margin:
                    yield at, (direction, coordinate)


def _aligned(body: BodySpec, other: BodySpec) -> bool:
    """Whether two bodies have the default placement and the same coordinate directions."""
    as_shaped = all(each.placement == Placement() for each in (body, other))
    return as_shaped and body.geometry.directions == other.geometry.directions


def _re_entrant(shape: Shape) -> Iterator[Edge]:
    """Yield the re-entrant edges between the ring of a hub and its thicker part."""
    if isinstance(shape, Hub):
        for z, end in ((shape.bottom, shape.hub_bottom), (shape.top, shape.hub_top)):
            if z != end:
                yield ("r", shape.hub_radius), ("z", z)
