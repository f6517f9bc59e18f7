"""The page of formulations and the pairings study: what they say is what was computed."""

import csv
import json
from copy import deepcopy
from pathlib import Path

import pytest
from mpi import cea_on_ranks
from report_data import Page

from cea.errors import InputError
from comparisons.formulations import words
from comparisons.formulations.locking import LockingStudy
from comparisons.formulations.page import read_formulations, tables_of, write_formulations
from comparisons.formulations.pairings import PairingsStudy, run_pairings
from comparisons.formulations.patch_tests import PatchTestStudy
from comparisons.formulations.study import FormulationsStudy, run_formulations
from comparisons.kit.progress import Progress
from comparisons.paper.common.figure import Number
from comparisons.paper.patch_test.numbers import met, run_paper_numbers
from scenes.read import load_scene
from scenes.run import run_scene

QUIET = Progress(lambda step: None, lambda stage: None)
COARSE = (
    "bodies.pad.mesh.fe.elements=[2, 3, 1]",
    "bodies.pad.mesh.iga.elements=[2, 3, 1]",
    "bodies.disc.mesh.fe.elements=[5, 24, 1]",
    "bodies.disc.mesh.iga.elements=[6, 28, 1]",
    "analysis.max_frequency=8500.0",
)
SMALL = FormulationsStudy(
    PatchTestStudy(
        stiffnesses=(1e6, 1e14),
        gauss=(5,),
        samples=9,
        problems=("flat",),
        meshes=("NURBS",),
        only=("Greville", "GPTS 5", "GPTS 5, lumped", "segments", "mortar"),
    ),
    LockingStudy(
        stiffnesses=(1.0, 1e6),
        elements_a=(6, 2),
        elements_b=(7, 3),
        only=("segments", "mortar"),
        tied=False,
    ),
    PairingsStudy(overrides=COARSE),
)


def figure_12(progress):
    return run_paper_numbers(progress, ("12",))


@pytest.fixture(scope="module")
def computed():
    """Data of a small study, and the parts as they began."""
    begun = []
    return run_formulations(QUIET, begun.append, figure_12, SMALL), begun


@pytest.fixture
def data(computed):
    return deepcopy(computed[0])


@pytest.fixture
def report(data, tmp_path):
    return write_formulations(data, tmp_path / "new" / "folder")


def rows_of(file):
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
def test_every_part_is_run_and_timed(computed):
    data, begun = computed
    parts = [data[key] for key in ("patch_tests", "locking", "paper", "pairings")]
    assert len(begun) == len(parts)
    assert data["seconds"] >= sum(part["seconds"] for part in parts)
    for part in parts:
        if "timings" in part:
            assert 0 < sum(part["timings"].values()) <= part["seconds"]
    assert parts[1]["timings"]["krylov"] > 0


def test_pairings_find_the_same_unstable_mode(data):
    part = data["pairings"]
    assert [(run["pad"], run["disc"]) for run in part["runs"]] == [
        *(("fe", "fe"), ("fe", "iga"), ("iga", "fe"), ("iga", "iga"))
    ]
    for run, found in zip(part["runs"][1:], part["differences"], strict=True):
        assert found["only_first"] == found["only_second"] == []
        (pair,) = found["pairs"]
        assert pair["frequency"] == [
            pytest.approx(each["unstable"][0]["frequency"]) for each in (part["runs"][0], run)
        ]
        # The disc decides: these meshes of it are coarse, and of both backends far apart.
        same_disc = run["disc"] == "fe"
        assert abs(pair["frequency_difference"]) < (1e-3 if same_disc else 0.02)
        assert pair["modal_assurance"] > 0.99
    for run in (*part["runs"], part["refined"]):
        assert run["window"]["complete"]
        assert run["window"]["found_below"] > 20
    assert part["refined"]["dofs"] > part["runs"][-1]["dofs"]


@pytest.mark.slow
def test_a_pairing_is_the_scene_with_mortar(data):
    mixed = [
        *(*COARSE, "bodies.pad.backend=iga", "bodies.disc.backend=fe"),
        "contacts.pad_disc.formulation={method='mortar'}",
    ]
    modes = run_scene(load_scene(Path("disc_pad"), mixed)).modes
    (mode,) = data["pairings"]["runs"][2]["unstable"]
    (i,) = modes.unstable(10.0).nonzero()[0]
    assert mode["frequency"] == pytest.approx(modes.frequencies[i], rel=1e-9)
    assert mode["growth"] == pytest.approx(modes.growth_rates[i], rel=1e-7)
    assert mode["condition"] == pytest.approx(modes.conditions[i], rel=1e-6)


@pytest.mark.slow
def test_pairings_on_the_meshes_of_the_scene():
    """Six modes agree; the growth of that near a coalescence is another with a higher degree."""
    part = run_pairings(QUIET)
    for found in part["differences"]:
        assert len(found["pairs"]) == 6
        assert found["only_first"] == found["only_second"] == []
        for pair in found["pairs"]:
            assert abs(pair["frequency_difference"]) < 0.01
            assert abs(pair["growth_difference"]) < 0.15
    changed = [
        pair["frequency"][0]
        for pair in part["refined"]["difference"]["pairs"]
        if abs(pair["growth_difference"]) > 0.15
    ]
    assert changed == [pytest.approx(7986, abs=5)]
    most = max(part["runs"][-1]["unstable"], key=lambda mode: mode["condition"])
    assert most["frequency"] == pytest.approx(changed[0])
    assert any("7986 Hz is not converged" in s for s in words.not_converged({"pairings": part}))


