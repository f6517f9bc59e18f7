"""Results are warned of where they should be, and easy scenes never."""

from functools import cache

import numpy as np
import pytest
from blocks import rectangle
from covering import covering

from comparisons.accuracy.problems import PROBLEMS
from comparisons.accuracy.study import STUDY, uses
from comparisons.study.result import read
from scenes import run_modes
from scenes.checking.warnings import _INCOMPRESSIBLE, point_rule, warnings_of
from scenes.running.system import coupled
from scenes.spec.reading import load_scene, read_scene


def told(scene):
    """Warnings of bodies and contacts by kind; nothing is solved."""
    system, _, _ = coupled(scene)
    return {
        warning.kind: warning.data for warning in warnings_of(scene, system.bodies, system.contacts)
    }


def blocks(backend, **changes):
    """The layers of the catalogue with quadratic elements, 12 on 13."""
    scene = load_scene("blocks", backend=backend)
    elements = {"upper": [12, 3], "lower": [13, 6]}
    mesh = {
        f"bodies.{name}.mesh": {
            "fe": {"cell": "quadrilateral", "degree": 2, "elements": each},
            "iga": {"degree": [2, 2], "elements": each},
        }
        for name, each in elements.items()
    }
    contact = {f"contacts.interface.{name}": value for name, value in changes.items()}
    return scene.change(mesh | contact)


@pytest.mark.parametrize(
    ("name", "backend"),
    covering(("blocks", "blocks_constant_mu", "drum"), ("fe", "iga"), strength=1),
)
def test_modes_of_the_catalogue_are_free_of_warnings(name, backend):
    assert run_modes(load_scene(name, backend=backend)).warnings == ()


def test_too_few_points_are_told_with_their_numbers(backend):
    found = told(blocks(backend, formulation={"method": "gpts", "points": 1}))["under-sampled"]
    traces = {"fe": {"upper": 25, "lower": 26}, "iga": {"upper": 14, "lower": 15}}[backend]
    assert (found["points"], found["functions"]) == (12, traces)  # one point lies on a node
    assert "under-sampled" not in told(blocks(backend, formulation={"method": "gpts", "points": 3}))


def test_too_many_points_are_told_where_they_lock():
    """Segments at p = 1e6 are off by 3 %, mortar is not."""
    frequencies = {}
    for method, warned in (("segments", {"over-constrained"}), ("mortar", set())):
        scene = blocks("iga", formulation={"method": method}, p=1e6, mu=0.0, form="saddle")
        result = run_modes(scene)
        assert {warning.kind for warning in result.warnings} == warned
        frequencies[method] = result.frequencies[:6]
    off = np.abs(frequencies["segments"] / frequencies["mortar"] - 1).max()
    assert 0.01 < off < 0.1


@pytest.mark.parametrize(("apart", "expected"), [(0.015, 0.015), (1e-4, None)])
def test_a_closed_gap_is_told_with_its_width(apart, expected):
    moved = {"bodies.upper.placement": {"translation": [0.0, apart, 0.0]}}
    found = told(blocks("iga", reach=0.05).change(moved)).get("gap-closed", {})
    assert found.get("distance") == (expected and pytest.approx(expected, rel=1e-9))


def cantilever(backend, degree, nu, elements=4):
    """A beam of length 4 and height 1 clamped at its end."""
    beam = rectangle(
        backend,
        [4.0, 1.0],
        [4 * elements, elements],
        degree=degree,
        material={"E": 1.0, "nu": nu, "rho": 1.0},
        supports=[{"surface": "x_min"}],
    )
    analysis = {"kind": "cea", "max_frequency": 0.5}
    return read_scene({"name": "cantilever", "bodies": {"beam": beam}, "analysis": analysis})


@cache
def exact_frequencies(nu):
    """The first three frequencies of the beam."""
    return run_modes(cantilever("iga", 6, nu, elements=8)).frequencies[:3]


