"""The report: what it says, shows and writes is what the data say."""

import csv
import json
from copy import deepcopy

import numpy as np
import pytest
from matplotlib.colors import to_hex
from report_data import EXACT, Page, small_comparison

from cea.timing import STAGES
from comparisons.agreement import figures, tables, words
from comparisons.agreement.page import write_report
from comparisons.agreement.study import warnings_of
from comparisons.agreement.time_saved import compared
from comparisons.kit.numbers import listed, number, per_cent, plain
from comparisons.kit.run_warnings import merged_warnings

_KINDS = ("worst", "median")


@pytest.fixture
def data():
    return small_comparison()


@pytest.fixture
def report(data, tmp_path):
    return write_report(data, [], tmp_path / "new" / "folder")


@pytest.fixture
def page(report):
    return Page(report.read_text(encoding="utf-8"))


def rows_of(file):
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_page_needs_no_other_file(report, page):
    assert report.name == "report.html"
    assert not page.tags & {"link", "iframe", "object"}
    assert all(a.startswith(("data:", "#")) for a in page.addresses)
    source = report.read_text(encoding="utf-8")
    assert "url(" not in source
    assert "@import" not in source
    assert report.stat().st_size < 4e6


def test_result_json_holds_the_data_and_names_the_files(report, data):
    result = json.loads((report.parent / "result.json").read_text())
    assert {key: result[key] for key in data} == json.loads(json.dumps(data))
    assert len(result["figures"]) == 4
    assert len(result["tables"]) == 14
    assert result["pictures"] == []
    for file in (*result["figures"], *result["tables"]):
        assert (report.parent / file).stat().st_size > 0


@pytest.mark.slow
def test_tables_of_the_page_hold_the_numbers(page):
    patch = page.tables["patch_test"]
    assert patch[3] == [
        *("NURBS", "Greville", "25", "10⁶", "1\u202f778", "3\u202f556", "3\u202f556"),
        *("3\u202f233", "1.100"),
    ]
    assert patch[1][-2:] == ["–", "–"]
    assert ["finite elements", "GPTS 5 x 5", "2", "6\u202f246.92", "+363.88"] in [
        row[:5] for row in page.tables["unstable_modes"]
    ]
    assert len(page.tables["unstable_modes"]) == 1 + 4
    paired, alone, gpts = page.tables["agreement"][1:]
    assert paired[1:] == gpts[1:]
    assert gpts == [
        *("GPTS", "both", "6\u202f246.92", "6\u202f240.74", "+0.099", "+363.88", "+364.04"),
        *("−0.044", "0.9987"),
    ]
    assert alone == [
        *("collocation", "NURBS only", "–", "14\u202f990.00", "–", "–", "+84.25", "–", "–")
    ]
    assert page.tables["disc_alone"][1][-2:] == ["0.020", "0.030"]
    assert page.tables["windows"][1][6:9] == ["44", "3", "no"]
    assert ["total", "2.10", "4.20", "2.10"] in page.tables["time_saved"]
    assert ["gmsh", "none", "2 of 3"] in page.tables["skipped"]
    assert ["analysis.max_frequency", "15000 Hz"] in page.tables["parameters"]
    assert ["python", "3.12.0"] in page.tables["machine"]
    assert ["commit", "0123456789abcdef"] in page.tables["machine"]


@pytest.mark.slow
def test_csv_files_agree_with_result_json(report):
    folder = report.parent
    result = json.loads((folder / "result.json").read_text())
    runs = result["disc_pad"]["runs"]
    values = [(run, value) for run in runs for value in run["eigenvalues"]]
    written = rows_of(folder / "eigenvalues.csv")
    assert len(written) == len(values)
    for row, (run, value) in zip(written, values, strict=True):
        assert (row["backend"], row["formulation"]) == (run["backend"], run["formulation"])
        assert float(row["frequency"]) == pytest.approx(value["im"] / (2 * np.pi), rel=1e-15)
        assert float(row["growth"]) == value["re"]
    patch = rows_of(folder / "patch_test.csv")
    assert [float(row["oscillation"]) for row in patch] == [
        run["oscillation"] for run in result["patch_test"]["runs"]
    ]
    assert patch[0]["ratio"] == ""
    stresses = rows_of(folder / "patch_stresses.csv")
    assert [stresses[i]["sigma_n"] for i in (1, 2)] == [str(EXACT + 38.7), ""]
    times = rows_of(folder / "stage_times.csv")
    assert len(times) == 4 + 3 + 4
    for row in times:
        assert sum(float(row[stage]) for stage in STAGES) == pytest.approx(float(row["total"]))


