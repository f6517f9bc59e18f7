"""A block in the corner of a seat: contact surfaces whose normal jumps, in the plane and in space.

The block fills [0, 1]^dim. The seat fills [-1/2, 3/2]^dim but for the positive corner, so that it
faces the block on the coordinate planes: 2 faces in the plane, 3 in space.
"""

from itertools import chain, product

import numpy as np
from bodies import lagrange_body, nurbs_body
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
from cea.mesh import Mesh, facet_nodes
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


def block(kind, dim, elements, *, together=True, degree=2, **conditions):
    """The block; its contact surface is "corner", or "face 0", "face 1", ... one by one.

    Parameters
    ----------
    kind, dim, elements
        Kind of the body, dimension of space, elements along each side.
    together
        Whether the faces are one surface.
    degree, conditions
        Those of the body.
    """
    breaks = [np.linspace(0.0, 1.0, elements + 1)] * dim
    if kind == "nurbs":
        faces = {f"face {k}": [(0, k, 0)] for k in range(dim)}
        faces |= {"back 0": [(0, 0, 1)], "back 1": [(0, 1, 1)]}
        return _nurbs("block", [breaks], faces, together, degree, conditions)
    planes = {f"face {k}": (k, 0.0) for k in range(dim)} | {"back 0": (0, 1.0), "back 1": (1, 1.0)}
    return _lagrange("block", kind, breaks, planes, together, degree, conditions)


def seat(kind, dim, elements, *, together=True, degree=2, **conditions):
    """The seat; names as of the block, "back" behind its first face."""
    parts = [np.linspace(-0.5, 0.0, 2), np.linspace(0.0, 1.5, elements + 1)]
    if kind == "nurbs":
        places = [place for place in product((0, 1), repeat=dim) if not all(place)]
        faces = {
            f"face {k}": [
                (number, k, 1)
                for number, place in enumerate(places)
                if place == tuple(int(j != k) for j in range(dim))
            ]
            for k in range(dim)
        }
        faces["back"] = [(number, 0, 0) for number, place in enumerate(places) if not place[0]]
        breaks = [[parts[end] for end in place] for place in places]
        return _nurbs("seat", breaks, faces, together, degree, conditions)
    breaks = [np.unique(np.concatenate(parts))] * dim
    planes = {f"face {k}": (k, 0.0) for k in range(dim)} | {"back": (0, -0.5)}
    return _lagrange("seat", kind, breaks, planes, together, degree, conditions)


def _nurbs(name, breaks, faces, together, degree, conditions):
    patches = [
        NurbsPatch(
            (1,) * len(along),
            tuple(np.repeat(each[[0, -1]], 2) for each in along),
            _corners(along),
            np.ones((2,) * len(along)),
            tuple(along),
        )
        for along in breaks
    ]
    degrees = (degree,) * len(breaks[0])
    faces = _named(faces, together, lambda parts: list(chain(*parts)))
    return nurbs_body(name, patches, faces, degrees, material=MATERIAL, **conditions)


def _corners(breaks):
    return np.stack(np.meshgrid(*(each[[0, -1]] for each in breaks), indexing="ij"), axis=-1)


def _lagrange(name, cell, breaks, planes, together, degree, conditions):
    boxes = BOXES.get(cell, cell)
    low, high = ([each[end] for each in breaks] for end in (0, -1))
    shape = {2: Rectangle, 3: Box}[len(breaks)](tuple(np.subtract(high, low)), tuple(low))
    whole = shape_mesh(shape, boxes, 1, breaks=tuple(breaks))
    cells = whole.cells
    if name == "seat":
        cells = cells[~(whole.points[cells].mean(axis=1) > 0).all(axis=1)]
    facets = np.concatenate([cells[:, nodes] for nodes in facet_nodes(boxes, 1)])
    _, index, count = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    facets = facets[index[count == 1]]
    x = whole.points[facets]
    middle = x.mean(axis=1)
    surfaces = {}
    for surface, (axis, value) in planes.items():
        on = (x[:, :, axis] == value).all(axis=1)
        if value == 0:
            on &= (np.delete(middle, axis, axis=1) > 0).all(axis=1)
        surfaces[surface] = facets[on]
    surfaces = _named(surfaces, together, np.concatenate)
    mesh = Mesh(boxes, 1, whole.points, cells, surfaces).without_loose_points()
    mesh = divided(mesh) if cell in BOXES else mesh
    return lagrange_body(name, mesh, degree=degree, material=MATERIAL, **conditions)


