"""The paper as a study: figures and their measures, what comes with the project, claims."""

from dataclasses import replace
from math import tau

import numpy as np
import pandas as pd
import pytest

from cea.contact.formulations import GaussPointToSurface, Segments
from cea.system.contact_stresses import stresses_at
from comparisons.paper import crowned_pad
from comparisons.paper.claims import judged
from comparisons.paper.crowned_pad import CONTACT, PAD, crowned_scene
from comparisons.paper.disc_pad import GPTS, LUMPED
from comparisons.paper.figure import midpoints
from comparisons.paper.figures import FIGURES, chosen
from comparisons.paper.lumping import EDGE, SHAPES, false_shifts, rotation_ratio
from comparisons.paper.normal_compliance import error
from comparisons.paper.patch_test import PatchTest, PatchTests
from comparisons.paper.spectra import (
    Diagram,
    Spectrum,
    case_row,
    means_of,
    measures,
    paired,
    run_tables,
)
from comparisons.paper.study import STUDY, headline
from comparisons.study.result import StudyResult, read
from comparisons.study.session import Session
from scenes import run_modes, run_scene
from scenes.results.matching import ModeSet

SHIPPED = read("paper", STUDY.shipped)
CASES = [case["labels"] for case in SHIPPED.cases]


def test_figures_go_by_name():
    assert [figure.name for figure in chosen(("5", "stiff", "4"))] == ["4 and 5", "stiff"]
    assert chosen(()) == list(FIGURES.values())


def test_claims_whose_figures_were_not_made_are_left_out():
    some = [case for case in SHIPPED.cases if case["labels"]["figure"] == "15"]
    assert list(judged(StudyResult({"cases": some}))["name"]) == ["places of points"]
    assert "8 of 20 claims hold on every kind of mesh" in headline(SHIPPED)
    assert judged(StudyResult({"cases": []})).empty


def test_stored_numbers_are_as_the_paper_says():
    rows, numbers = SHIPPED.frame("patch_tests"), SHIPPED.frame("numbers")
    ratios = numbers.query("mesh == 'NURBS' and paper == 'below 1'")
    assert len(ratios) == 5
    assert (ratios["ours"] < 1).all()
    rows = rows.query("mesh == 'NURBS'")
    assert (rows.loc[rows["figure"] == "7", "b_over_a"] > 1).all()
    quoted = rows[rows["paper"].map(lambda said: isinstance(said, float) and said > 1000)]
    tenth = quoted[quoted["figure"] == "10"]
    assert len(tenth) == 3
    np.testing.assert_allclose(tenth["oscillation"], tenth["paper"].astype(float), rtol=0.05)
    assert (rows.loc[rows["paper"] == "machine precision", "oscillation"] < 1e-7).all()
    slopes = numbers.query("figure == 'points'")
    assert len(slopes) == 11
    expected = slopes["remark"].str.extract(r"= (-\d+)")[0].astype(float)
    np.testing.assert_allclose(slopes["ours"], expected, atol=0.3)
    runs = SHIPPED.frame("runs").query("mesh == 'NURBS' and figure == '15'")
    assert runs["points"].tolist() == [104, 100]


def assert_same_rows(found, expected):
    """Equal words; numbers to 1e-8 of the largest of their column, but rounding and times."""
    found, expected = pd.DataFrame(found), pd.DataFrame(expected)
    assert list(found) == list(expected)
    for name in set(expected) - {"residual", "condition", "seconds", "search_over"}:
        if expected[name].dtype.kind == "f" or name in ("disc", "pad"):
            same = (frame[name].to_numpy(dtype=float) for frame in (found, expected))
            scale = np.nanmax(np.abs(expected[name].to_numpy(dtype=float)))
            np.testing.assert_allclose(*same, rtol=0, atol=1e-8 * scale + 1e-14, err_msg=name)
        else:
            assert list(found[name]) == list(expected[name]), name