def test_summary_follows_the_data(data):
    text = words.summary(data)
    assert "have 1 unstable mode up to 15 kHz on finite elements and 1 on NURBS" in text
    assert "0.099 % in frequency and 0.044 % in growth rate" in text
    assert "the worst is 1.100 times what was expected" in text
    assert "0.0030 in 4.2 s (hexahedra, 5 x 40 x 1)" in text
    assert "takes 50 % less processor time (median of 4 pairs of runs" in text
    data["disc_pad"]["agreement"]["gpts"] = {
        "pairs": [],
        "only_first": [{"frequency": 6000.4, "growth": 20.0}],
        "only_second": [],
    }
    text = words.summary(data)
    assert "1 unstable mode up to 15 kHz on finite elements and 0 on NURBS" in text
    assert "Finite elements alone find one at 6000 Hz." in text
    assert "modal assurance" not in text


@pytest.mark.slow
def test_warnings_of_runs_are_told(data, tmp_path):
    assert words.warned(data) == []
    runs = [({"scene": "disc_pad", "backend": each}, ()) for each in ("fe", "iga")]
    lost = {"kind": "window", "message": "three modes are lost", "data": {}}
    data["warnings"] = merged_warnings([*runs, ({"scene": "disc_pad"}, [lost])], "runs")
    text = Page(write_report(data, [], tmp_path).read_text(encoding="utf-8")).text
    assert "Three modes are lost (at 1 of 3 runs: scene = disc_pad)." in text


def test_warnings_of_the_record_are_those_of_all_its_runs(data):
    crude = {"kind": "point-rule", "message": "too crude", "data": {"contact": "interface"}}
    parts = ("patch_test", "disc_alone", "disc_pad")
    for part in parts:
        for run in data[part]["runs"]:
            run["warnings"] = [crude] if run["backend"] == "iga" else []
    (told,) = warnings_of(data)
    points = [place["point"] for place in told["data"]["places"]]
    count = sum(run["backend"] == "iga" for part in parts for run in data[part]["runs"])
    assert len(points) == count
    assert {point["scene"] for point in points} == set(parts)
    assert {point["backend"] for point in points} == {"iga"}


def test_no_saving_is_claimed_that_equal_runs_are_apart(data):
    saved = data["time_saved"]
    assert words.saved(data).endswith(
        "50 % less processor time (median of 4 pairs of runs, 45 % less to 55 % less); "
        "equal runs are up to 10 % apart."
    )
    saved["ratio"] = {"median": 0.92, "least": 0.85, "largest": 1.02}
    assert "cannot be told: it takes 8.0 % less (median of 4 pairs" in words.saved(data)
    assert "equal runs are up to 10 % apart" in words.saved(data)
    saved["ratio"]["median"] = 1.2
    assert "takes 20 % more processor time" in words.saved(data)


def test_pairs_of_runs_and_equal_runs_are_compared():
    """The machine slows by a tenth from each run to the next: pairs the other way round show it."""
    slower = 1.1 ** np.arange(8)
    work = {"lean": 1.0, "full": 2.0}
    order = ["lean", "full", "full", "lean"] * 2
    runs = [
        (kind, {"krylov": work[kind] * t, "search": 0.0})
        for kind, t in zip(order, slower, strict=True)
    ]
    found = compared(runs)
    assert found["pairs"] == 4
    assert found["ratio"]["least"] == pytest.approx(0.5 / 1.1)
    assert found["ratio"]["largest"] == pytest.approx(0.5 * 1.1)
    assert found["ratio"]["median"] == pytest.approx(0.5 * (1.1 + 1 / 1.1) / 2)
    assert found["noise"] == pytest.approx(0.1)
    assert found["full"] == {"krylov": pytest.approx(np.median(2 * slower[[1, 2, 5, 6]]))}
    assert found["full_seconds"] == pytest.approx(found["full"]["krylov"])


def test_lone_modes_are_explained_only_near_the_end_of_the_window(data):
    (sentence,) = words.lone_modes(data)
    assert "NURBS alone find with collocation at 14990 Hz" in sentence
    data["disc_pad"]["agreement"]["collocation"]["only_second"][0]["frequency"] = 9000.0
    assert words.lone_modes(data) == []


