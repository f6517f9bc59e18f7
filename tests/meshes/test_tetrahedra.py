"""Bodies of several kinds of solid elements divided into tetrahedra."""

from dataclasses import replace

import numpy as np
import pytest
from basix import CellType, LagrangeVariant, make_quadrature
from basix.ufl import element as lagrange
from mesh_writers import mixed_blocks

from cea.mesh import Mesh, facet_nodes, node_order
from meshes.files.body import check_elements
from meshes.files.content import block
from meshes.files.elements import KINDS
from meshes.files.tetrahedra import completed, tetrahedra

RULE = np.array([0.5 - np.sqrt(15) / 10, 0.5, 0.5 + np.sqrt(15) / 10]), np.array([5, 8, 5]) / 18


def bent(x):
    """A quadratic map, which elements of second order hold exactly."""
    x, y, z = x.T
    return np.stack([x + 0.02 * y * z, y + 0.015 * x * x, z + 0.02 * x * y - 0.01 * z * z], axis=1)


def bent_volume():
    """Volume that the map makes of the box, by Gauss points that are exact for it."""
    at = [(length * RULE[0], length * RULE[1]) for length in (3, 2, 3)]
    x, y, z = np.meshgrid(*(p for p, _ in at), indexing="ij")
    weights = np.einsum("i,j,k->ijk", *(w for _, w in at))
    one, none = np.ones_like(x), np.zeros_like(x)
    rows = [
        [one, 0.02 * z, 0.02 * y],
        [0.03 * x, one, none],
        [0.02 * y, 0.02 * x, one - 0.02 * z],
    ]
    return (weights * np.linalg.det(np.moveaxis(np.array(rows), (0, 1), (-2, -1)))).sum()


def volumes(points, cells, order):
    """Volumes of tetrahedra, by a rule of degree 5."""
    at, weights = make_quadrature(CellType.tetrahedron, 5)
    shapes = lagrange("Lagrange", "tetrahedron", order, lagrange_variant=LagrangeVariant.equispaced)
    slopes = shapes.tabulate(1, at)[1:]
    theirs = shapes._element.points
    ours = np.argsort(node_order("tetrahedron", order, theirs))
    jacobians = np.einsum("dqn,cni->cqid", slopes, points[cells[:, ours]])
    return np.einsum("q,cq->c", weights, np.linalg.det(jacobians))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("seed", range(5))
def test_tetrahedra_fill_the_body_and_match_across_faces(order, seed):
    points, blocks = mixed_blocks(order, seed, bent if order == 2 else lambda x: x)
    made = tetrahedra(points, blocks)
    found = volumes(made.points, made.cells, order)
    assert found.min() > 0
    assert found.sum() == pytest.approx(bent_volume() if order == 2 else 18.0, rel=1e-13)
    sides = np.concatenate([made.cells[:, f] for f in facet_nodes("tetrahedron", order)])
    _, times = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert times.max() == 2
    assert (times == 1).sum() == 2 * 2 * (3 * 2 + 3 * 2 + 3 * 3)  # two triangles on each square
    Mesh("tetrahedron", order, made.points, made.cells, {})
    check_elements("tetrahedron", order, made.points, made.cells, made.elements)


def test_nodes_that_elements_have_are_kept_and_no_others_double():
    points, blocks = mixed_blocks(2, nodes=[27, 18, 14, 10], move=bent)
    made = tetrahedra(points, blocks)
    assert len(made.points) == len(points)  # middles of faces and cells were all there
    lacking, fewer = mixed_blocks(2, move=bent)
    added = tetrahedra(lacking, fewer)
    used = np.unique(made.cells)
    assert len(np.unique(added.cells)) == len(used)
    places = [p[np.unique(c)] for p, c in ((made.points, made.cells), (added.points, added.cells))]
    order = [np.lexsort(np.round(each, 9).T) for each in places]
    np.testing.assert_allclose(places[0][order[0]], places[1][order[1]], rtol=0, atol=1e-14)


def test_neighbours_of_20_and_27_nodes_share_the_middle_of_their_face():
    """Two hexahedra on a row: the one that lacks the middle of the face takes that of the other."""
    kind = KINDS["hexahedron27"]
    at = np.concatenate([kind.reference, kind.reference + np.array([1.0, 0.0, 0.0])])
    points, rows = np.unique(at, axis=0, return_inverse=True)
    first, second = rows.reshape(2, 1, 27)
    blocks = [
        block("whole", "hexahedron27", np.array([1]), first),
        block("fewer", "hexahedron20", np.array([2]), second[:, :20]),
    ]
    used = np.union1d(first, second[:, :20])
    every, full = completed(points[used], [renumbered(each, used) for each in blocks])
    assert len(every) == len(points)
    nodes = np.concatenate([each.nodes for each in full])
    assert len(np.intersect1d(*nodes)) == 9
    np.testing.assert_allclose(every[nodes], at.reshape(2, 27, 3), atol=1e-15)


def renumbered(elements, used):
    return replace(elements, nodes=np.searchsorted(used, elements.nodes))