@pytest.mark.slow
@pytest.mark.parametrize("labels", CASES, ids=lambda labels: "-".join(labels.values()))
def test_stored_numbers_are_those_of_the_program(labels):
    """Of a diagram the fastest run, of the patch test one case, of everything else all of it."""
    figure, mesh = FIGURES[labels["figure"]], labels["mesh"]
    stored = next(case for case in SHIPPED.cases if case["labels"] == labels)["tables"]
    if isinstance(figure, Diagram):
        fastest = min(stored["runs"], key=lambda row: row["seconds"])
        P, number = fastest["P"], fastest["number"]
        case = figure.panels(mesh)[P][number]
        row, modes = run_tables(case_row(P, number, case), Spectrum.of(run_modes(case.scene(mesh))))
        for name, found in (("runs", [row]), ("modes", modes)):
            own = [row for row in stored[name] if (row["P"], row["number"]) == (P, number)]
            assert_same_rows(found, own)
        return
    if isinstance(figure, PatchTests):  # the softest, which leaves more than rounding, fast
        row = min(stored["patch_tests"], key=lambda row: (row["P"], row["seconds"]))
        case = next(case for case in figure.cases if case.on(mesh).label == row["case"])
        figure, stored = replace(figure, cases=(case,), ratios=()), {"patch_tests": [row]}
    tables, _ = made(figure, mesh)
    for name, rows in stored.items():
        assert_same_rows(tables[name], rows)


def test_figures_and_the_claims_that_they_decide_are_a_command(cea, tmp_path):
    code, told, fault = cea("paper", "1", "15", "--out", ".")
    assert code == 0, fault
    assert "claims hold on every kind of mesh" in told
    found = pd.read_csv(tmp_path / "claims.csv", dtype={"section": str})
    some = [case for case in SHIPPED.cases if case["labels"]["figure"] in ("1", "15")]
    expected = judged(StudyResult({"cases": some}))
    pd.testing.assert_frame_equal(found, expected, check_dtype=False, rtol=1e-14)
    assert {file.name for file in tmp_path.glob("*.png")} == {"figure_1.png", "figure_15.png"}


COARSE = {
    "pad": {"fe": [3, 4, 1], "iga": [3, 5, 1], "size": 0.02},
    "disc": {"fe": [6, 16, 1], "iga": [5, 20, 1], "size": 0.03},
}


def coarse(scene):
    """Disc and pad on meshes that run in a second, up to 5 kHz."""
    changes = {"analysis.max_frequency": 5e3}
    for name, body in scene.bodies.items():
        mesh, own = f"bodies.{name}.mesh.{body.backend}", COARSE[name]
        if getattr(body.mesh, body.backend).elements is None:
            changes[f"{mesh}.size"] = own["size"]
        else:
            changes[f"{mesh}.elements"] = own[body.backend]
    return scene.change(changes)


RUNS = []
"""Results of scenes on these meshes, which several tests share."""


def solved(scene):
    """Result of a scene, run once."""
    found = [result for result in RUNS if result.scene == scene]
    RUNS.extend([] if found else [run_modes(scene)])
    return found[0] if found else RUNS[-1]


def made(figure, mesh, *, small=False):
    """Tables of a figure by itself and its session, on a kind of mesh."""
    session, scenes = Session(None), figure.inputs(mesh)
    if small:
        scenes, session.solve = {name: coarse(s) for name, s in scenes.items()}, solved
    session.begin(scenes)
    return figure.evaluate(mesh, session), session


def spectrum(*modes, motion=None):
    """A run of modes (number of its shape, growth, Hz): unstable above 10 1/s."""
    number, growth, hertz = np.array(modes, dtype=float).reshape(-1, 3).T
    kept = ModeSet(growth + 1j * tau * hertz, np.eye(9, dtype=complex)[:, number.astype(int)])
    motion = np.ones(len(modes)) if motion is None else np.array(motion)
    rest = (motion, motion, np.zeros(len(modes)), np.ones(len(modes)), {"search": 2.0, "points": 8})
    return Spectrum(kept, np.flatnonzero(growth > 10), *rest)