def test_words_count_what_was_missed_and_kept(data):
    assert words.missed_points(data).startswith("0 of 1\u202f225 contact points")
    assert words.kept_bodies(data).startswith("0 runs of 11")
    changed = deepcopy(data)
    changed["disc_pad"]["runs"][0]["contacts"]["c"]["status"]["missed"] = 7
    changed["patch_test"]["runs"][0]["timings"]["meshing"] = 0.0
    assert words.missed_points(changed).startswith("7 of 1\u202f232")
    assert words.kept_bodies(changed).startswith("1 run of 11")
    assert "4.0 · 10⁻¹² (NURBS, Greville)" in words.errors_of_modes(data)


@pytest.mark.slow
def test_a_comparison_without_unstable_modes_is_reported(data, tmp_path):
    for run in data["disc_pad"]["runs"]:
        run["unstable"] = []
    nothing = {"pairs": [], "only_first": [], "only_second": []}
    data["disc_pad"]["agreement"] = dict.fromkeys(("collocation", "grid", "gpts"), nothing)
    page = Page(write_report(data, [], tmp_path).read_text(encoding="utf-8"))
    assert "have 0 unstable modes up to 15 kHz on finite elements and 0 on NURBS" in page.text
    assert "unstable_modes" not in page.tables


def test_stability_diagram_holds_every_eigenvalue(data):
    (axes,) = figures.stability(data).axes
    zero, *lines = axes.lines
    assert list(zero.get_ydata()) == [0, 0]
    for line, run in zip(lines, data["disc_pad"]["runs"], strict=True):
        expected = [(v["im"] / (2000 * np.pi), v["re"]) for v in run["eigenvalues"]]
        np.testing.assert_allclose(line.get_xydata(), expected)
        assert line.get_marker() == figures.MARKERS[run["backend"]]
        assert to_hex(line.get_markeredgecolor()).upper() == figures.COLOURS[run["method"]]
    bottom, top = axes.get_ylim()
    assert bottom == -top


@pytest.mark.slow
def test_the_page_draws_every_eigenvalue(page, data):
    *traces, ring = page.data["figure-stability"]["data"]
    assert (ring["meta"], ring["x"]) == ("shown", [])
    for i, (trace, run) in enumerate(zip(traces, data["disc_pad"]["runs"], strict=True)):
        np.testing.assert_allclose(
            trace["x"], [value["im"] / (2 * np.pi) for value in run["eigenvalues"]]
        )
        assert trace["y"] == [value["re"] for value in run["eigenvalues"]]
        count = len(run["eigenvalues"])
        assert trace["customdata"] == [f"{i}/{j + 1}" for j in range(count)]
        filled = [j + 1 for j in range(count) if "open" not in trace["marker"]["symbol"][j]]
        assert filled == [mode["mode"] for mode in run["unstable"]]


@pytest.mark.slow
def test_the_page_draws_stresses_errors_and_times(page, data):
    runs = [run for run in data["patch_test"]["runs"] if run["P"] == 1e6]
    for i, run in enumerate(runs):
        side_b, side_a, exact = page.data[f"figure-patch-{i}"]["data"]
        for trace, side in ((side_a, "a"), (side_b, "b")):
            assert trace["y"] == run["stresses"]["interface"][side]["sigma_n_along"]
        assert exact["y"] == [EXACT, EXACT]
    assert f"figure-patch-{len(runs)}" not in page.data
    first = page.data["figure-disc-time"]["data"][0]
    disc = data["disc_alone"]["runs"][:2]
    assert first["y"] == [run["worst_error"] for run in disc]
    assert first["x"] == [run["seconds"] for run in disc]
    assert page.data["figure-disc-dofs"]["data"][0]["x"] == [run["dofs"]["free"] for run in disc]
    parts = [page.data[f"figure-stages-{i}"]["data"] for i in range(3)]
    totals = [np.sum([trace["x"] for trace in traces], axis=0) for traces in parts]
    np.testing.assert_allclose(totals[1], [run["seconds"] for run in data["disc_pad"]["runs"]])


