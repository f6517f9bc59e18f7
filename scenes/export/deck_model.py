"""The model file of a deck: bodies with numbered nodes and elements, sets, surfaces, materials."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from io import StringIO
from itertools import batched

import numpy as np
from numpy.typing import ArrayLike

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.material import Axes, IsotropicMaterial, Material, OrthotropicMaterial
from cea.mesh import Cell, Mesh, matching_nodes, reference_nodes
from meshes.files.content import named_sides
from meshes.files.elements import KINDS, facet_sides, full_kind, side_nodes
from scenes.building.build import body_mesh, used_surfaces
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

ELEMENTS: Mapping[tuple[Cell, int], str] = {
    ("tetrahedron", 1): "C3D4",
    ("tetrahedron", 2): "C3D10",
    ("hexahedron", 1): "C3D8",
}
"""Element types by cell and degree. CalculiX has no element with the inner node of a triquadratic
hexahedron."""
_PER_LINE = 12
"""Entries of a set per line; the formats allow 16."""


def set_name(place: str) -> str:
    """Return the name of the node set and the surface for "body.surface"."""
    return place.replace(".", "-")


@dataclass(frozen=True)
class DeckBody:
    """A body with its mesh and its numbering in a deck."""

    name: str  # also of its node and element sets
    spec: BodySpec
    mesh: Mesh
    element_type: str
    points: Floats  # nodes (m), (n_nodes, 3)
    elements: Ints  # nodes of each element in the order of its type, right-handed
    faces: Mapping[str, tuple[Ints, Ints]]  # elements, from 0, and their faces, from 1, by surface
    first_node: int  # numbered from 1 over all bodies
    first_element: int

    def nodes_of(self, surface: str) -> Ints:
        """Return the sorted indices of the nodes of a surface."""
        elements, faces = self.faces[surface]
        cell, count = self.mesh.cell, self.elements.shape[1]
        sides = enumerate(side_nodes(cell, KINDS[f"{cell}{count}"].reference), start=1)
        on = [self.elements[elements[faces == face]][:, nodes].ravel() for face, nodes in sides]
        return np.unique(np.concatenate(on))


def deck_bodies(scene: Scene) -> dict[str, DeckBody]:
    """Mesh and number the bodies of a validated scene; return them by name."""
    bodies: dict[str, DeckBody] = {}
    node = element = 1
    for name, spec in scene.bodies.items():
        mesh = body_mesh(name, spec, used_surfaces(scene, name)).without_loose_points()
        mesh = _right_handed(mesh)
        degree = spec.fe_degree or mesh.order
        if (mesh.cell, degree) not in ELEMENTS or mesh.order not in (1, degree):
            allowed = (
                "the order of the cells for a deck, in space, and 1 of hexahedra: this file has "
                f"a {mesh.cell} of order {mesh.order}"
            )
            raise InputError(f"bodies.{name}.mesh.degree", degree, allowed)
        points, elements = _elements(mesh, degree)
        element_type, faces = ELEMENTS[mesh.cell, degree], _faces(mesh)
        bodies[name] = DeckBody(
            name, spec, mesh, element_type, points, elements, faces, node, element
        )
        node, element = node + len(points), element + len(elements)
    return bodies


def _right_handed(mesh: Mesh) -> Mesh:
    """Return the mesh with the first two axes of left-handed cells swapped."""
    own = reference_nodes(mesh.cell, mesh.order)
    corners = np.vstack([np.zeros(mesh.dim), np.eye(mesh.dim)])
    first = np.abs(corners[:, None] - own).max(axis=2).argmin(axis=1)
    x = mesh.points[mesh.cells[:, first]]
    mirrored = np.linalg.det(x[:, 1:] - x[:, :1]) < 0
    swapped = mesh.cells[:, matching_nodes(own[:, [1, 0, *range(2, mesh.dim)]], own)]
    return replace(mesh, cells=np.where(mirrored[:, None], swapped, mesh.cells))


def _elements(mesh: Mesh, degree: int) -> tuple[Floats, Ints]:
    """Return nodes (m) and elements; midpoints of straight edges are added for degree 2."""
    own = reference_nodes(mesh.cell, mesh.order)
    elements = mesh.cells[:, matching_nodes(full_kind(mesh.cell, mesh.order).reference, own)]
    if mesh.order == degree:
        return mesh.points, elements
    ends = full_kind(mesh.cell, degree).groups[elements.shape[1] :]
    pairs = np.sort(elements[:, np.array(ends)], axis=2)
    edges, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    points = np.vstack([mesh.points, mesh.points[edges].mean(axis=1)])
    return points, np.hstack([elements, len(mesh.points) + number.reshape(len(elements), -1)])


def _faces(mesh: Mesh) -> dict[str, tuple[Ints, Ints]]:
    """Return the sorted elements of each surface, and their faces."""
    found = {}
    for name, on_surface in named_sides(mesh).items():
        elements, facets = np.nonzero(on_surface)
        faces = facet_sides(mesh.cell)[facets] + 1
        rising = np.lexsort((faces, elements))
        found[name] = elements[rising], faces[rising]
    return found


def keyword(name: str, **parameters: object) -> str:
    """Return a keyword line; underscores in parameter names become spaces."""
    words = [f"{key.replace('_', ' ')}={value}" for key, value in parameters.items()]
    return ", ".join([f"*{name}", *words])


def comments(lines: Iterable[str]) -> list[str]:
    """Return comment lines; every line of a text becomes a comment."""
    return [f"** {part}".rstrip() for line in lines for part in line.splitlines()]


def numbers(*values: float) -> str:
    """Return a line of numbers of at most 20 characters each, the limit of CalculiX."""
    texts = [(repr(float(value)), value) for value in values]
    return ", ".join(text if len(text) <= 20 else f"{value:.13E}" for text, value in texts)


def table(rows: ArrayLike, form: str) -> list[str]:
    """Return a formatted line for each row."""
    text = StringIO()
    np.savetxt(text, np.asarray(rows), fmt=form)
    return text.getvalue().splitlines()


def model_lines(scene: Scene, bodies: Mapping[str, DeckBody]) -> Iterator[str]:
    """Yield the lines of the model file, which the deck includes."""
    yield from comments(
        [
            f"{scene.name}: bodies of the scene, their surfaces and materials.",
            *scene.description.splitlines(),
            "Node and element sets of bodies are named after the bodies; node sets and",
            "surfaces of their surfaces after both, e.g. pad-bottom.",
        ]
    )
    for body in bodies.values():
        yield from _body_lines(body)


def _body_lines(body: DeckBody) -> Iterator[str]:
    x, material = body.points, body.spec.material
    nodes = np.arange(body.first_node, body.first_node + len(x))
    yield keyword("NODE", NSET=body.name)
    yield from table(np.column_stack([nodes, x]), "%d" + ",%.13E" * 3)
    yield keyword("ELEMENT", TYPE=body.element_type, ELSET=body.name)
    count = np.arange(len(body.elements)) + body.first_element
    rows = np.column_stack([count, body.elements + body.first_node])
    yield from table(rows, ",".join(["%d"] * rows.shape[1]))
    for surface in body.mesh.surfaces:
        name = set_name(f"{body.name}.{surface}")
        yield keyword("NSET", NSET=name)
        members = (body.nodes_of(surface) + body.first_node).tolist()
        for some in batched(members, _PER_LINE):
            yield ",".join(map(str, some))
        yield keyword("SURFACE", NAME=name, TYPE="ELEMENT")
        elements, faces = body.faces[surface]
        yield from table(np.column_stack([elements + body.first_element, faces]), "%d,S%d")
    section = {"ELSET": body.name, "MATERIAL": f"{body.name}-material"}
    if material.axes is not None:
        section["ORIENTATION"] = f"{body.name}-axes"
        yield from _axes_lines(section["ORIENTATION"], material.axes)
    yield keyword("MATERIAL", NAME=section["MATERIAL"])
    yield from _elastic_lines(material)
    if material.rho is not None:
        yield from ("*DENSITY", f"{numbers(material.rho)},")
    yield keyword("SOLID SECTION", **section)


def _axes_lines(name: str, axes: Axes) -> Iterator[str]:
    """Yield the axes of a material: two vectors, or two points of the axis of a cylinder."""
    if axes.cylindrical_about is not None:
        end = np.add(axes.origin, axes.cylindrical_about)
        yield keyword("ORIENTATION", NAME=name, SYSTEM="CYLINDRICAL")
        yield numbers(*axes.origin, *end)
    elif axes.first and axes.second:
        yield keyword("ORIENTATION", NAME=name, SYSTEM="RECTANGULAR")
        yield numbers(*map(float, (*axes.first, *axes.second)))


def _elastic_lines(material: Material) -> Iterator[str]:
    """Yield the elastic constants in the material axes; shear is in the order 12, 13, 23."""
    if isinstance(material, IsotropicMaterial):
        yield from (keyword("ELASTIC"), numbers(material.E, material.nu))
    elif isinstance(material, OrthotropicMaterial):
        s = np.linalg.inv(material.elasticity.matrix)
        E1, E2, E3, G23, G13, G12 = 1 / np.diag(s)
        yield keyword("ELASTIC", TYPE="ENGINEERING CONSTANTS")
        yield numbers(E1, E2, E3, -s[0, 1] * E1, -s[0, 2] * E1, -s[1, 2] * E2, G12, G13)
        yield numbers(G23)
    else:
        order = [0, 1, 2, 5, 4, 3]
        c = material.elasticity.matrix[np.ix_(order, order)]
        upper = [c[i, j] for j in range(6) for i in range(j + 1)]
        yield keyword("ELASTIC", TYPE="ANISOTROPIC")
        for start in range(0, len(upper), 8):
            yield numbers(*upper[start : start + 8])


def boundary_lines(bodies: Mapping[str, DeckBody], **parameters: object) -> Iterator[str]:
    """Yield the supported components of all bodies; nothing if there are none."""
    held = [
        f"{set_name(f'{body.name}.{support.surface}')}, {first}, {last}"
        for body in bodies.values()
        for support in body.spec.supports
        for first, last in _ranges(support.components)
    ]
    if held or parameters:
        yield keyword("BOUNDARY", **parameters)
        yield from held


def _ranges(components: Iterable[str]) -> list[tuple[int, int]]:
    """Return ranges of supported component numbers; no names stand for all components."""
    found = sorted({"xyz".index(each) + 1 for each in components})
    return [(1, 3)] if len(found) in (0, 3) else [(each, each) for each in found]
