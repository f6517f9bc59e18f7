"""Bounds of the field of values by what lies near contacts."""

from copy import deepcopy
from unittest.mock import patch

import numpy as np
import pytest
from blocks import assemble, two_blocks
from mpi import on_ranks

from cea.eigen.driver import EigenSolver
from cea.eigen.field_of_values import field_of_values
from cea.eigen.krylov_schur import KrylovOptions
from cea.system import coupled, near_contacts

pytestmark = pytest.mark.mpi
END = 2 * np.pi  # rad/s


def sliding_blocks(backend, form, covered):
    """A block that slides on another, or between two of them, without friction on the upper.

    That contact reaches dofs farther away than the other.
    """
    data = two_blocks(backend, {"method": "gpts", "points": 3}, held=True, P=30.0, form=form)
    bodies = data["bodies"]
    bodies["lower"]["geometry"] |= {"size": [1.0, 1.1, 1.6], "origin": [0.0, 0.0, -1.2]}
    large = {"lower": [3, 3, 5]}
    if covered:
        bodies["upper"]["supports"] = [{"surface": "x_min"}]
        bodies["cover"] = deepcopy(bodies["lower"]) | {"supports": []}
        bodies["cover"]["geometry"]["origin"] = [0.0, 0.0, 0.7]
        above = {"a": "upper.z_max", "b": "cover.z_min", "mu": 0.0, "P": 1e3}
        data["contacts"]["above"] = data["contacts"]["interface"] | above
        large = {"lower": [2, 2, 4], "cover": [2, 2, 2]}
    for name, elements in large.items():
        for mesh in bodies[name]["mesh"].values():
            mesh["elements"] = elements
        bodies[name]["mesh"]["fe"]["degree"] = 1
    return assemble(data)


def facts(backend, form, covered):
    """Slopes of the cones of a part and of the whole, and eigenvalues where the part counts."""
    with patch.object(coupled, "_LARGE", 0), patch.object(near_contacts, "_NEAR", 0.4):
        pencil = sliding_blocks(backend, form, covered).pencil()
        whole = pencil.at()
        near = whole.near(whole)
        slopes = [field_of_values(part, END**2, cone=True) for part in (near, whole)]
        with EigenSolver(pencil, KrylovOptions(dense_limit=0)) as driver:
            modes = driver.solve(0.5 if covered else 1.0)
    values = modes.eigenvalues
    return {
        "sizes": [near.size, whole.size],
        "slopes": slopes,
        "complete": modes.window.complete,
        "re": values.real.tolist(),
        "im": values.imag.tolist(),
    }


@pytest.mark.parametrize(
    ("backend", "form", "covered"),
    [("fe", "penalty", False), ("iga", "penalty", True), ("iga", "saddle", False)],
)
def test_the_cone_of_the_part_near_contacts_holds_that_of_the_whole(backend, form, covered):
    found = facts(backend, form, covered)
    near, whole = found["slopes"]
    assert found["sizes"][0] < 0.8 * found["sizes"][1]
    assert whole < near < 3 * whole
    assert found["complete"]
    if backend == "iga":
        return
    again = on_ranks(2, facts, backend, form, covered)
    assert again["sizes"] == found["sizes"]
    assert again["slopes"] == pytest.approx(found["slopes"], rel=0.1)  # other random vectors
    assert again["im"] == pytest.approx(found["im"], rel=1e-9)
    assert again["re"] == pytest.approx(found["re"], abs=1e-6)


@pytest.mark.parametrize("change", ["springs", "far contact"])
def test_there_is_no_bound_where_it_would_not_hold(change):
    """Springs are no integral over the body; contact points beyond the distance are not near."""
    with patch.object(coupled, "_LARGE", 0):
        data = two_blocks("fe", {"method": "gpts", "points": 3}, P=30.0)
        if change == "springs":
            data["bodies"]["upper"]["springs"] = [
                {"surface": "z_max", "stiffness": [1.0, 1.0, 1.0]}
            ]
        whole = assemble(data).pencil().at()
        with patch.object(near_contacts, "_NEAR", 0.0 if change == "far contact" else 0.25):
            assert whole.near(whole) is None
