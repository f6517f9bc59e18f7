"""Boxes divided into simplices: neighbours fit, volumes and surfaces stay."""

import numpy as np
import pytest
from gmsh_models import assert_outer_facets_are_named, volumes

from cea.errors import InputError
from cea.mesh import Mesh
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring, RingSector, Sector
from meshes.structured import divided

SHAPES = {
    shape.shape: shape
    for shape in (
        Box((0.3, 0.2, 0.1)),
        Annulus(0.5, 1.0, 0.0, 0.3),
        Sector(0.5, 1.0, -25.0, 60.0, 0.0, 0.3),
        Hub(0.2, 0.5, 1.0, 0.0, 0.2, -0.1, 0.4),
        Disc(1.0, 0.1, 0.3),
        Rectangle((0.3, 0.2)),
        Ring(0.5, 1.0),
        RingSector(0.5, 1.0, -25.0, 60.0),
    )
}


def boxes(shape, order):
    dim = len(shape.directions)
    cell = {2: "quadrilateral", 3: "hexahedron"}[dim]
    return shape_mesh(shape, cell, order, breaks=breaks_of(shape, (3, 12, 4)[:dim]))


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("name", SHAPES)
def test_simplices_of_every_shape_fit_and_fill_it(name, order):
    whole = boxes(SHAPES[name], order)
    parts = divided(whole)
    many = {2: 2, 3: 6}[whole.dim]
    assert parts.is_simplex
    assert len(parts.cells) == many * len(whole.cells)
    assert np.array_equal(parts.points, whole.points)
    assert np.array_equal(np.unique(parts.cells), np.unique(whole.cells))
    for surface, facets in whole.surfaces.items():
        assert len(parts.surfaces[surface]) == (whole.dim - 1) * len(facets)
    assert_outer_facets_are_named(parts)
    # A bilinear map is a polynomial of degree 1 on neither half: only their sum is the same.
    each = volumes(parts).reshape(-1, many).sum(axis=1)
    rel = 1e-12 if order == 1 or "radius" not in str(SHAPES[name]) else 2e-2
    np.testing.assert_allclose(each, volumes(whole), rtol=rel)


def test_a_twisted_ring_of_hexahedra_is_refused():
    """Half a turn on the way around: edges across come back the other way."""
    n = 5
    layers = np.arange(4 * n).reshape(n, 4)
    after = np.vstack([layers[1:], layers[:1, ::-1]])
    twisted = Mesh("hexahedron", 1, np.zeros((4 * n, 3)), np.hstack([layers, after]), {})
    with pytest.raises(InputError, match="parallel edges") as refused:
        divided(twisted)
    assert (refused.value.field, refused.value.value) == ("cells", "5 of 5 hexahedra")
    after[-1] = layers[0]
    straight = Mesh("hexahedron", 1, np.zeros((4 * n, 3)), np.hstack([layers, after]), {})
    assert len(divided(straight).cells) == 6 * n
