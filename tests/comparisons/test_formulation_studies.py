"""Studies of formulations: locking, patch tests, momentum; their figures and tables."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from comparisons.formulations.figures import draw_locking
from comparisons.formulations.locking import LockingStudy, run_locking
from comparisons.formulations.patch_test_problems import PRESSURE, PROBLEMS
from comparisons.formulations.patch_tests import PatchTestStudy, run_patch_tests
from comparisons.formulations.tables import locking_table, patch_tests_table
from comparisons.kit.progress import Progress
from scenes.run import run_scene

QUIET = Progress(lambda step: None, lambda stage: None)
YARDSTICKS = ("segments", "mortar")


@cache
def locking():
    return run_locking(
        QUIET, LockingStudy(stiffnesses=(1.0, 1e4, 1e6), only=("Greville", *YARDSTICKS))
    )


@cache
def patch_tests(interface):
    """Every formulation; the rotated interface, tetrahedra and triangles whole in slow tests."""
    if interface == "rotated":
        return run_patch_tests(QUIET, ROTATED)
    return run_patch_tests(QUIET, replace(QUICK, problems=(interface,)))


QUICK = PatchTestStudy(
    stiffnesses=(1e2, 1e6, 1e14),
    gauss=(5,),
    samples=9,
    meshes=("hexahedra", "quadrilaterals", "NURBS"),
)
ROTATED = replace(
    QUICK,
    problems=("rotated",),
    stiffnesses=(1e6,),
    only=("Greville", "node-to-surface", "GPTS 5", "GPTS 5, lumped", *YARDSTICKS),
)


def errors(data, **labels):
    (found,) = [r["errors"] for r in data["runs"] if labels.items() <= r.items()]
    return np.array(found, dtype=float)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("backend", "expected"), [("iga", [9.4e-5, 2.0e-3, 3.85e-2]), ("fe", [8.4e-5, 3.0e-4, 8.1e-3])]
)
def test_segments_lock_and_mortar_does_not(backend, expected):
    """Of NURBS the eigenvalue nearest to the sixth at p = 1e6 is the fifth, 3e-2 away."""
    segments, mortar = (errors(locking(), backend=backend, formulation=f) for f in YARDSTICKS)
    np.testing.assert_allclose(segments, expected, rtol=0.03)
    np.testing.assert_allclose(mortar, expected[0], rtol=0.02)


def test_as_many_points_as_traces_do_not_lock():
    greville = errors(locking(), backend="iga", formulation="Greville")
    np.testing.assert_allclose(greville, [7.9e-5, 9.4e-5, 9.4e-5], rtol=0.03)
    (run,) = [r for r in locking()["runs"] if r["formulation"] == "Greville"]
    assert run["points"] == run["traces"] == 14


def test_tied_contact_is_the_limit_of_stiff_contact():
    for run in locking()["runs"]:
        if run["formulation"] != "segments":
            assert run["tied_error"] == pytest.approx(run["errors"][-1], rel=1e-2)
        else:
            assert run["tied_error"] > run["errors"][-1]


def test_locking_is_plain_data_drawn_and_tabulated(tmp_path):
    data = json.loads(json.dumps(locking(), allow_nan=False))
    file = draw_locking(data, tmp_path / "locking.png")
    assert file.stat().st_size > 10_000
    table = locking_table(data)
    assert len(table.rows) == len(data["runs"]) == 5
    table.write_csv(tmp_path)
    assert table.cells()[0][-1] != ""


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("interface", ["flat", "rotated"])
def test_yardsticks_pass_and_points_do_not(interface):
    data = patch_tests(interface)
    for run in data["runs"]:
        if run["formulation"] in YARDSTICKS:
            assert run["passes"] == data["P"], run
            assert run["errors"][data["P"].index(1e6)] < 1e-10
        else:
            # Quadrature across cells of b goes wrong until contact is stiffer than the blocks.
            assert run["errors"][data["P"].index(1e6)] > 4e-3, run


@pytest.mark.slow
def test_area_weights_are_better_than_equal_ones_at_low_stiffness():
    data = patch_tests("flat")
    for meshes, plain, weighted in (
        (["NURBS", "NURBS"], "Greville", "Greville, area"),
        (["NURBS", "NURBS"], "Botella", "Botella, area"),
        (["hexahedra", "hexahedra"], "node-to-surface", "node-to-surface, tributary"),
    ):
        even, shared = (errors(data, meshes=meshes, formulation=f) for f in (plain, weighted))
        assert shared[0] < 0.4 * even[0]
        # Where the gap is closed at every point, whatever the force, weights have no say.
        assert shared[2] == pytest.approx(even[2], rel=1e-3)


@pytest.mark.slow
def test_placement_changes_nothing_but_rounding():
    for run in patch_tests("rotated")["runs"]:
        if run["formulation"] not in YARDSTICKS:
            labels = {key: run[key] for key in ("meshes", "formulation")}
            (flat,) = errors(patch_tests("flat"), **labels)[[1]]
            assert run["errors"] == [pytest.approx(flat, rel=1e-5)], run


@pytest.mark.slow
def test_curved_interfaces_need_the_same_geometry_on_both_sides():
    """NURBS pass within their own quadrature; chords and arcs of Lagrange meshes leave gaps."""
    data = patch_tests("curved")
    nurbs = errors(data, meshes=["NURBS", "NURBS"], formulation="mortar")
    lagrange = errors(data, meshes=["quadrilaterals", "quadrilaterals"], formulation="mortar")
    own = {tuple(r["meshes"]): r["own_error"] for r in data["runs"]}
    assert own["quadrilaterals", "quadrilaterals"] < 1e-12
    assert nurbs.max() < 4 * own["NURBS", "NURBS"] < 5e-5
    assert (lagrange > 10 * nurbs).all()
    assert (lagrange < 1e-3).all()


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
@pytest.mark.parametrize("interface", ["flat", "rotated", "curved"])
def test_momentum(interface):
    """Linear momentum is kept by all; angular too, but by lumping and by friction across gaps."""
    for run in patch_tests(interface)["runs"]:
        momentum = run["momentum"]
        assert max(m["linear"] for m in momentum.values()) < 1e-14
        if "lumped" in run["formulation"]:
            assert min(m["angular"] for m in momentum.values()) > 1e-4
            continue
        assert momentum["normal"]["angular"] < 1e-9
        gaps = interface == "curved" and run["meshes"] != ["NURBS", "NURBS"]
        assert momentum["friction"]["angular"] < (1e-4 if gaps else 1e-13)


def test_patch_tests_are_plain_data_in_a_table(tmp_path):
    data = json.loads(json.dumps(patch_tests("curved"), allow_nan=False))
    table = patch_tests_table(data)
    assert len(table.rows) == len(data["runs"])
    passes = {(row[1], row[2]): row[-5] for row in table.rows}
    assert passes["NURBS on NURBS", "mortar"] == "every"
    assert passes["NURBS on NURBS", "GPTS 5"] == "10¹⁴"
    assert passes["quadrilaterals on quadrilaterals", "mortar"] == "none"
    table.write_csv(tmp_path)


@pytest.mark.slow
def test_rotated_interfaces_behave_as_flat_ones():
    rotated, flat = (
        run_patch_tests(QUIET, replace(QUICK, problems=(i,), stiffnesses=(1e2, 1e6)))["runs"]
        for i in ("rotated", "flat")
    )
    for here, there in zip(flat, rotated, strict=True):
        if here["formulation"] not in YARDSTICKS:
            np.testing.assert_allclose(there["errors"], here["errors"], rtol=1e-5)


@pytest.mark.slow
def test_simplices_behave_as_other_cells():
    data = run_patch_tests(
        QUIET, replace(QUICK, problems=("flat", "rotated"), meshes=("tetrahedra",))
    )
    for run in data["runs"]:
        assert (run["passes"] == data["P"]) == (run["formulation"] in YARDSTICKS), run
        assert max(m["linear"] for m in run["momentum"].values()) < 1e-14


@pytest.mark.slow
def test_locking_of_every_formulation():
    """Beyond every stiffness: what has few points does not lock, what has many does."""
    data = run_locking(QUIET, replace(LockingStudy(), stiffnesses=(1.0, 1e3, 1e6, 1e9)))
    locked = {
        (run["backend"], run["formulation"])
        for run in data["runs"]
        if run["errors"][-1] is None or run["errors"][-1] > 10 * run["errors"][0]
    }
    free = {"Greville", "Greville, area", "Botella", "Botella, area", "mortar"}
    assert {f for b, f in locked if b == "iga"}.isdisjoint(free)
    assert {f for b, f in locked if b == "fe"}.isdisjoint({"node-to-surface", "mortar"})
    for backend in ("fe", "iga"):
        assert (backend, "segments") in locked
        assert (backend, "GPTS 6") in locked