@pytest.mark.slow
def test_names_stay_texts(data, tmp_path):
    """In tables, in the data of plots, and where plotly.js would take tags for its own."""
    evil = "</script><b onclick=alert(1)>rule</b>"
    for run in data["disc_pad"]["runs"]:
        run["formulation"] = evil
    source = write_report(data, [], tmp_path).read_text(encoding="utf-8")
    assert "<b onclick" not in source
    page = Page(source)
    assert evil in {row[1] for row in page.tables["unstable_modes"]}
    assert "b" not in page.tags
    name = page.data["figure-stability"]["data"][0]["name"]
    assert name == "finite elements, &lt;/script&gt;&lt;b onclick=alert(1)&gt;rule&lt;/b&gt;"


@pytest.mark.slow
def test_every_finding_leads_to_its_section(report, data):
    source = report.read_text(encoding="utf-8")
    for place, sentence in words.findings(data):
        assert f'<section id="{place}">' in source
        assert f'href="#{place}"' in source
        assert sentence in Page(source).text


def test_patch_panels_hold_both_sides_of_the_least_P(data):
    panels = [axes for axes in figures.patch_stresses(data).axes if axes.axison]
    titles = [axes.get_title() for axes in panels]
    assert titles == ["finite elements, GPTS 15 x 15", "NURBS, Greville", "NURBS, GPTS 15 x 15"]
    runs = [run for run in data["patch_test"]["runs"] if run["P"] == 1e6]
    for axes, run in zip(panels, runs, strict=True):
        lines = {line.get_label(): line for line in axes.lines}
        assert lines["side b"].get_linestyle() == "-"
        assert lines["side a"].get_linestyle() == "--"
        assert set(lines["exact"].get_ydata()) == {EXACT}
        x, y = lines["side a"].get_data()
        np.testing.assert_allclose(x, [0.0, 4.5, 9.0])
        np.testing.assert_allclose(y, [EXACT, EXACT + run["oscillation"], np.nan])


def test_error_figure_holds_each_line_against_time_and_dofs(data):
    time, dofs = figures.disc_errors(data).axes
    runs = data["disc_alone"]["runs"]
    for axes, abscissa in ((time, lambda r: r["seconds"]), (dofs, lambda r: r["dofs"]["free"])):
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        found = {line.get_label(): line.get_xydata() for line in axes.lines}
        assert set(found) == {f"{n}, {k}" for n in ("hexahedra", "NURBS") for k in _KINDS}
        for kind in _KINDS:
            expected = [(abscissa(run), run[f"{kind}_error"]) for run in runs[:2]]
            np.testing.assert_allclose(found[f"hexahedra, {kind}"], expected)


def test_bars_stack_to_the_run_time(data):
    figure = figures.stage_bars(data)
    assert [len(axes.get_yticks()) for axes in figure.axes] == [4, 3, 4]
    disc_and_pad = figure.axes[1]
    assert len(disc_and_pad.containers) == len(STAGES)
    for j, run in enumerate(data["disc_pad"]["runs"]):
        bars = [container[j] for container in disc_and_pad.containers]
        assert [bar.get_width() for bar in bars] == pytest.approx(list(run["timings"].values()))
        ends = np.cumsum(list(run["timings"].values()))
        assert [bar.get_x() + bar.get_width() for bar in bars] == pytest.approx(ends.tolist())


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (None, 3, "–"),
        (0.0, 3, "0"),
        (41400, 3, "41\u202f400"),
        (3233.4, 3, "3\u202f233"),
        (-0.04496, 2, "−0.045"),
        (0.9996, 3, "1.00"),
        (1e14, 1, "10¹⁴"),
        (2.5e-9, 2, "2.5 · 10⁻⁹"),
        (9.996e-9, 3, "1.00 · 10⁻⁸"),
    ],
)
def test_numbers_are_shown_with_their_digits(value, digits, text):
    assert number(value, digits) == text


def test_parameters_and_lists_are_shown_plainly():
    assert plain([25.0, 2.1e11, 1e9, 3, -0.5]) == "25, 2.1 · 10¹¹, 10⁹, 3, −0.5"
    assert per_cent(0.0123) == "+1.2"
    assert [listed("a"), listed("ab"), listed("abc")] == ["a", "a and b", "a, b and c"]


def test_every_run_has_its_label(data):
    labels = [(section, label) for section, label, _ in tables.runs(data)]
    assert len(labels) == len(set(labels)) == 11
    assert ("disc alone", "reference, 9 x 64 x 2") in labels
