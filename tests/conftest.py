"""Fixtures shared by all tests: each backend, each formulation, each placement."""

import pytest
from blocks import FORMULATIONS, PLACEMENTS, ROTATED
from covering import mark_slow_cases
from matrix_files import read_here

import cea.petsc  # noqa: F401  (ahead of anything that imports PETSc, MPI or dolfinx)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Part of each grid is slow; the tests of a file keep to one worker, which shares its fixtures.

    Programs on several ranks come last and keep to one worker too, so that they have the cores for
    themselves: ranks that share one with other work wait for each other most of the time.
    """
    mark_slow_cases(items)
    items.sort(key=_on_several_ranks)
    for item in items:
        item.add_marker(pytest.mark.xdist_group(_group(item)))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_finish(session):
    """The end of a name tells pytest-xdist the group of a test.

    It writes that end itself, but its release 3.8 fails to on pytest 9.2 and later.
    """
    if session.config.getoption("loadgroup", default=False):
        for item in session.items:
            end = f"@{_group(item)}"
            if not item.nodeid.endswith(end):
                item._id = item.id.parse(item.nodeid + end)


def _group(item):
    return "mpi" if _on_several_ranks(item) else item.nodeid.split("::")[0]


def _on_several_ranks(item):
    return item.get_closest_marker("mpi") is not None


@pytest.fixture(scope="module")
def first_random_state(request):
    """State of a module's generator of random numbers before its tests, if it has one."""
    generator = getattr(request.module, "RNG", None)
    return None if generator is None else generator.bit_generator.state


@pytest.fixture(autouse=True)
def _same_random_numbers(request, first_random_state):
    """Each test draws the same numbers, whichever tests ran before it."""
    if first_random_state is not None:
        request.module.RNG.bit_generator.state = first_random_state


@pytest.fixture
def files_read_here(monkeypatch):
    """Files are read in this process, but by processes that a test starts."""
    for reader in ("meshes.files.ansys", "meshes.files.gmsh", "scenes.matrices.reading"):
        monkeypatch.setattr(f"{reader}.arrays_of", read_here)


@pytest.fixture(params=["fe", "iga"])
def backend(request):
    """Each backend."""
    return request.param


@pytest.fixture(params=FORMULATIONS)
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


@pytest.fixture(params=PLACEMENTS)
def placement(request):
    """Along the axes, and rotated."""
    return {} if request.param == "axis-aligned" else ROTATED