@pytest.mark.parametrize(
    ("paper", "ours", "verdict"),
    [
        (3200.0, 3233.0, True),
        (34.0, 0.447, False),
        ("below 1", 0.98, True),
        ("below 1", 1.02, False),
        ("above 1", 0.9, False),
        ("not zero", 3e-3, True),
        ("machine precision", 5e-9, True),
        ("machine precision", 1e-4, False),
        ("negligible", 12.0, None),
        (None, 12.0, None),
    ],
)
def test_numbers_of_the_paper_are_judged(paper, ours, verdict):
    assert met(Number("what", paper, ours)) is verdict


def test_page_needs_no_other_file(report):
    page = Page(report.read_text(encoding="utf-8"))
    assert report.name == "report.html"
    assert not page.tags & {"link", "iframe", "object"}
    assert len([a for a in page.addresses if a.startswith("data:image/png;base64,")]) == 3
    assert all(a.startswith(("data:", "#")) for a in page.addresses)


def test_tables_hold_the_data(report, data):
    tables = Page(report.read_text(encoding="utf-8")).tables
    assert set(tables) == {table.name for table in tables_of(data)}
    passes = {row[0]: row[1] for row in tables["passes_flat"][1:]}
    assert passes["mortar"] == passes["segments"] == "every"
    assert passes["Greville"] == "none"
    assert passes["GPTS 5, lumped"] == "10¹⁴"
    written = rows_of(report.parent / "paper_numbers.csv")
    numbers = data["paper"]["figures"][0]["numbers"]
    assert [float(row["ours"]) for row in written] == [n["ours"] for n in numbers]
    assert float(written[0]["ratio"]) == pytest.approx(numbers[0]["ours"] / 2300)
    assert {row["met"] for row in written} == {"False"}
    first, growth = rows_of(report.parent / "pairing_differences.csv")[0], []
    for run in data["pairings"]["runs"][:2]:
        growth.append(run["unstable"][0]["growth"])
    assert float(first["growth_change"]) == pytest.approx(growth[1] / growth[0] - 1)
    momentum = {row["formulation"]: row for row in rows_of(report.parent / "momentum.csv")}
    assert float(momentum["GPTS 5, lumped"]["angular_normal"]) > 1e-3
    assert float(momentum["mortar"]["angular_normal"]) < 1e-14
    total = rows_of(report.parent / "study_times.csv")[3]
    assert float(total["total"]) == data["pairings"]["seconds"]


def test_summary_follows_the_data(data):
    text = words.summary(data)
    assert "on the flat interface segments and mortar pass" in text
    assert "error grows as contact stiffens with segments; it does not with mortar" in text
    assert "angular momentum with all but GPTS 5, lumped" in text
    assert "0 of 4 numbers of the paper are met" in text
    assert "the other 3 pairings of backends find the same" in text
    for run in data["patch_tests"]["runs"]:
        run["passes"] = []
        run["momentum"]["normal"]["angular"] = 0.0
    for run in data["locking"]["runs"]:
        run["errors"] = [1e-4, 1e-4] if run["formulation"] == "segments" else [1e-4, None]
    data["paper"]["figures"][0]["numbers"][0]["met"] = True
    lone = data["pairings"]["differences"][0]
    lone["only_first"] = [{"frequency": 6000.0, "growth": 20.0}]
    text = words.summary(data)
    assert "on the flat interface none passes" in text
    assert "error grows as contact stiffens with mortar; it does not with segments" in text
    assert "keep momentum with all" in text
    assert "1 of 4 numbers of the paper are met" in text
    assert "the other 3 pairings of backends leave 1 mode without partner" in text


def test_words_of_each_part_follow_the_data(data):
    text = words.patch_tests(data, "flat")
    assert "segments and mortar pass for every P" in text
    assert "GPTS 5, lumped (P = 10¹⁴; 1 of 1 pair of meshes)" in text
    assert text.endswith("Never: Greville.")
    assert words.own_errors(data) == ""
    fe, _ = words.locking(data)
    assert fe.startswith("Finite elements, p = 1 to 10⁶: the error grows more than 10 times")
    assert "Figure 12, D2C1, Greville, P = 10⁶ (paper 2300, ours 2\u202f594)" in words.paper_met(
        data
    )
    refined = data["pairings"]["refined"]["difference"]
    refined["pairs"][0] |= {"frequency": [6559.8, 6500.0], "growth": [333.0, 20.0]}
    refined["only_second"] = [{"frequency": 8498.0, "growth": 60.0}]
    text = " ".join(words.not_converged(data))
    assert "The growth rate at 6560 Hz is not converged" in text
    assert "it is 20.0 1/s instead of 333 1/s" in text
    assert "one more at 8498 Hz, 0.024 % below the end of the window" in text


def test_a_page_is_drawn_anew_from_its_result(report, data):
    stored = read_formulations(report.parent)
    assert stored == json.loads(json.dumps(data))
    again = write_formulations(stored, report.parent / "again")
    assert again.read_text(encoding="utf-8") == report.read_text(encoding="utf-8")


def test_other_folders_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"a folder with the result\.json of `cea formulations`"):
        read_formulations(tmp_path)
    (tmp_path / "result.json").write_text('{"command": "compare"}')
    with pytest.raises(InputError, match="out = "):
        read_formulations(tmp_path)


@pytest.mark.slow
@pytest.mark.mpi
def test_two_ranks_draw_one_page(report):
    """The command line names the page once, and the page is that of one rank."""
    before = report.read_text(encoding="utf-8")
    report.unlink()
    done = cea_on_ranks(2, "formulations", "--redraw", "--out", report.parent)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("The report to open: ") == 1
    assert report.read_text(encoding="utf-8") == before