def locking_error(backend, degree, nu):
    """Relative error of the first three frequencies with four elements through the height."""
    found = run_modes(cantilever(backend, degree, nu)).frequencies[:3]
    return np.abs(found / exact_frequencies(nu) - 1).max()


@pytest.mark.parametrize(("elements", "limit"), _INCOMPRESSIBLE.items())
def test_volumetric_locking_is_told_where_it_is_measured(elements, limit):
    known, below = locking_error(*elements, 0.3), limit - 0.5 * (0.5 - limit)
    assert locking_error(*elements, limit) > max(0.02, (10 if elements[1] > 1 else 2.5) * known)
    assert told(cantilever(*elements, limit))["volumetric-locking"]["nu"] == limit
    assert told(cantilever(*elements, below)) == {}


RULES = {
    "Greville": {"method": "greville"},
    "Greville, area": {"method": "greville", "weights": "area"},
    "Botella": {"method": "botella"},
    "Botella, area": {"method": "botella", "weights": "area"},
    "grid": {"method": "grid", "points": 33},
    "node-to-surface": {"method": "node_to_surface"},
    "node-to-surface, tributary": {"method": "node_to_surface", "weights": "tributary"},
    "GPTS, lumped": {"method": "gpts", "points": 4, "lumped": True},
    "GPTS": {"method": "gpts", "points": 4},
}
ACCURATE = ("GPTS", "node-to-surface, tributary")


@cache
def contacts_of(name, backend):
    """Contacts of a scene as it comes; their relative stiffness does not depend on the rule."""
    return coupled(load_scene(name, backend=backend))[0].contacts


@pytest.mark.parametrize("rule", RULES)
def test_point_rules_are_told_where_the_study_found_them_too_crude(rule):
    """Errors of growth rates of 2 % and more, where the yardstick has less than half of that."""
    crude = 0
    rows = uses(read(STUDY.name, STUDY.shipped))
    rows = rows[(rows["rule"] == rule) & (rows["degree"] == 2) & (rows["growth_worst"] > 0)]
    for row in rows.to_dict("records"):
        if _locks(row):
            continue
        backend = row["backend"]
        stiffness = row["p"] * PROBLEMS[row["problem"]].unit
        scene = load_scene(row["problem"], backend=backend).change(
            {"contacts.interface.formulation": RULES[rule], "contacts.interface.p": stiffness}
        )
        warned = list(point_rule(scene, "interface", contacts_of(row["problem"], backend)))
        if row["growth_worst"] > max(0.02, 2 * row["floor"]):
            crude += 1
            assert warned, row
        assert not warned or rule not in ACCURATE, row
    assert bool(crude) == (rule not in ACCURATE)


def _locks(row):
    """Too many points for stiff, coarse meshes in space: that is another warning."""
    if row["problem"] == "drum_3d":
        return row["p"] == 1000.0
    return row["problem"] == "ring" and row["backend"] == "fe"


def test_modes_too_short_for_their_mesh_are_named(backend):
    """Those left are within 3 % of the modes of a fine mesh."""
    coarse = {
        "fe": {"cell": "quadrilateral", "degree": 2, "elements": [2, 12]},
        "iga": {"degree": [2, 2], "elements": [2, 12]},
    }[backend]
    scene = load_scene("drum", backend=backend)
    meshes = {f"bodies.{name}.mesh.{backend}": coarse for name in scene.bodies}
    result = run_modes(scene.change(meshes))
    (warning,) = result.warnings
    assert warning.kind == "short-modes"
    short = np.zeros(len(result.modes), dtype=bool)
    short[np.array(warning.data["modes"]) - 1] = True
    fine = run_modes(load_scene("drum", ["analysis.max_frequency=0.6"], "iga")).eigenvalues
    errors = np.array([np.abs(fine - value).min() / abs(value) for value in result.eigenvalues])
    assert 0 < short.sum() < 0.5 * len(short)
    assert errors[~short].max() < 0.03
    assert errors[short].mean() > 5 * errors[~short].mean()
