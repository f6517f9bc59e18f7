"""Orders at which eigenvalues of mortar contact converge to the exact ones."""

import numpy as np
import pytest
from reference_data import compare, exact, plane_meshes, solve

pytestmark = pytest.mark.convergence
HIGHEST = {"drum": 2.0, "blocks": 2.9}

# Elements grow with n in every direction and never match across the contact. The solution of the
# drum varies fastest along r at its inner rim, where coarse elements hide the order.
MESHES = {
    ("drum", "fe"): lambda n: {"outer": [2 * n, 12 * n], "inner": [4 * n, 8 * n]},
    ("drum", "iga"): lambda n: {"outer": [2 * n, 24 * n], "inner": [4 * n, 20 * n]},
    ("blocks", "fe"): lambda n: {"upper": [8 * n, 2 * n], "lower": [5 * n, 3 * n]},
    ("blocks", "iga"): lambda n: {"upper": [10 * n, 2 * n], "lower": [7 * n, 3 * n]},
}


def worst_errors(scene, backend, degree, refinements, **options):
    """Largest relative error of the lowest eigenvalues on each mesh."""
    highest = HIGHEST[scene]
    values = exact(scene, highest)
    errors = []
    for n in refinements:
        meshes = plane_meshes(backend, degree, MESHES[scene, backend](n), **options)
        found = compare(solve(scene, highest, meshes, backend), values, highest)
        assert found.complete
        errors.append(found.errors.max())
    return errors


def order(refinements, errors):
    """Slope of the error over the mesh size."""
    return -np.polyfit(np.log(refinements), np.log(errors), 1)[0]


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("scene", "backend", "degree", "refinements", "bound"),
    [
        ("drum", "fe", 1, (3, 4, 6), 5e-3),
        ("drum", "fe", 2, (2, 3, 4), 2e-5),
        slow("drum", "fe", 3, (2, 3, 4), 4e-8),
        slow("drum", "fe", 4, (1, 2, 3), 4e-10),
        slow("drum", "iga", 2, (2, 3, 4), 5e-6),
        slow("drum", "iga", 3, (2, 3, 4), 1e-8),
        slow("drum", "iga", 4, (2, 3, 4), 3e-11),
        slow("blocks", "fe", 1, (4, 6, 8), 4e-3),
        slow("blocks", "fe", 2, (2, 3, 4), 4e-5),
        slow("blocks", "fe", 3, (1, 2, 3), 4e-7),
        slow("blocks", "fe", 4, (1, 2, 3), 1e-9),
        ("blocks", "iga", 2, (3, 4, 5), 2e-5),
        slow("blocks", "iga", 3, (3, 4, 5), 6e-8),
        slow("blocks", "iga", 4, (5, 6, 7), 2e-11),
    ],
)
def test_order_is_twice_the_degree(scene, backend, degree, refinements, bound):
    errors = worst_errors(scene, backend, degree, refinements)
    assert order(refinements, errors) == pytest.approx(2 * degree, abs=0.2)
    assert errors[-1] < bound
