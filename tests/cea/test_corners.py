"""Contact surfaces whose normal jumps at a corner: what reaches over it is split by normal.

A block in the corner of a seat, in the plane and in space. The block fills [0, 1]^dim. The seat
fills [-1/2, 3/2]^dim but for the positive corner, so that it faces the block on the coordinate
planes: 2 faces in the plane, 3 in space.
"""

from functools import cache
from itertools import chain, product

import numpy as np
import pytest
from bodies import lagrange_body, nurbs_body
from motions import dense, rigid_motions, unknowns
from motions import product as times
from mpi import on_ranks
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
from cea.contact.laws import LinearLaw, NormalCompliance
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


@cache
def part(name, kind, dim, *, together=True, supports=()):
    """The block or the seat, which its users leave as it is.

    Its contact surface is "corner", or "face 0", "face 1", ... one by one.
    """
    elements = 5 - dim
    lines = [np.linspace(0.0, 1.0, elements + 1)]
    if name == "seat":
        lines = [np.linspace(-0.5, 0.0, 2), np.linspace(0.0, 1.5, elements + 1)]
    boxes = list(product(lines, repeat=dim))[: -1 if name == "seat" else None]  # no corner
    faces = {f"face {k}": _ends(boxes, k, 0.0) for k in range(dim)}
    if together:
        faces = {"corner": [*chain(*faces.values())]}
    if name == "seat":
        faces["back"] = _ends(boxes, 0, -0.5)
    conditions = {"degree": 2, "material": MATERIAL, "supports": supports}
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
    supports = (Support("back"),) if held else ()
    bodies = {
        "block": part("block", kind, dim, together=together),
        "seat": part("seat", kind, dim, together=together, supports=supports),
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


EVERY = pytest.mark.parametrize(
    ("kind", "dim"), [(kind, dim) for dim in KINDS for kind in KINDS[dim]]
)
OF = {"fe": "triangle", "iga": "nurbs"}
"""Bodies of each backend in the plane."""


def assert_one_is_several(kind, dim, rule, within=1e-12, **options):
    """K_n and K_f of one contact over a corner are those of one contact for each face."""
    one, several = (
        system(kind, dim, rule, together=together, **options).contacts for together in (True, False)
    )
    assert sum(c.P for c in several) == pytest.approx(sum(c.P for c in one), rel=1e-13)
    for matrix in ("K_n", "K_f"):
        found, expected = (sum(dense(getattr(c, matrix)) for c in each) for each in (one, several))
        assert np.abs(found - expected).max() <= within * np.abs(expected).max(), rule


@EVERY
@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_rigid_block_in_a_corner_has_the_closed_form(kind, dim, name):
    coupled = system(kind, dim, rules(kind)[name])
    contact = coupled.contacts[0]
    motions = [
        unknowns(coupled, {"block": lambda X, k=k: rigid_motions(X)[:, k]})
        for k in range(3 * (dim - 1))
    ]
    for matrix, true in zip((contact.K_n, contact.K_f), rigid_stiffness(dim), strict=True):
        forces = [times(matrix, x) for x in motions]
        found = np.array([[x.dot(force) for force in forces] for x in motions])
        assert np.abs(found - true).max() <= 1e-12 * np.abs(true).max()


@pytest.mark.grid
@EVERY
@pytest.mark.parametrize("reverse", [False, True], ids=["block on seat", "seat on block"])
def test_one_contact_over_a_corner_is_one_for_each_face(kind, dim, reverse):
    """Points at the tip too have the normal, the area and the partner of their own face."""
    for rule in rules(kind).values():
        assert_one_is_several(kind, dim, rule, reverse=reverse)


@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_a_law_of_the_gap_over_a_corner(backend, name):
    """Normal compliance, linearised about the same penetration of both faces."""
    law = {"p": NormalCompliance(c=30.0, m=2.0), "penetration": 0.1}
    assert_one_is_several(OF[backend], 2, rules(OF[backend])[name], **law)


def test_a_corner_of_which_parts_have_lifted_off(backend):
    """Open parts cut traces; another stiffness on each face."""

    def stiffness(x, normal):
        floor = normal[:, 1] < -0.5
        return np.where(floor, 3.0, 8.0) * (x.max(axis=1) < np.where(floor, 0.5, 0.8))

    assert_one_is_several(OF[backend], 2, Mortar(), 1e-10, p=stiffness)


def numbers(kind):
    """Frequencies, stiffnesses and the number of multipliers."""
    assembled = system(kind, 2, Mortar(), held=True, p=30.0)
    (contact,) = assembled.contacts
    frequencies = solve_modes(assembled.pencil(), 0.3).frequencies.tolist()
    return [*frequencies, contact.K_n.norm(), contact.K_f.norm(), contact.gap.getSize()[0]]


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "kind"),
    [(2, "nurbs"), (2, "triangle"), pytest.param(3, "triangle", marks=pytest.mark.slow)],
)
def test_numbers_of_a_corner_do_not_depend_on_the_ranks(ranks, kind):
    alone = numbers(kind)
    assert len(alone) >= 7
    assert on_ranks(ranks, numbers, kind) == pytest.approx(alone, rel=1e-9)
