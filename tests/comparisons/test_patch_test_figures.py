"""Figures of the patch test: their numbers, the stresses they show, rates of quadrature."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from paper_figures import made

from cea.contact.formulations import GaussPointToSurface, Greville
from cea.system.contact_stresses import pressure_along, stress_map
from comparisons.paper.figures import FIGURES
from comparisons.paper.patch_test import PatchTest, stresses
from comparisons.paper.quadrature import QUADRATURE
from comparisons.paper.study import STUDY
from comparisons.study.result import read
from scenes import run_scene
from scenes.spec.reading import load_scene

EXPECTED = {
    "12": {
        "D2C1, Greville, P = 10⁶": 2594.0,
        "D2C1, GPTS 15 × 15, P = 10⁶": 0.0748,
        "D2C1, Greville, P = 10¹⁴": 58.4,
    },
    "3": {
        "D2C1, GPTS 25 × 25, P = 10⁶": 0.116,
        "D2C1, GPTS 25 × 25, lumped, P = 10⁶": 0.0982,
    },
}
"""Oscillation (N/m^2) by figure and case, from an independent prototype."""
STORED = read("paper", STUDY.shipped)
figure = cache(lambda name, mesh="NURBS": made(FIGURES[name], mesh))
"""Tables and arrays of a figure, computed once."""


def oscillations(name, mesh="NURBS"):
    return {row["case"]: row["oscillation"] for row in figure(name, mesh)[0]["patch_tests"]}


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("name", EXPECTED)
def test_numbers_of_the_patch_test(name):
    for case, expected in EXPECTED[name].items():
        assert oscillations(name)[case] == pytest.approx(expected, rel=0.01)


def test_maps_and_lines_hold_what_the_numbers_say():
    tables, arrays = figure("12")
    assert [row["paper"] for row in tables["patch_tests"]] == [2300.0, 0.055, 0.16, 0.05]
    assert arrays["maps"].shape == (4, 2, 61, 61)
    assert arrays["lines"].shape == (4, 4, 181)
    # The map is coarser than the samples of the oscillation.
    for side, found in zip("ab", arrays["maps"][0], strict=True):
        expected = tables["patch_tests"][0][f"oscillation_{side}"]
        assert np.ptp(found) == pytest.approx(expected, rel=0.01)


def test_spaces_of_one_continuity_agree_over_backends():
    """Quadratic C0 splines and Lagrange elements span the same functions."""
    case = PatchTest(GaussPointToSurface(12), continuity=0)
    runs = [run_scene(case.scene(mesh)) for mesh in ("hexahedra", "NURBS")]
    assert runs[0].dofs == runs[1].dofs
    fe, iga = (stresses(run)[0][1:3] for run in runs)
    assert np.median(np.abs(fe - iga)) < 1e-5  # at facets Lagrange stresses jump


def yardstick(*overrides):
    formulation = "contacts.interface.formulation={method='segments'}"
    return run_scene(load_scene(Path("patch_test"), [formulation, *overrides]))


def test_stress_map_and_line_of_an_exact_contact(backend):
    result = yardstick(*(f"bodies.{body}.backend='{backend}'" for body in ("upper", "lower")))
    plane = stress_map(result.system, "interface", result.displacement, 11)
    assert plane.u[[0, -1]] == pytest.approx([0.0, 9.0])
    assert plane.v[[0, -1]] == pytest.approx([0.0, 9.0])
    for stress in plane.sigma_n.values():
        assert stress == pytest.approx(np.full((11, 11), -1000.0), rel=1e-9)
    line = result.stresses["interface"]["a"]
    assert line.arc[-1] == pytest.approx(9 * np.sqrt(2))
    pressure = pressure_along(result.system, "interface", result.displacement, 1e6 / 81, 46)
    assert pressure == pytest.approx(np.full(91, 1000.0), rel=1e-8)


def test_stress_map_is_the_stress_at_its_points():
    scene = PatchTest(Greville()).scene("NURBS")
    result = run_scene(replace(scene, analysis=replace(scene.analysis, samples=13)))
    plane = stress_map(result.system, "interface", result.displacement, 13)
    u, v = np.meshgrid(plane.u, plane.v)
    for side, stress in result.stresses["interface"].items():
        found = dict(zip(map(tuple, np.round(stress.x[:, :2], 6)), stress.sigma_n, strict=True))
        points = zip(np.round(u.ravel(), 6), np.round(v.ravel(), 6), strict=True)
        expected = [found[point] for point in points]
        assert plane.sigma_n[side].ravel() == pytest.approx(expected, rel=1e-9)


def test_stress_map_of_a_turned_contact_has_nothing_beside_it():
    turn = "placement={axis=[0.0,0.0,1.0],angle=45.0}"
    result = yardstick(*(f"bodies.{body}.{turn}" for body in ("upper", "lower")))
    plane = stress_map(result.system, "interface", result.displacement, 41)
    assert np.ptp(plane.u) == pytest.approx(9 * np.sqrt(2))
    for stress in plane.sigma_n.values():
        inside = np.isfinite(stress)
        # A square on its corner fills half of the square around it.
        assert inside.mean() == pytest.approx(0.5, abs=0.03)
        assert stress[inside] == pytest.approx(np.full(inside.sum(), -1000.0), rel=1e-9)


@pytest.mark.convergence
def test_error_falls_with_gauss_points_as_continuity_allows(monkeypatch):
    spaces = {"NURBS": ((2, 1),)}
    monkeypatch.setattr("comparisons.paper.quadrature._SPACES", spaces)
    tables, _ = made(replace(QUADRATURE, points=tuple(range(5, 25))), "NURBS")
    for row, (_, c) in zip(tables["numbers"], spaces["NURBS"], strict=True):
        assert row["ours"] == pytest.approx(-(c + 2), abs=0.3)


def test_stored_errors_fall_so_in_every_space():
    slopes = STORED.frame("numbers").query("figure == 'points'")
    assert len(slopes) == 11
    expected = slopes["remark"].str.extract(r"= (-\d+)")[0].astype(float)
    np.testing.assert_allclose(slopes["ours"], expected, atol=0.3)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("name", ["2", "11"])
def test_settings_show_the_meshes_of_both_backends(name):
    arrays = {mesh: figure(name, mesh)[1] for mesh in ("NURBS", "hexahedra")}
    assert len(arrays["NURBS"]) == 12
    for surface, corners in arrays["NURBS"].items():
        middles = (cells.mean(axis=1) for cells in (corners, arrays["hexahedra"][surface]))
        np.testing.assert_allclose(*middles, atol=1e-9)
    ours = {row["what"]: row["ours"] for row in figure(name)[0]["numbers"]}
    assert (ours["elements of a"], ours["elements of b"]) == {"2": (9, 25), "11": (25, 9)}[name]
    assert ours["height of a"] == pytest.approx(4.5)
    assert ours["Greville points of a"] == {"2": 25, "11": 49}[name]


def test_stored_numbers_are_as_the_paper_says():
    rows = STORED.frame("patch_tests").query("mesh == 'NURBS'")
    ratios = STORED.frame("numbers").query("mesh == 'NURBS' and paper == 'below 1'")
    assert len(ratios) == 5
    assert (ratios["ours"] < 1).all()
    assert (rows.loc[rows["figure"] == "7", "b_over_a"] > 1).all()
    quoted = rows[rows["paper"].map(lambda said: isinstance(said, float) and said > 1000)]
    tenth = quoted[quoted["figure"] == "10"]
    assert len(tenth) == 3
    np.testing.assert_allclose(tenth["oscillation"], tenth["paper"].astype(float), rtol=0.05)
    lumped = rows[rows["paper"] == "machine precision"]
    assert lumped["oscillation"].item() < 1000 * 1e-10