FOUR = [(i, 0, 1e3 * (i + 1)) for i in range(4)]
MEASURED = {
    "coinciding modes are counted with those alone": (
        spectrum((0, 100, 5000), (1, 50, 9000), (2, 19, 1000), (3, 40, 12000)),
        spectrum((0, 100.5, 5040), (1, 80, 9010), (2, 19, 1020)),
        {"share_frequency": 2 / 4, "share_both": 1 / 4, "alone": 1, "growth_difference": 40},
    ),
    "sums and shifts keep to their band": (
        spectrum((0, 0, 1010), (1, 0, 14100), (2, 30, 2000), (3, 28, 12000)),
        spectrum((0, 0, 1000), (1, 0, 14000), (2, 20, 2000), (3, 20, 12000)),
        {"growth_over": 58 / 40, "growth_below_10k": 30 / 20, "distance": 0.01, "shift": 0.01}
        | {"shift_below_13k": 0.01, "shift_above_13k": 1 / 140},
    ),
    "motions by their median where there are some": (
        spectrum(*FOUR, motion=(1.0, 6.0, 3.0, np.nan)),
        spectrum(*FOUR, motion=(1.0, 2.0, 1.5, 2.0)),
        {"contact_motion": 2.0},
    ),
}


@pytest.mark.parametrize("name", MEASURED)
def test_measures(name):
    own, reference, expected = MEASURED[name]
    found = measures(own, reference, paired(own, reference))
    assert {key: found[key] for key in expected} == pytest.approx(expected)
    nowhere = replace(own, motion=np.full(len(own.motion), np.nan))
    assert measures(nowhere, reference, paired(own, reference))["contact_motion"] is None


def test_error_of_the_linearised_law_in_closed_form():
    """With m = 2 the change is 2 e + e^2 of which 2 e is linear: the tangent at steady sliding."""
    for part in (0.01, 0.1, 1.0):
        assert error(part) == pytest.approx(part / (2 + part))


SOFT_GPTS, SOFT_LUMPED = (replace(case, P=1e6) for case in (GPTS, LUMPED))


@pytest.mark.parametrize(
    ("mesh", "cases"), [("NURBS", (SOFT_GPTS, SOFT_LUMPED)), ("hexahedra", (GPTS, LUMPED))]
)
def test_lumping_gives_a_rotation_false_stiffness_on_nurbs_only(mesh, cases):
    """On traced quadratic hexahedra lumping is Simpson's rule, exact for squares of rotations."""
    plain, lumped = (rotation_ratio(solved(coarse(case.scene(mesh)))) for case in cases)
    assert abs(plain) < 1e-12
    assert lumped > 0.05 if mesh == "NURBS" else abs(lumped) < 1e-3


def test_false_stiffness_shifts_modes_as_lumping_does_at_low_stiffness():
    plain, lumped = (solved(coarse(case.scene("NURBS"))) for case in (SOFT_GPTS, SOFT_LUMPED))
    expected, match = false_shifts(plain, lumped), paired(Spectrum.of(lumped), Spectrum.of(plain))
    assert len(match.groups) > 4
    first, second = means_of(match)
    false = [expected[group.second].mean() for group in match.groups]
    assert max(false) > 1e-5
    assert first.imag / second.imag - 1 == pytest.approx(false, rel=0.05, abs=0.02 * max(false))


def test_a_diagram_measures_its_cases_beside_the_first():
    """Spectra are those of the cases; equal cases on a kind of mesh are one."""
    figure = Diagram("small", "small", (GPTS, LUMPED, replace(GPTS, divided=True)))
    tables, _ = made(figure, "hexahedra", small=True)
    assert [(row["P"], row["number"]) for row in tables["runs"]] == [(1e9, 0), (1e9, 1)]
    (measured,) = tables["measures"]
    own = tables["matches"]
    shifts = [abs(row["frequency"] / row["reference_frequency"] - 1) for row in own]
    assert measured["shift"] == pytest.approx(max(shifts), rel=1e-9)
    for row in tables["runs"]:
        modes = [mode for mode in tables["modes"] if mode["number"] == row["number"]]
        assert row["unstable"] == sum(mode["unstable"] for mode in modes)


