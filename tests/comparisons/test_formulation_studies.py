"""Studies of formulations: locking, patch tests between meshes of any kind, pairings."""

from functools import cache
from itertools import product
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from cea.contact.formulations import Mortar, Segments
from cea.timing import StageTimer
from comparisons import agreement, locking, patch_tests
from comparisons.patch_tests import PRESSURE, PROBLEMS
from comparisons.study.run import run
from scenes import run_scene
from scenes.building.build import build_bodies

YARDSTICKS = ("segments", "mortar")


def made(study, only=None, **options):
    """Result of cases of a study with these options."""
    return run(study, study.options(**options), Path(mkdtemp()) / "out", only=only)


@cache
def few_locking(backend):
    options = {"p": (1.0, 1e6), "formulations": ("Greville", *YARDSTICKS)}
    return made(locking.STUDY, {"backend": backend}, **options)


def patch_test(interface, only=None):
    """An interface with a few formulations."""
    few = ("Greville", "GPTS 5", *YARDSTICKS)
    options = {"P": (1e6, 1e14), "gauss": (5,), "samples": 9, "formulations": few}
    options |= {"meshes": ("hexahedra", "quadrilaterals", "NURBS"), "interfaces": (interface,)}
    return made(patch_tests.STUDY, only, **options)


def errors(backend, formulation):
    """Errors of locking."""
    rows = few_locking(backend).frame()
    return rows.loc[rows["formulation"] == formulation, "error"].to_numpy(dtype=float)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("backend", "expected"), [("iga", [9.4e-5, 3.85e-2]), ("fe", [8.4e-5, 8.1e-3])]
)
def test_segments_lock_and_mortar_does_not(backend, expected):
    """Of NURBS the eigenvalue nearest to the sixth at p = 1e6 is the fifth, 3e-2 away."""
    segments, mortar = (errors(backend, each) for each in YARDSTICKS)
    np.testing.assert_allclose(segments, expected, rtol=0.03)
    np.testing.assert_allclose(mortar, expected[0], rtol=0.02)


def test_what_locks_is_told_and_as_many_points_as_traces_do_not():
    assert locking.locked(few_locking("iga")) == {"iga": ["segments"]}
    np.testing.assert_allclose(errors("iga", "Greville"), [7.9e-5, 9.4e-5], rtol=0.03)
    greville = few_locking("iga").frame().query("formulation == 'Greville'")
    assert set(greville["points"]) == set(greville["traces"]) == {14}


def test_yardsticks_pass_and_points_do_not():
    frame = patch_tests.runs(patch_test("flat", {"a": "NURBS"}))
    assert frame["meshes"].nunique() == 2
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
    frame = patch_tests.runs(patch_test("curved")).query("formulation == 'mortar'")
    nurbs, lagrange = (
        frame[frame["meshes"] == f"{kind} on {kind}"] for kind in ("NURBS", "quadrilaterals")
    )
    assert lagrange["own_error"].max() < 1e-12
    assert nurbs["error"].max() < 4 * nurbs["own_error"].max() < 5e-5
    assert (lagrange["error"].to_numpy() > 10 * nurbs["error"].to_numpy()).all()
    assert lagrange["error"].max() < 1e-3


FLAT, ROTATED, CURVED = (
    next(problem for problem in PROBLEMS if problem.name == name)
    for name in ("flat", "rotated", "curved")
)


@pytest.mark.convergence
@pytest.mark.parametrize(
    ("meshes", "backend", "order", "bound"),
    [("quadrilaterals", "fe", 3.0, 7e-4), ("NURBS", "iga", 3.9, 4e-5)],
)
def test_error_on_curved_interfaces_falls_with_the_mesh(meshes, backend, order, bound):
    """As the gap between arcs of degree 2, of order 3; or as the quadrature of NURBS."""
    worst = []
    for k in (1, 2, 4):
        around = {"upper": 3 * k, "lower": 5 * k}
        refined = [f"bodies.{b}.mesh.{backend}.elements=[{k}, {n}]" for b, n in around.items()]
        result = run_scene(CURVED.scene((meshes, meshes), 1e6, refined))
        sides = result.stresses["interface"].values()
        worst.append(max(np.abs(side.sigma_n / PRESSURE + 1).max() for side in sides))
    assert np.polyfit([0, 1, 2], -np.log2(worst), 1)[0] == pytest.approx(order, abs=0.1)
    assert worst[0] < bound


