"""Scenes of problems with known eigenvalues, on both backends and in every formulation."""

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

HIGHEST = {"drum": 2.7, "blocks": 2.9, "blocks_constant_mu": 2.9}
BACKENDS = ("fe", "iga")
slow = pytest.mark.slow


def overrides(**fields):
    return [f"contacts.interface.{name}={value}" for name, value in fields.items()]


def toml(formulation):
    fields = (
        f"{name} = {value!r}" if isinstance(value, str) else f"{name} = {value}"
        for name, value in formulation.items()
    )
    return f"{{{', '.join(fields)}}}"


def fine_enough(formulation, backend):
    """Formulations as they come, but a grid that is as dense on a patch as on its elements."""
    if formulation["method"] == "grid" and backend == "iga":
        return formulation | {"points": 40}
    return formulation


@pytest.mark.parametrize(
    ("scene", "backend", "formulation"),
    covering(("blocks", "drum"), BACKENDS, FORMULATIONS),
    indirect=["formulation"],
)
def test_every_formulation_finds_the_exact_spectrum(scene, backend, formulation, request):
    highest = HIGHEST[scene]
    kind = request.node.callspec.params["formulation"]
    chosen = toml(fine_enough(formulation, backend))
    found = compare(
        solve(scene, highest, overrides(formulation=chosen), backend),
        exact(scene, highest),
        highest,
    )
    assert found.complete
    assert found.errors.max() < BOUNDS.get((backend, kind), 4e-5)


@pytest.mark.parametrize(
    ("scene", "backend", "full_pass"), covering(("drum", "blocks"), BACKENDS, ("false", "true"))
)
def test_lumped_blocks_cost_accuracy_on_splines_only(scene, backend, full_pass):
    """Splines of a side overlap more widely than its points resolve: lumping widens contact."""
    fields = {"formulation": "{method = 'gpts', points = 6, lumped = true}"}
    found = compare(
        solve(scene, HIGHEST[scene], overrides(full_pass=full_pass, **fields), backend),
        exact(scene, HIGHEST[scene]),
        HIGHEST[scene],
    )
    assert found.complete
    assert found.errors.max() < {"fe": 1e-4, "iga": 3e-2}[backend]


@pytest.mark.parametrize(
    ("method", "scene", "side_a"),
    covering(("gpts", "segments", "mortar"), ("blocks", "drum"), BACKENDS),
)
def test_a_nurbs_body_on_a_lagrange_body_both_ways_round(scene, side_a, method):
    other = {"fe": "iga", "iga": "fe"}[side_a]
    bodies = {"drum": DRUM_BODIES, "blocks": BLOCK_BODIES}[scene]
    backends = [
        f"bodies.{name}.backend='{b}'" for name, b in zip(bodies, (side_a, other), strict=True)
    ]
    formulation = "{method='gpts', points=6}" if method == "gpts" else f"{{method='{method}'}}"
    found = compare(
        solve(scene, HIGHEST[scene], [*backends, *overrides(formulation=formulation)]),
        exact(scene, HIGHEST[scene]),
        HIGHEST[scene],
    )
    assert found.complete
    assert found.errors.max() < 4e-5


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
    assert found.complete
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