def test_shapes_and_lines_of_a_mode():
    tables, session = made(SHAPES, "NURBS", small=True)
    plain = [row for row in tables["lines"] if row["run"] == "plain"]
    arc, disc, pad = (np.array([row[n] for row in plain], float) for n in ("arc", "disc", "pad"))
    assert np.abs(disc).max() == pytest.approx(1)
    # The line is a chord: the pad's radial ends cut it at 0.115 tan 20 degrees.
    assert (np.isfinite(pad) == (np.abs(arc) < EDGE + 1e-9)).all()
    assert list(session.shapes.scenes) == ["plain-NURBS", "lumped-NURBS"]
    assert [len(modes) for modes in session.shapes.modes.values()] == [1, 1]


OSCILLATIONS = {
    "12": {
        "Greville, P = 10⁶": 2594.0,
        "GPTS 15 × 15, P = 10⁶": 0.0748,
        "Greville, P = 10¹⁴": 58.4,
    },
    "3": {"GPTS 25 × 25, P = 10⁶": 0.116, "GPTS 25 × 25, lumped, P = 10⁶": 0.0982},
}
"""Oscillation (N/m^2) by figure and case, from an independent prototype."""


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("name", OSCILLATIONS)
def test_numbers_of_the_patch_test(name):
    tables, session = made(FIGURES[name], "NURBS")
    found = {row["case"]: row["oscillation"] for row in tables["patch_tests"]}
    for case, expected in OSCILLATIONS[name].items():
        assert found[f"D2C1, {case}"] == pytest.approx(expected, rel=0.01)
    # The map is coarser than the samples of the oscillation.
    first = tables["patch_tests"][0]
    for side, plane in zip("ab", session.arrays["maps"][0], strict=True):
        assert np.ptp(plane) == pytest.approx(first[f"oscillation_{side}"], rel=0.02)


def test_there_are_no_stresses_beside_a_turned_contact():
    """Exact integration leaves the exact stress; a square on its corner fills half the square."""
    turn = {"axis": [0.0, 0.0, 1.0], "angle": 45.0}
    changes = {f"bodies.{body}.placement": turn for body in ("upper", "lower")}
    result = run_scene(PatchTest(Segments()).scene("NURBS").change(changes))
    corners = result.interfaces["interface"].a.grid(2).x
    ticks = np.linspace(corners.min(axis=0), corners.max(axis=0), 41)
    points = np.stack(np.meshgrid(*ticks[:, :2].T, corners[0, 2:]), axis=-1).reshape(-1, 3)
    for stress in stresses_at(result.system, "interface", result.displacement, points).values():
        inside = np.isfinite(stress)
        assert inside.mean() == pytest.approx(0.5, abs=0.03)
        assert stress[inside] == pytest.approx(np.full(inside.sum(), -1000.0), rel=1e-9)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("mesh", "backend", "pad", "disc"),
    [("NURBS", "iga", [3, 7, 1], [5, 16, 1]), ("hexahedra", "fe", [2, 6, 1], [4, 12, 1])],
)
def test_pressures_of_a_crowned_pad_bear_its_load(mesh, backend, pad, disc):
    """Closures are those that the contact met, and midpoints sum the pressure nearly."""
    scene = crowned_scene(mesh, GaussPointToSurface(4), 1e6)
    changes = {f"bodies.{n}.mesh.{backend}.elements": e for n, e in (("pad", pad), ("disc", disc))}
    crowned = run_modes(scene.change(changes | {"analysis.max_frequency": 1500.0}))
    contact = crowned.steady.contacts[CONTACT]
    found = crowned_pad.closures(crowned, crowned.interfaces[CONTACT].points.x)
    np.testing.assert_allclose(found, contact.closure, rtol=0, atol=1e-8 * np.abs(found).max())
    kept, pressure = crowned_pad.state(crowned)
    r = midpoints(0.09, 0.14, crowned_pad.RADII)
    assert (pressure.mean(axis=1) * r).sum() / r.sum() == pytest.approx(1e6, rel=0.02)
    assert kept["force"] == pytest.approx(1e6 * crowned.bodies[PAD].surfaces["top"].area, rel=1e-3)
    assert 0.5 < kept["closed"] < 0.9
