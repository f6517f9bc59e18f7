"""Fixtures shared by all tests: each backend, each formulation, each placement."""

import pytest
from blocks import ROTATED

import cea.petsc  # noqa: F401  (ahead of anything that imports PETSc, MPI or dolfinx)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Where workers share the tests, those of a file keep to one, which then shares its fixtures.

    Programs on several ranks keep to one worker too: two at a time would wait for each other's
    cores.
    """
    for item in items:
        group = "mpi" if item.get_closest_marker("mpi") else item.nodeid.split("::")[0]
        item.add_marker(pytest.mark.xdist_group(group))


@pytest.fixture(params=["fe", "iga"])
def backend(request):
    """Each backend."""
    return request.param


@pytest.fixture(
    params=["collocation", "weighted collocation", "grid", "gpts", "segments", "mortar"]
)
def formulation(request, backend):
    """Each formulation, collocation in the manner of the backend."""
    return {
        "collocation": {"method": {"fe": "node_to_surface", "iga": "greville"}[backend]},
        "weighted collocation": {
            "fe": {"method": "node_to_surface", "weights": "tributary"},
            "iga": {"method": "botella", "weights": "area"},
        }[backend],
        "grid": {"method": "grid", "points": 5},
        "gpts": {"method": "gpts", "points": 4},
        "segments": {"method": "segments"},
        "mortar": {"method": "mortar"},
    }[request.param]


@pytest.fixture(params=["axis-aligned", "rotated"])
def placement(request):
    """Along the axes, and rotated."""
    return {} if request.param == "axis-aligned" else ROTATED
