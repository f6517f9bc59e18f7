"""Studies of formulations: locking, patch tests, momentum."""

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from comparisons.formulations import locking, patch_tests
from comparisons.formulations.patch_tests import PRESSURE, PROBLEMS
from comparisons.formulations.study import STUDY, Options
from comparisons.study.run import run
from scenes import run_scene

YARDSTICKS = ("segments", "mortar")
QUICK = {
    "P": (1e2, 1e6, 1e14),
    "gauss": (5,),
    "samples": 9,
    "meshes": ("hexahedra", "quadrilaterals", "NURBS"),
}


def part(name, **options):
    """A part of the study run on its own."""
    return run(STUDY, Options(parts=(name,), **options), Path(mkdtemp()) / "out")


@cache
def few_locking():
    options = {"p": (1.0, 1e4, 1e6, np.inf), "formulations": ("Greville", *YARDSTICKS)}
    return part("locking", **options)


@cache
def patch_test(interface):
    """Flat interfaces with every formulation; curved ones with a few."""
    few = ("GPTS 5", "GPTS 5, lumped", *YARDSTICKS) if interface == "curved" else ()
    return part("patch_tests", interfaces=(interface,), formulations=few, **QUICK)


def errors(frame, **labels):
    for name, value in labels.items():
        frame = frame[frame[name] == value]
    return frame["error"].to_numpy(dtype=float)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("backend", "expected"), [("iga", [9.4e-5, 2.0e-3, 3.85e-2]), ("fe", [8.4e-5, 3.0e-4, 8.1e-3])]
)
def test_segments_lock_and_mortar_does_not(backend, expected):
    """Of NURBS the eigenvalue nearest to the sixth at p = 1e6 is the fifth, 3e-2 away."""
    finite = few_locking().frame("locking").query("p < inf")
    segments, mortar = (errors(finite, backend=backend, formulation=f) for f in YARDSTICKS)
    np.testing.assert_allclose(segments, expected, rtol=0.03)
    np.testing.assert_allclose(mortar, expected[0], rtol=0.02)


def test_what_locks_is_told():
    """Of both backends segments, and no formulation with as many points as traces."""
    assert locking.locked(few_locking()) == {"fe": ["segments"], "iga": ["segments"]}


def test_as_many_points_as_traces_do_not_lock():
    greville = few_locking().frame("locking").query("formulation == 'Greville' and p < inf")
    np.testing.assert_allclose(greville["error"], [7.9e-5, 9.4e-5, 9.4e-5], rtol=0.03)
    assert set(greville["points"]) == set(greville["traces"]) == {14}


def test_yardsticks_pass_and_points_do_not():
    frame = patch_tests.runs(patch_test("flat"))
    for (_, formulation), own in frame.groupby(["meshes", "formulation"]):
        (error,) = own.loc[own["P"] == 1e6, "error"]
        if formulation in YARDSTICKS:
            assert own["passed"].all(), own
            assert error < 1e-10
        else:
            # Quadrature across cells of b goes wrong until contact is stiffer than the blocks.
            assert error > 4e-3, own


@pytest.mark.slow
def test_curved_interfaces_need_the_same_geometry_on_both_sides():
    """NURBS pass within their own quadrature; chords and arcs of Lagrange meshes leave gaps."""
    frame = patch_tests.runs(patch_test("curved"))
    nurbs, lagrange = (
        frame[(frame["meshes"] == f"{m} on {m}") & (frame["formulation"] == "mortar")]
        for m in ("NURBS", "quadrilaterals")
    )
    assert lagrange["own_error"].max() < 1e-12
    assert nurbs["error"].max() < 4 * nurbs["own_error"].max() < 5e-5
    assert (lagrange["error"].to_numpy() > 10 * nurbs["error"].to_numpy()).all()
    assert lagrange["error"].max() < 1e-3


@pytest.mark.convergence
@pytest.mark.parametrize(
    ("meshes", "backend", "order"), [("quadrilaterals", "fe", 3.0), ("NURBS", "iga", 3.9)]
)
def test_error_on_curved_interfaces_falls_with_the_mesh(meshes, backend, order):
    """As the gap between arcs of degree 2, of order 3; or as the quadrature of NURBS."""
    (curved,) = [problem for problem in PROBLEMS if problem.name == "curved"]
    worst = []
    for k in (1, 2, 4):
        refined = [
            f"bodies.upper.mesh.{backend}.elements=[{k}, {3 * k}]",
            f"bodies.lower.mesh.{backend}.elements=[{k}, {5 * k}]",
        ]
        result = run_scene(curved.scene((meshes, meshes), 1e6, refined))
        sides = result.stresses["interface"].values()
        worst.append(max(np.abs(side.sigma_n / PRESSURE + 1).max() for side in sides))
    assert np.polyfit([0, 1, 2], -np.log2(worst), 1)[0] == pytest.approx(order, abs=0.1)
    assert worst[0] < {"fe": 7e-4, "iga": 4e-5}[backend]


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("interface", ["flat", "curved"])
def test_momentum(interface):
    """Linear momentum is kept by all; angular too, but by lumping and by friction across gaps."""
    for row in patch_tests.runs(patch_test(interface), "momentum").to_dict("records"):
        assert max(row["linear_normal"], row["linear_friction"]) < 1e-14
        if "lumped" in row["formulation"]:
            assert min(row["angular_normal"], row["angular_friction"]) > 1e-4
            continue
        assert row["angular_normal"] < 1e-9
        gaps = interface == "curved" and row["meshes"] != "NURBS on NURBS"
        assert row["angular_friction"] < (1e-4 if gaps else 1e-13)
