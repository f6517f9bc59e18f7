"""Layers around edges: cells fit, fill the shape, keep its names, and grow small at edges alone."""

import pytest
from covering import covering
from gmsh_models import assert_outer_facets_are_named, volumes

from cea.errors import InputError
from meshes.breaks import RATIO, breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring, RingSector

ANNULUS = Annulus(0.5, 1.0, 0.0, 0.3)
ENDS = ({"r": 0.5, "z": 0.0}, {"r": 0.5, "z": 0.3})
DISC = Disc(1.0, 0.1, 0.3)
HUB = Hub(0.2, 0.5, 1.0, 0.0, 0.2, -0.1, 0.4)
CASES = {
    "both edges at one cell": (ANNULUS, (2, 6, 1), ENDS),
    "both edges, each at its cell": (ANNULUS, (2, 5, 2), ENDS),
    "outside and above": (ANNULUS, (1, 5, 1), ({"z": 0.3, "r": 0.5}, {"z": 0.3, "r": 1.0})),
    "re-entrant": (HUB, (3, 4, 4), ({"r": 0.5, "z": 0.0}, {"r": 0.5, "z": 0.2})),
    "rim": (DISC, (4, 8, 2), ({"r": 1.0, "z": 0.1}, {"r": 1.0, "z": 0.3})),
    "straight": (Box((0.3, 0.2, 0.1)), (2, 3, 2), ({"x": 0.3, "z": 0.0},)),
    "points": (Rectangle((0.3, 0.2)), (3, 2), ({"x": 0.1, "y": 0.2}, {"x": 0.3, "y": 0.0})),
    "on an arc": (RingSector(0.5, 1.0, -25.0, 60.0), (2, 5), ({"r": 1.0, "theta": 60.0},)),
    "round": (Ring(0.5, 1.0), (2, 8), ({"r": 0.5, "theta": 90.0},)),
}


def made(case, order, layers):
    shape, elements, edges = CASES[case]
    through = {name: [edge[name] for edge in edges if name in edge] for name in edges[0]}
    cell = {2: "quadrilateral", 3: "hexahedron"}[len(elements)]
    breaks = breaks_of(shape, elements, through)
    return shape_mesh(shape, cell, order, breaks=breaks, edges=edges, layers=layers)


@pytest.mark.parametrize(
    ("case", "order", "layers"), covering(tuple(CASES), (1, 2, 4), (1, 3), strength=1)
)
def test_cells_fit_and_fill_the_shape(case, order, layers):
    whole, parts = made(case, order, 0), made(case, order, layers)
    assert set(parts.surfaces) == set(whole.surfaces)
    assert_outer_facets_are_named(parts)
    before, after = volumes(whole), volumes(parts)
    # Across an edge in the plane of a circle the maps of the parts are other polynomials.
    curved = len(CASES[case][1]) == 2 and "radius" in str(CASES[case][0])
    rel = 1e-12 if not curved else {1: 3e-2, 2: 2e-3, 4: 1e-5}[order]
    assert after.sum() == pytest.approx(before.sum(), rel=rel)
    if not curved:
        # The smallest cell, at an edge, and the greatest, at none.
        assert 0.5 < after.min() / (RATIO ** (2 * layers) * before.min()) < 2.0
        assert after.max() <= before.max() * (1 + 1e-12)


@pytest.mark.parametrize(
    ("shape", "elements", "edges", "told"),
    [
        (ANNULUS, (1, 4, 1), ({"r": 0.5, "z": 0.0}, {"r": 1.0, "z": 0.3}), "more elements"),
        (ANNULUS, (1, 4, 1), (*ENDS, {"r": 1.0, "z": 0.3}), "more elements"),
        (ANNULUS, (2, 4, 1), (ENDS[0], {"r": 0.5, "theta": 0.0}), "along the same two"),
        # Inside of a disc its lattice turns into that of a square.
        (DISC, (4, 8, 2), ({"r": 0.5, "z": 0.1},), "r of the rim, and z"),
    ],
)
def test_edges_without_room_for_layers_are_refused(shape, elements, edges, told):
    breaks = breaks_of(shape, elements)
    with pytest.raises(InputError, match=told) as caught:
        shape_mesh(shape, "hexahedron", 1, breaks=breaks, edges=edges, layers=1)
    assert caught.value.field in ("elements", "edges")
