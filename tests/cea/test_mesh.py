"""Meshes as plain arrays: the order of nodes, facets in any order, refusals."""

import numpy as np
import pytest

from cea.errors import InputError
from cea.mesh import DIMENSION, Mesh, facet_nodes, reference_nodes

SQUARE = [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0], [2, 1]]
"""Two unit squares side by side."""
PAIR = {
    "cell": "quadrilateral",
    "order": 1,
    "points": SQUARE,
    "cells": [[0, 1, 2, 3], [2, 3, 4, 5]],
    "surfaces": {"bottom": [[0, 2], [2, 4]], "left": [[0, 1]]},
}
EVERY = [(cell, order) for cell in DIMENSION for order in (1, 2, 3, 4)]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"cell": "prism"}, "cell"),
        ({"order": 5}, "order"),
        ({"points": [[*x, 0] for x in SQUARE]}, "points"),
        ({"points": [*SQUARE[:5], [2, np.nan]]}, "points"),
        ({"order": 2}, "cells"),
        ({"cell": "triangle"}, "cells"),
        ({"cells": [[0.0, 1.0, 2.0, 3.0]]}, "cells"),
        ({"cells": [[0, 1, 2, 3], [2, 3, 4, -1]]}, "cells"),
        ({"surfaces": {"bottom": [[0, 2]], "top": [[1, 3, 5]]}}, "surfaces['top']"),
        ({"surfaces": {"bottom": [[0, 2]], "top": [[1, 5]]}}, "surfaces['top']"),
        ({"surfaces": {"bottom": [[0, 2]], "joint": [[2, 3]]}}, "surfaces['joint']"),
        ({"surfaces": {"bottom": [[0, 2], [2, 4], [2, 0]]}}, "surfaces['bottom']"),
        ({"surfaces": {"floor": [[2, 0]], "bottom": [[0, 2]]}}, "surfaces['floor']"),
    ],
)
def test_wrong_arrays_are_refused_by_name(change, field):
    with pytest.raises(InputError) as refused:
        Mesh(**PAIR | change)
    assert refused.value.field == field


@pytest.mark.parametrize(("cell", "order"), EVERY)
def test_facets_may_list_their_nodes_in_any_order(cell, order):
    nodes = reference_nodes(cell, order)
    whole = np.arange(len(nodes))[None]
    rng = np.random.default_rng(2)
    for facet in facet_nodes(cell, order):
        mesh = Mesh(cell, order, nodes, whole, {"side": rng.permutation(facet)[None]})
        assert np.array_equal(mesh.surfaces["side"], facet[None])
