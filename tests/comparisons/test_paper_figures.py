"""Figures of the paper: their numbers, the stresses they show, and what is stored of them."""

import csv
import gzip
import subprocess
import sys
from dataclasses import replace
from functools import cache
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cea.contact.formulations import GaussPointToSurface, Greville, NodeToSurface
from cea.errors import InputError
from cea.system.contact_stresses import pressure_along, stress_map
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.figure import Number, numbers_table
from comparisons.paper.common.store import STORED, fingerprint, make_figure
from comparisons.paper.patch_test.case import PatchTestCase, run_case, shown
from comparisons.paper.patch_test.quadrature import QUADRATURE, fitted_slope
from comparisons.paper.registry import FIGURES, chosen
from scenes import run_scene
from scenes.results.record import read_record
from scenes.spec.reading import load_scene

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)

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


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of files, and what makes a figure there, once."""
    out = tmp_path_factory.mktemp("figures")
    return out, cache(lambda name: make_figure(FIGURES[name], "iga", out, QUIET, recompute=True))


@pytest.fixture
def nothing_stored(monkeypatch, tmp_path):
    """No data come with the project."""
    monkeypatch.setattr("comparisons.paper.common.store.STORED", tmp_path / "nothing")


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("name", EXPECTED)
def test_numbers_of_the_patch_test(made, name):
    ours = {row[0]: row[2] for row in made[1](name).numbers.rows}
    for case, expected in EXPECTED[name].items():
        assert ours[case] == pytest.approx(expected, rel=0.01)


@pytest.mark.slow
def test_lumping_passes_the_patch_test_at_high_stiffness(made):
    ours = {row[0]: row[2] for row in made[1]("3").numbers.rows}
    plain, lumped = (ours[f"D2C1, GPTS 25 × 25{name}, P = 10¹⁴"] for name in ("", ", lumped"))
    assert lumped < 1000 * 1e-10
    assert 1e-2 > plain > 100 * lumped


def test_paper_numbers_stand_beside_ours(made):
    quoted = {row[0]: row[1] for row in made[1]("12").numbers.rows}
    assert list(quoted.values()) == [2300.0, 0.055, 0.16, 0.05]
    assert "no pair of uniform meshes" in made[1]("12").note


def test_files_hold_what_was_computed(made):
    out, figure = made
    pictures = figure("12").pictures
    data = read_record(out / "figure_12_iga.json.gz")
    case = data["cases"]["D2C1, Greville, P = 10⁶"]
    stress = {side: np.array(case["map"][side]) for side in "ab"}
    # The map is coarser than the samples of the oscillation.
    for side, found in stress.items():
        assert np.ptp(found) == pytest.approx(case["oscillation"][side], rel=0.01)
    with gzip.open(out / "figure_12_iga_map.csv.gz", "rt") as stream:
        assert stream.readline().startswith("case,side,y,x = 0,x = 0.15,x = 0.3,")
    # A label in quotes holds two commas.
    table = np.genfromtxt(out / "figure_12_iga_map.csv.gz", delimiter=",", skip_header=1)[:, 4:]
    assert table.shape == (4 * 2 * 61, 1 + 61)
    np.testing.assert_allclose(table[:61, 0], np.linspace(0, 9, 61), atol=1e-9)
    np.testing.assert_array_equal(table[:61, 1:], stress["a"])
    np.testing.assert_array_equal(table[61:122, 1:], stress["b"])
    assert all(picture.stat().st_size > 20_000 for picture in pictures)


def test_maps_keep_three_digits_of_what_they_show():
    for extent in (3000.0, 0.034, 4e-9):
        stress = -1000.0 + extent * np.array([[0.0, 0.123456789], [np.nan, 1.0]])
        kept = shown(stress)
        assert np.isnan(kept[1, 0])
        error = np.nanmax(np.abs(kept - stress))
        assert error <= 0.5e-3 * extent
        if extent > 1e-8:
            assert error > 0
    flat = np.full((2, 2), -1000.0)
    np.testing.assert_array_equal(shown(flat), flat)


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_stored")
def test_stored_figures_are_drawn_without_computing(made, monkeypatch):
    out, figure = made
    picture = figure("12").pictures[0]
    picture.unlink()
    monkeypatch.setattr("comparisons.paper.patch_test.figures.run_case", None)
    again = make_figure(FIGURES["12"], "iga", out, QUIET)
    assert again.reused
    assert again.numbers.rows == figure("12").numbers.rows
    assert picture.exists()


def counted(P):
    """A figure that keeps, in ``computed``, the backends it was computed for."""
    computed = []

    def compute(backend, progress):
        computed.append(backend)
        return {"answer": 2 * P}

    return SimpleNamespace(
        name="counted",
        title="counted",
        computed=computed,
        inputs=lambda backend: {"P": P, "backend": backend},
        compute=compute,
        draw=lambda data, stem: [],
        numbers=lambda data: [Number("answer", "large", data["answer"])],
        note=lambda data: "",
        tables=lambda data, stem: [],
    )


@pytest.mark.usefixtures("nothing_stored")
def test_stored_data_are_reused_only_for_equal_inputs(tmp_path):
    def make(P, **options):
        figure = counted(P)
        result = make_figure(figure, "iga", tmp_path, QUIET, **options)
        assert result.numbers.rows == [("answer", "large", 2 * P, "", "")]
        return len(figure.computed)

    assert make(1.0) == 1
    assert make(1.0) == 0
    assert make(1.0, recompute=True) == 1
    assert make(2.0) == 1
    file = tmp_path / "figure_counted_iga.json.gz"
    whole = file.read_bytes()
    for broken in (b"{ broken", whole[:40], gzip.compress(b"{ broken")):
        file.write_bytes(broken)
        assert make(2.0) == 1
    assert make(2.0) == 0


def test_compressed_tables_bear_no_time(tmp_path, monkeypatch):
    columns = (Column("a", "a"), Column("b", "b"))
    table = Table("numbers", "", columns, [(1.5, 2), (3, 4.25)], compressed=True)
    file = table.write_csv(tmp_path)
    first = file.read_bytes()
    monkeypatch.setattr("time.time", lambda: 4e9)
    assert table.write_csv(tmp_path).read_bytes() == first
    assert file.name == "numbers.csv.gz"
    np.testing.assert_array_equal(
        np.loadtxt(file, delimiter=",", skiprows=1), [[1.5, 2], [3, 4.25]]
    )


def backends(figure):
    """Backends that have a part in a figure."""
    return ("iga",) if figure.inputs("iga") == figure.inputs("fe") else ("iga", "fe")


@pytest.mark.grid(quick=4)
@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_comes_with_its_data_and_tables(name, tmp_path):
    """Equal inputs, so that nothing is computed, and CSV files made of the very data."""
    figure = FIGURES[name]
    for backend in backends(figure):
        stem = f"figure_{name}_{backend}"
        data = read_record(STORED / f"{stem}.json.gz")
        assert data["fingerprint"] == fingerprint(figure.inputs(backend))
        for table in (
            numbers_table(figure.numbers(data), stem, ""),
            *figure.tables(data, stem),
        ):
            file = table.write_csv(tmp_path)
            assert same_cells(file, STORED / file.name), file.name


def same_cells(*files):
    """Whether tables hold the same texts and, but for the last digits of sums, the same numbers."""

    def rows(file):
        content = file.read_bytes()
        content = gzip.decompress(content) if file.suffix == ".gz" else content
        return list(csv.reader(StringIO(content.decode(), newline="")))

    def same(one, other):
        try:
            return float(one) == pytest.approx(float(other), rel=1e-12, nan_ok=True)
        except ValueError:
            return False

    first, second = map(rows, files)
    return [len(row) for row in first] == [len(row) for row in second] and all(
        one == other or same(one, other)
        for row, its in zip(first, second, strict=True)
        for one, other in zip(row, its, strict=True)
    )


def test_a_figure_is_drawn_from_the_data_that_come_with_the_project(tmp_path):
    runs: list[str] = []
    progress = Progress(step=runs.append, stage=lambda stage: None)
    made = make_figure(FIGURES["6"], "iga", tmp_path, progress)
    assert made.reused
    assert runs == []
    assert made.data_file == STORED / "figure_6_iga.json.gz"
    assert made.pictures[0].parent == tmp_path
    assert made.pictures[0].stat().st_size > 20_000


def test_what_is_stored_is_small():
    assert sum(file.stat().st_size for file in STORED.iterdir()) < 7e6


def test_lagrange_elements_have_the_cases_that_differ_for_them():
    cases = FIGURES["7"].on("fe")
    hexahedra = ["D2C0, GPTS 3 × 3, P = 10⁶", "D4C0, GPTS 5 × 5, P = 10⁶"]
    assert list(cases) == [*hexahedra, *(f"tetrahedra, {label}" for label in hexahedra)]
    case = PatchTestCase(Greville(), 1e6, elements=(5, 3))
    assert [each.formulation for each in case.on("fe")] == 2 * [NodeToSurface()]
    assert case.on("iga") == (case,)
    upper, lower = case.on("fe")[1].scene("fe").bodies.values()
    assert {(m.mesh.fe.cell, m.mesh.fe.size) for m in (upper, lower)} == {
        ("tetrahedron", 9 / 5),
        ("tetrahedron", 9 / 3),
    }


def test_spaces_of_one_continuity_agree_over_backends():
    """Quadratic C0 splines and Lagrange elements span the same functions."""
    case = PatchTestCase(GaussPointToSurface(12), 1e6, continuity=0)
    fe, iga = (run_case(case, backend)[0] for backend in ("fe", "iga"))
    assert fe["dofs"] == iga["dofs"]
    found = np.array([[s["line"][side] for side in "ab"] for s in (fe, iga)], dtype=float)
    difference = np.abs(found[0] - found[1])
    assert np.median(difference) < 1e-5  # at facets Lagrange stresses jump


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
    case = PatchTestCase(Greville(), 1e6)
    scene = case.scene("iga")
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
@pytest.mark.parametrize(("degree", "continuity"), [(1, 0), (2, 1)])
def test_error_falls_with_gauss_points_as_continuity_allows(degree, continuity):
    study = replace(QUADRATURE, points=tuple(range(5, 25)))
    slope = fitted_slope(study.points, study.errors(degree, continuity, "iga"))
    assert slope == pytest.approx(-(continuity + 2), abs=0.3)


@pytest.mark.convergence
@pytest.mark.slow
def test_error_falls_with_gauss_points_in_every_space(backend):
    data = QUADRATURE.compute(backend, QUIET)
    assert len(data["spaces"]) >= 4
    for found in data["spaces"].values():
        assert found["slope"] == pytest.approx(-(found["continuity"] + 2), abs=0.3)


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("name", ["2", "11"])
def test_settings_show_the_meshes_of_both_backends(name, tmp_path):
    made = {
        b: make_figure(FIGURES[name], b, tmp_path, QUIET, recompute=True) for b in ("fe", "iga")
    }
    faces = {b: read_record(m.data_file)["faces"] for b, m in made.items()}
    for body, surfaces in faces["iga"].items():
        for surface, cells in surfaces.items():
            mesh = [np.array(each).mean(axis=1) for each in (cells, faces["fe"][body][surface])]
            assert mesh[0] == pytest.approx(mesh[1], abs=1e-9)
    ours = {row[0]: row[2] for row in made["iga"].numbers.rows}
    assert (ours["elements of a"], ours["elements of b"]) == {"2": (9, 25), "11": (25, 9)}[name]
    assert ours["height of a"] == pytest.approx(4.5)
    assert ours["Greville points of a"] == {"2": 25, "11": 49}[name]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["3", "7", "8", "9", "10", "12"])
def test_every_figure_can_be_made_on_both_backends(name, backend, tmp_path):
    made = make_figure(FIGURES[name], backend, tmp_path, QUIET, recompute=True)
    below = [row for row in made.numbers.rows if row[1] == "below 1"]
    if backend == "iga":
        assert all(row[2] < 1 for row in below)
        assert all(row[2] > 1 for row in made.numbers.rows if row[1] == "above 1")
        for what, paper, ours, *_ in made.numbers.rows:
            if isinstance(paper, float) and paper > 1000 and name == "10":
                assert ours == pytest.approx(paper, rel=0.05), what


def test_figures_go_by_name():
    assert {"2", "3", "7", "8", "9", "10", "11", "12", "points"} <= set(FIGURES)
    assert chosen("all") == list(FIGURES.values())
    assert all(figure.name == name for name, figure in FIGURES.items())
    with pytest.raises(InputError, match="figure = '99': one of 1, 2, 3"):
        chosen("99")


@pytest.mark.slow
def test_command_line_draws_stored_figures(tmp_path):
    def cea(*arguments):
        command = [Path(sys.executable).with_name("cea"), "figure", *arguments]
        return subprocess.run(command, capture_output=True, text=True)

    first, again = (cea("2", "--out", str(tmp_path), *more) for more in (["--recompute"], []))
    assert first.returncode == 0, first.stderr
    assert "drawn from stored data" not in first.stdout
    assert "drawn from stored data" in again.stdout
    assert (tmp_path / "figure_2_iga.png").exists()
