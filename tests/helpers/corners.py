"""A block in the corner of a seat: contact surfaces whose normal jumps, in the plane and in space.

The block fills [0, 1]^dim. The seat fills [-1/2, 3/2]^dim but for the positive corner, so that it
faces the block on the coordinate planes: 2 faces in the plane, 3 in space.
"""

from itertools import chain, product

import numpy as np
from bodies import lagrange_body, nurbs_body
from motions import rigid_motions
from scipy.special import roots_legendre

from cea.contact.contact import Contact
from cea.contact.formulations import (
    Botella,
    GaussPointToSurface,
    Greville,
    Grid,
    Mortar,
    NodeToSurface,
    Segments,
)
from cea.contact.friction import AlongVector, Friction
from cea.contact.interface import default_reach, pair
from cea.contact.laws import LinearLaw
from cea.eigen.driver import solve_modes
from cea.material import IsotropicMaterial
from cea.mesh import Mesh
from cea.supports.boundary import Support
from cea.system.coupled import couple
from meshes.nurbs_shapes import NurbsPatch
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box, Rectangle
from meshes.structured import divided

MATERIAL = IsotropicMaterial(2.0, 0.3, 1.5)
KINDS = {
    2: ("nurbs", "quadrilateral", "triangle"),
    3: ("nurbs", "hexahedron", "tetrahedron"),
}
"""Bodies of each dimension of space."""
BOXES = {"triangle": "quadrilateral", "tetrahedron": "hexahedron"}
MU, STIFFNESS = 0.3, 7.0


def rules(kind):
    """Every formulation that bodies of a kind can have, by name."""
    collocated = {
        "nodes": NodeToSurface(),
        "tributary nodes": NodeToSurface(weights="tributary"),
    }
    if kind == "nurbs":
        collocated = {
            "Greville": Greville(),
            "weighted Greville": Greville(weights="area"),
            "weighted Botella": Botella(weights="area"),
        }
    return collocated | {
        "grid": Grid(3),
        "GPTS": GaussPointToSurface(3),
        "lumped": GaussPointToSurface(3, lumped=True),
        "segments": Segments(),
        "mortar": Mortar(),
    }


def part(name, kind, dim, elements, *, together=True, **conditions):
    """The block or the seat, of elements along each side, with supports or other conditions.

    Its contact surface is "corner", or "face 0", "face 1", ... one by one.
    """
    lines = [np.linspace(0.0, 1.0, elements + 1)]
    if name == "seat":
        lines = [np.linspace(-0.5, 0.0, 2), np.linspace(0.0, 1.5, elements + 1)]
    boxes = list(product(lines, repeat=dim))[: -1 if name == "seat" else None]  # no corner
    faces = {f"face {k}": _ends(boxes, k, 0.0) for k in range(dim)}
    if together:
        faces = {"corner": [*chain(*faces.values())]}
    if name == "seat":
        faces["back"] = _ends(boxes, 0, -0.5)
    conditions |= {"degree": 2, "material": MATERIAL}
    if kind == "nurbs":
        conditions["degree"] = (2,) * dim
        return nurbs_body(name, [_patch(each) for each in boxes], faces, **conditions)
    mesh = _mesh(BOXES.get(kind, kind), boxes, faces)
    return lagrange_body(name, divided(mesh) if kind in BOXES else mesh, **conditions)


def _ends(boxes, axis, value):
    """Ends of boxes in a plane: number of the box, axis, end; at zero, beside the block alone."""
    return [
        (number, axis, end)
        for number, along in enumerate(boxes)
        for end in (0, 1)
        if along[axis][-end] == value
        and (value != 0 or all(each[-1] > 0 for k, each in enumerate(along) if k != axis))
    ]


def _patch(breaks):
    corners = np.stack(np.meshgrid(*(each[[0, -1]] for each in breaks), indexing="ij"), axis=-1)
    knots = tuple(np.repeat(each[[0, -1]], 2) for each in breaks)
    weights = np.ones((2,) * len(breaks))
    return NurbsPatch((1,) * len(breaks), knots, corners, weights, tuple(breaks))


