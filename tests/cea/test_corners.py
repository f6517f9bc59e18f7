"""Contact surfaces whose normal jumps at a corner: what reaches over it is split by normal.

A block in the corner of a seat, in the plane and in space. The block fills [0, 1]^dim. The seat
fills [-1/2, 3/2]^dim but for the positive corner, so that it faces the block on the coordinate
planes: 2 faces in the plane, 3 in space.
"""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from bodies import lagrange_body, nurbs_body
from mpi import on_ranks
from petsc_matrices import to_numpy

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
from cea.contact.interface import default_reach, pair
from cea.contact.pressure_and_friction import AlongVector, Friction, LinearLaw
from cea.eigen.driver import solve_modes
from cea.material import IsotropicMaterial
from cea.mesh import facet_nodes
from cea.supports.boundary import Support
from cea.system.coupled import couple
from meshes.nurbs_shapes import nurbs_shape
from meshes.shape_mesh import divided, shape_mesh
from meshes.shapes import Box, Rectangle

MATERIAL = IsotropicMaterial(2.0, 0.3, 1.5)
KINDS = {
    2: ("nurbs", "quadrilateral", "triangle"),
    3: ("nurbs", "hexahedron", "tetrahedron"),
}
"""Bodies of each dimension of space."""
BOXES = {"triangle": "quadrilateral", "tetrahedron": "hexahedron"}


OF_EVERY_KIND = (
    *(Grid(3), Segments(), Mortar()),
    *(GaussPointToSurface(3), GaussPointToSurface(3, lumped=True)),
)
OF_CELLS = (NodeToSurface(), NodeToSurface(weights="tributary"))
OF_NURBS = (Greville(), Greville(weights="area"), Botella(weights="area"))
"""Formulations that bodies of each kind can have."""


@cache
def part(name, kind, dim, *, together=True, supports=()):
    """The block or the seat, which its users leave as it is.

    Its contact surface is "corner", or "face 0", "face 1", ... one by one.
    """
    cuts = np.linspace(0.0, 1.5 if name == "seat" else 1.0, 6 - dim)
    lines = [np.array([-0.5, 0.0]), cuts] if name == "seat" else [cuts]
    conditions = {"degree": 2, "material": MATERIAL, "supports": supports}
    if kind == "nurbs":
        boxes = list(product(lines, repeat=dim))[: -1 if name == "seat" else None]  # no corner
        patches = [nurbs_shape(_box(each), each)[0][0] for each in boxes]
        ends = np.array(list(product(range(len(boxes)), range(dim), (0, 1))))
        middle = np.array([[line.mean() for line in boxes[number]] for number, _, _ in ends])
        for row, (number, axis, end) in zip(middle, ends, strict=True):
            row[axis] = boxes[number][axis][-end]
        conditions["degree"] = (2,) * dim
        return nurbs_body(name, patches, _faces(middle, ends, together), **conditions)
    grid = (np.unique(np.concatenate(lines)),) * dim
    mesh = shape_mesh(_box(grid), BOXES.get(kind, kind), 1, breaks=grid)
    filled = (mesh.points[mesh.cells].mean(axis=1) < 0).any(axis=1) | (name == "block")
    facets = np.concatenate([mesh.cells[filled][:, own] for own in facet_nodes(mesh.cell, 1)])
    faces = _faces(mesh.points[facets].mean(axis=1), facets, together)
    mesh = replace(mesh, cells=mesh.cells[filled], surfaces=faces)
    return lagrange_body(name, divided(mesh) if kind in BOXES else mesh, **conditions)


def _box(breaks):
    """The shape between the ends of breaks along each axis."""
    low, high = (np.array([line[end] for line in breaks]) for end in (0, -1))
    return {2: Rectangle, 3: Box}[len(low)](tuple(high - low), tuple(low))


def _faces(middle, numbers, together):
    """Facets by their middles, which name the planes that the block faces, and the back."""
    others = [(np.delete(middle, k, axis=1) > 0).all(axis=1) for k in range(middle.shape[1])]
    chosen = {f"face {k}": each & (middle[:, k] == 0) for k, each in enumerate(others)}
    if together:
        chosen = {"corner": np.any(list(chosen.values()), axis=0)}
    chosen["back"] = middle[:, 0] == -0.5
    return {name: numbers[each] for name, each in chosen.items() if each.any()}


def system(kind, dim, rule, *, together=True, reverse=False, held=False, p=7.0):
    """Block and seat in contact by a rule, over the corner at once or face by face.

    The points lie on the block or, in reverse, on the seat, which the block covers in part; the
    seat may be held at its back. p is a number, or a function of positions and normals.
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
        points = interface.points
        values = p(points.x, points.normal) if callable(p) else np.full(len(points), p)
        law, friction = LinearLaw(values), Friction(0.3, push)
        options = {"coupling": rule.coupling}
        contacts.append(Contact(name, name, a, b, interface, law, friction, **options))
    return couple(bodies, contacts)


OF = {"fe": "triangle", "iga": "nurbs"}
"""Bodies of each backend in the plane."""


def assert_one_is_several(kind, dim, rule, within=1e-12, **options):
    """K_n and K_f of one contact over a corner are those of one contact for each face."""
    one, several = (
        system(kind, dim, rule, together=together, **options).contacts for together in (True, False)
    )
    assert sum(c.P for c in several) == pytest.approx(sum(c.P for c in one), rel=1e-13)
    for matrix in ("K_n", "K_f"):
        found, expected = (
            sum(to_numpy(getattr(c, matrix)) for c in each) for each in (one, several)
        )
        assert np.abs(found - expected).max() <= within * np.abs(expected).max(), rule


@pytest.mark.grid
@pytest.mark.parametrize(("kind", "dim"), [(kind, dim) for dim in KINDS for kind in KINDS[dim]])
@pytest.mark.parametrize("reverse", [False, True], ids=["block on seat", "seat on block"])
def test_one_contact_over_a_corner_is_one_for_each_face(kind, dim, reverse):
    """Points at the tip too have the normal, the area and the partner of their own face."""
    for rule in (*OF_EVERY_KIND, *(OF_NURBS if kind == "nurbs" else OF_CELLS)):
        assert_one_is_several(kind, dim, rule, reverse=reverse)


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