KINDS = ("hexahedra", "tetrahedra", "NURBS")
APART = "bodies.upper.placement={translation=[0.0, 0.0, 0.05]}", "contacts.interface.reach=0.06"
WHERE = {
    "flat": (FLAT, ()),
    "rotated": (ROTATED, ()),
    "offset": (FLAT, APART),
    "matching": (FLAT, [f"bodies.upper.mesh.{kind}.elements=[5, 5, 1]" for kind in ("fe", "iga")]),
}
PAIRS = sorted(product(KINDS, KINDS), key=lambda pair: pair[0] == pair[1])
CASES = [
    *((*pair, where) for pair in PAIRS for where in ("flat", "rotated", "offset")),
    *((kind, kind, "matching") for kind in ("hexahedra", "NURBS")),
]


def worst_error(pair, where, P, formulations, form="penalty"):
    """Largest relative error of the normal stress of some formulations; bodies are built once."""
    problem, more = WHERE[where]
    scene = problem.scene(pair, P, [*more, f"contacts.interface.form='{form}'"])
    bodies = build_bodies(scene, StageTimer())
    changed = [scene.change("contacts.interface.formulation", each) for each in formulations]
    results = [run_scene(each, bodies=bodies) for each in changed]
    sides = [side for result in results for side in result.stresses["interface"].values()]
    return max(np.abs(side.sigma_n / -PRESSURE - 1).max() for side in sides)


@pytest.mark.grid
@pytest.mark.parametrize(("a", "b", "where"), CASES)
def test_exact_integration_passes(a, b, where):
    assert worst_error((a, b), where, 1e6, (Segments(), Mortar())) < 1e-10


@pytest.mark.grid
@pytest.mark.parametrize("P", [1e2, 1e20, float("inf")])
@pytest.mark.parametrize("pair", [("tetrahedra", "NURBS"), ("NURBS", "hexahedra")])
def test_in_the_saddle_form_at_any_stiffness(pair, P):
    assert worst_error(pair, "rotated", P, (Mortar(),), "saddle") < 1e-8


# Both backends beside each other: pairs of unstable modes.


@pytest.mark.parametrize(
    ("formulation", "count"), [("GPTS", 2), pytest.param("mortar", 4, marks=pytest.mark.slow)]
)
def test_pairings_find_the_same_unstable_mode_and_its_shapes_are_kept(formulation, count):
    study = agreement.STUDY
    overrides = (*study.quick["overrides"], "analysis.max_frequency=7000.0")
    beside = made(study, {"formulation": formulation}, overrides=overrides)
    unstable = agreement.unstable(beside)
    assert unstable["run"].nunique() == count
    assert (unstable["growth"] > 0).all()
    modes = [case["shapes"]["modes"].items() for case in beside.cases]
    assert set(unstable["shape"]) <= {
        f"{k}/{m}" for each in modes for k, found in each for m in found
    }
    runs = beside.frame()
    assert runs["complete"].all()
    assert (runs["found"] > 10).all()
    pairs = beside.frame("agreement")
    assert len(pairs) == count - 1
    assert (pairs["modal_assurance"] > 0.99).all()
    # The disc decides: these meshes of it are coarse, and of both backends far apart.
    bounds = [2e-2 if "on NURBS," in c else 1e-3 for c in pairs["compared"]]
    assert (pairs["frequency_change"].abs() < bounds).all()