def _mesh(cell, boxes, faces):
    """Mesh of boxes that share their nodes."""
    parts = []
    for breaks in boxes:
        low, high = ([each[end] for each in breaks] for end in (0, -1))
        shape = {2: Rectangle, 3: Box}[len(breaks)](tuple(np.subtract(high, low)), tuple(low))
        parts.append(shape_mesh(shape, cell, 1, breaks=breaks))
    every = np.concatenate([mesh.points for mesh in parts])
    points, number = np.unique(every, axis=0, return_inverse=True)
    starts = np.cumsum([0, *(len(mesh.points) for mesh in parts)])
    surfaces = {
        name: np.concatenate(
            [number[starts[i] + [*parts[i].surfaces.values()][2 * k + end]] for i, k, end in ends]
        )
        for name, ends in faces.items()
    }
    cells = [number[start + mesh.cells] for start, mesh in zip(starts, parts, strict=False)]
    return Mesh(cell, 1, points, np.concatenate(cells), surfaces)


def system(
    kind, dim, rule, *, together=True, reverse=False, held=False, p=STIFFNESS, penetration=None
):
    """Block and seat in contact by a rule, over the corner at once or face by face.

    The points lie on the block or, in reverse, on the seat, which the block covers in part; the
    seat may be held at its back. p is a number, a function of positions and normals, or a law that
    is not linear, which is linearised about a penetration.
    """
    supports = {"supports": [Support("back")]} if held else {}
    bodies = {
        "block": part("block", kind, dim, 5 - dim, together=together),
        "seat": part("seat", kind, dim, 5 - dim, together=together, **supports),
    }
    a, b = ("seat", "block") if reverse else ("block", "seat")
    push = AlongVector((-1.0 if reverse else 1.0,) * dim)
    contacts = []
    for name in [name for name in bodies[a].surfaces if name.startswith(("corner", "face"))]:
        sides = bodies[a].surfaces[name], bodies[b].surfaces[name]
        interface = pair(*sides, rule.points_on(*sides, default_reach(*sides)), max_missed=0.8)
        points, law = interface.points, p
        if callable(p):
            law = LinearLaw(p(points.x, points.normal))
        elif isinstance(p, float):
            law = LinearLaw(np.full(len(points), p))
        closure = None if penetration is None else np.full(len(points), penetration)
        options = {"coupling": rule.coupling, "closure": closure}
        contacts.append(Contact(name, name, a, b, interface, law, Friction(MU, push), **options))
    return couple(bodies, contacts)


def rigid_stiffness(dim, p=STIFFNESS, mu=MU):
    """Contact stiffness and friction stiffness of a rigid block in a rigid seat.

    Integrals over the faces of p (n.m_i) (n.m_j) and mu p (k.m_i) (n.m_j) of the rigid motions m.
    """
    count = 3 * (dim - 1)
    normal, friction = np.zeros((2, count, count))
    t, w = roots_legendre(3)
    for axis in range(dim):
        n = -np.eye(dim)[axis]
        k = np.where(np.arange(dim) == axis, 0.0, 1.0) / np.sqrt(dim - 1)
        for places in product(range(3), repeat=dim - 1):
            x = np.insert((1 + t[list(places)]) / 2, axis, 0.0)
            weight = np.prod(w[list(places)] / 2)
            m = rigid_motions(x[None]).T
            normal += p * weight * np.outer(m @ n, m @ n)
            friction += mu * p * weight * np.outer(m @ k, m @ n)
    return normal, friction


def numbers(kind):
    """Frequencies, stiffnesses and numbers of multipliers that must not depend on ranks."""
    found = {}
    for rule in (Mortar(), next(iter(rules(kind).values()))):
        assembled = system(kind, 2, rule, held=True, p=30.0)
        (contact,) = assembled.contacts
        found[rule.method] = {
            "frequencies": solve_modes(assembled.pencil(), 0.3).frequencies.tolist(),
            "norms": [contact.K_n.norm(), contact.K_f.norm()],
            "rows": contact.gap.getSize()[0],
        }
    return found
