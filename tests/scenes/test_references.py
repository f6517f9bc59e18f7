"""Scenes with known eigenvalues on both backends, in every formulation; orders of convergence."""

import numpy as np
import pytest
from blocks import FORMULATIONS
from covering import covering
from reference_data import (
    BLOCK_BODIES,
    DRUM_BODIES,
    both_signs,
    compare,
    eigenvalues,
    exact,
    plane_meshes,
    solve,
    stored,
)

from exact_cea.reference import exact_eigenvalues, whole_spectrum

BOUNDS = {
    ("fe", "collocation"): 8e-3,
    ("fe", "weighted collocation"): 5e-4,
    ("fe", "grid"): 5e-3,
    ("iga", "collocation"): 2e-2,
    ("iga", "weighted collocation"): 8e-4,
    ("iga", "grid"): 5e-3,
}
"""Relative errors allowed on the meshes of the scenes; 4e-5 otherwise.

The largest belong to modes of the blocks near a coalescence, where errors go by their square root.
"""
HIGHEST = {"drum": 2.7, "blocks": 2.9}
BACKENDS = ("fe", "iga")
slow = pytest.mark.slow


def worst_error(scene, overrides, backend=None, highest=None):
    """Largest relative error of the lowest eigenvalues, all of which are found."""
    top = highest or HIGHEST[scene]
    modes, values = solve(scene, top, overrides, backend), exact(scene, HIGHEST[scene])
    found = compare(modes, values, top)
    assert [*found.missing, *found.spurious] == []
    return found.errors.max()


def formulated(formulation, **fields):
    """Overrides of the contact, a formulation as plain data among them."""
    inside = ", ".join(f"{name} = {value!r}" for name, value in formulation.items())
    fields["formulation"] = f"{{{inside}}}".replace("True", "true")
    return [f"contacts.interface.{name}={value}" for name, value in fields.items()]


@pytest.mark.parametrize(
    ("scene", "backend", "formulation"),
    covering(("blocks", "drum"), BACKENDS, FORMULATIONS, strength=1),
    indirect=["formulation"],
)
def test_every_formulation_finds_the_exact_spectrum(scene, backend, formulation, request):
    if formulation["method"] == "grid" and backend == "iga":  # as dense on a patch as on elements
        formulation = formulation | {"points": 40}
    kind = request.node.callspec.params["formulation"]
    error = worst_error(scene, formulated(formulation), backend)
    assert error < BOUNDS.get((backend, kind), 4e-5)


@pytest.mark.parametrize(
    ("scene", "backend", "full_pass"),
    covering(("drum", "blocks"), BACKENDS, ("false", "true"), strength=1),
)
def test_lumped_blocks_cost_accuracy_on_splines_only(scene, backend, full_pass):
    """Splines of a side overlap more widely than its points resolve: lumping widens contact."""
    lumped = {"method": "gpts", "points": 6, "lumped": True}
    error = worst_error(scene, formulated(lumped, full_pass=full_pass), backend)
    assert error < {"fe": 1e-4, "iga": 3e-2}[backend]


@pytest.mark.parametrize(
    ("method", "scene", "side_a"),
    covering(("gpts", "segments", "mortar"), ("blocks", "drum"), BACKENDS, strength=1),
)
def test_a_nurbs_body_on_a_lagrange_body_both_ways_round(scene, side_a, method):
    a, b = {"drum": DRUM_BODIES, "blocks": BLOCK_BODIES}[scene]
    side_b = {"fe": "iga", "iga": "fe"}[side_a]
    formulation = {"method": method} | ({"points": 6} if method == "gpts" else {})
    backends = [f"bodies.{a}.backend='{side_a}'", f"bodies.{b}.backend='{side_b}'"]
    assert worst_error(scene, [*backends, *formulated(formulation)]) < 4e-5


@slow
def test_the_drum_in_space(backend):
    """Below 2.1 live plane strain and one wave along z."""
    highest = 2.05
    beyond = 1.02 * highest
    values = [whole_spectrum("drum", max_frequency=beyond, p=1, mu="0.7").values]
    for entry in stored("drum_3d"):
        if entry["p"] == "1":
            values.append(both_signs(eigenvalues(entry), entry["m"]))
    for m in (0, 4, 5):
        one = exact_eigenvalues("drum", m=m, kz="pi", mu="0.7", max_frequency=beyond)
        values.append(both_signs(one, m))
    found = compare(solve("drum_3d", highest, backend=backend), np.concatenate(values), highest)
    assert [*found.missing, *found.spurious] == []
    assert found.errors.max() < {"fe": 5e-3, "iga": 5e-4}[backend]


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=slow), "iga"])
def test_the_blocks_in_space(backend):
    """Plane strain and one wave along z, each with its own exact list."""
    highest = 2.0
    modes = solve("blocks_3d", highest, backend=backend)
    for entry in stored("blocks_sine_mu"):
        if (entry["p"], entry["mu0"]) == ("1", "0.7"):
            found = compare(modes, eigenvalues(entry), highest)
            assert not len(found.missing)
            assert found.errors.max() < {"fe": 4e-3, "iga": 7e-4}[backend]


# Elements grow with n in every direction and never match across the contact. The solution of the
# drum varies fastest along r at its inner rim, where coarse elements hide the order.
MESHES = {
    ("drum", "fe"): {"outer": [2, 12], "inner": [4, 8]},
    ("drum", "iga"): {"outer": [2, 24], "inner": [4, 20]},
    ("blocks", "fe"): {"upper": [8, 2], "lower": [5, 3]},
    ("blocks", "iga"): {"upper": [10, 2], "lower": [7, 3]},
}
QUICK = (("drum", "iga", 2), ("blocks", "fe", 2))
ORDERS = [
    ("drum", "fe", 1, (3, 4, 6), 5e-3),
    ("drum", "fe", 2, (2, 3, 4), 2e-5),
    ("drum", "fe", 3, (2, 3, 4), 4e-8),
    ("drum", "fe", 4, (1, 2, 3), 4e-10),
    ("drum", "iga", 2, (2, 3, 4), 5e-6),
    ("drum", "iga", 3, (2, 3, 4), 1e-8),
    ("drum", "iga", 4, (2, 3, 4), 3e-11),
    ("blocks", "fe", 1, (4, 6, 8), 4e-3),
    ("blocks", "fe", 2, (2, 3, 4), 4e-5),
    ("blocks", "fe", 3, (1, 2, 3), 4e-7),
    ("blocks", "fe", 4, (1, 2, 3), 1e-9),
    ("blocks", "iga", 2, (3, 4, 5), 2e-5),
    ("blocks", "iga", 3, (3, 4, 5), 6e-8),
    ("blocks", "iga", 4, (5, 6, 7), 2e-11),
]


@pytest.mark.convergence
@pytest.mark.parametrize(
    ("scene", "backend", "degree", "refinements", "bound"),
    [pytest.param(*row, marks=() if row[:3] in QUICK else slow) for row in ORDERS],
)
def test_order_is_twice_the_degree(scene, backend, degree, refinements, bound):
    """Of mortar contact."""
    errors = []
    for n in refinements:
        elements = {name: [n * k for k in each] for name, each in MESHES[scene, backend].items()}
        meshes = plane_meshes(backend, degree, elements)
        errors.append(worst_error(scene, meshes, backend, {"drum": 2.0, "blocks": 2.9}[scene]))
    order = -np.polyfit(np.log(refinements), np.log(errors), 1)[0]
    assert order == pytest.approx(2 * degree, abs=0.2)
    assert errors[-1] < bound