def _named(surfaces, together, joined):
    if not together:
        return surfaces
    faces = [surface for surface in surfaces if surface.startswith("face")]
    rest = {name: surface for name, surface in surfaces.items() if name not in faces}
    return {"corner": joined([surfaces[name] for name in faces])} | rest


def system(kind, dim, rule, *, together=True, reverse=False, held=False, **options):
    """Block and seat in contact: over the corner at once, or face by face.

    Parameters
    ----------
    kind, dim
        Kind of the bodies, dimension of space.
    rule
        Formulation.
    together
        Whether one contact reaches over the corner.
    reverse
        Whether the points lie on the seat, which the block covers in part.
    held
        Whether the seat is held at its back.
    options
        Those of :func:`coupled`.
    """
    supports = {"supports": [Support("back")]} if held else {}
    bodies = {
        "block": block(kind, dim, 5 - dim, together=together),
        "seat": seat(kind, dim, 5 - dim, together=together, **supports),
    }
    a, b = ("seat", "block") if reverse else ("block", "seat")
    return coupled(bodies, rule, a=a, b=b, **options)


def coupled(bodies, rule, *, a="block", b="seat", p=STIFFNESS, mu=MU, penetration=None, **options):
    """Bodies in contact on their surfaces of the same names, by a rule on body a.

    Parameters
    ----------
    bodies, rule
        Bodies by name, formulation.
    a, b
        Names of the sides.
    p
        Contact stiffness: a number, a function of positions and normals, or a law that is not
        linear.
    mu
        Friction coefficient.
    penetration
        What such a law is linearised about.
    options
        Those of couple.
    """
    contacts = []
    names = [name for name in bodies[a].surfaces if name.startswith(("corner", "face"))]
    for name in names:
        sides = bodies[a].surfaces[name], bodies[b].surfaces[name]
        points = rule.points_on(*sides, default_reach(*sides))
        interface = pair(*sides, points, max_missed=0.8)
        points, form, law = interface.points, None, p
        if callable(p):
            law = LinearLaw(p(points.x, points.normal))
        elif isinstance(p, float):
            law, form = LinearLaw(np.full(len(points), p)), "saddle" if p == np.inf else None
        push = (1.0 if a == "block" else -1.0,) * bodies[a].dim
        contacts.append(
            Contact(
                name,
                name,
                a,
                b,
                interface,
                law,
                Friction(mu, AlongVector(push)),
                coupling=rule.coupling,
                form=form,
                closure=None if penetration is None else np.full(len(points), penetration),
            )
        )
    return couple(bodies, contacts, **options)


def rigid_motions(dim):
    """Translations and rotations as functions of position, each (n, dim) to (n, dim)."""
    planes = [(0, 1)] if dim == 2 else [(0, 1), (1, 2), (2, 0)]

    def moved(axis):
        return lambda x: np.tile(np.eye(dim)[axis], (len(x), 1))

    def turned(i, j):
        return lambda x: np.outer(x[:, i], np.eye(dim)[j]) - np.outer(x[:, j], np.eye(dim)[i])

    return [*map(moved, range(dim)), *(turned(*plane) for plane in planes)]


def rigid_stiffness(dim, p=STIFFNESS, mu=MU):
    """Contact stiffness and friction stiffness of a rigid block in a rigid seat.

    Integrals over the faces of p (n.m_i) (n.m_j) and mu p (k.m_i) (n.m_j) of the rigid motions m.
    """
    motions = rigid_motions(dim)
    normal, friction = np.zeros((2, len(motions), len(motions)))
    t, w = roots_legendre(3)
    for axis in range(dim):
        n = -np.eye(dim)[axis]
        k = np.where(np.arange(dim) == axis, 0.0, 1.0) / np.sqrt(dim - 1)
        for places in product(range(3), repeat=dim - 1):
            x = np.insert((1 + t[list(places)]) / 2, axis, 0.0)
            weight = np.prod(w[list(places)] / 2)
            m = np.array([motion(x[None])[0] for motion in motions])
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
