"""The report of a run holds what its record says: every mode, its marks, the shapes that fit."""

import base64
import gzip
import html
import json
import re

import numpy as np
import pytest
from mpi import cea_on_ranks
from scipy.io import mmwrite
from scipy.sparse import diags_array

from comparisons.run_report import write_run_report
from comparisons.study import shapes as of_pages
from comparisons.study.shapes import STEPS
from scenes import load_scene, run_modes, run_scene, save_result


class Page:
    """Data by their id, cells of a table, shapes of a page."""

    def __init__(self, file):
        self.text = file.read_text("utf-8")
        found = re.findall(r'<script type="application/json" id="(.+?)">(.*?)</script>', self.text)
        self.data = {name: json.loads(content) for name, content in found}
        self.traces = self.data.get("figure-stability", {"data": ()})["data"]
        if found := re.search('id="shapes".*?>(.*?)<', self.text):
            self.shapes = json.loads(gzip.decompress(base64.b64decode(found[1])))

    def modes(self):
        """Rows of cells of the table of modes, headings first; none where there is no table."""
        found = re.search(r'<table id="modes">(.*?)</table>', self.text, re.DOTALL)
        rows = re.findall(r"<tr.*?>(.*?)</tr>", found[1], re.DOTALL) if found else []
        cells = [re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row) for row in rows]
        return [[html.unescape(re.sub("<.*?>", "", cell)) for cell in row] for row in cells]


@pytest.fixture(scope="module")
def result():
    return run_modes(load_scene("drum").on("iga").change("analysis.max_frequency", 0.3))


@pytest.fixture(scope="module")
def page(result, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    return Page(write_run_report(result, save_result(result, folder / "result.json")))


def test_diagram_and_table_hold_every_mode_with_its_verdict(page, result):
    points = {
        key: (trace["name"], x, y, trace["marker"]["symbol"])
        for trace in page.traces
        for key, x, y in zip(trace.get("customdata", ()), trace["x"], trace["y"], strict=True)
    }
    cells, rows = page.modes()[1:], result.table()
    assert len(points) == len(cells) == len(rows) == len(result.frequencies)
    symbols = {"stable": "circle", "unstable": "triangle-up"}
    signs = {"stable": "● stable", "unstable": "▲ unstable"}
    for row, cell in zip(rows, cells, strict=True):
        verdict = row["verdict"]
        point = (verdict, pytest.approx(row["frequency"]), row["growth_rate"], symbols[verdict])
        assert points[f"run/{row['mode']}"] == point
        assert cell[:2] == [str(row["mode"]), signs[verdict]]
    assert {name for name, *_ in points.values()} == set(signs)
    ratio = -result.eigenvalues.real / np.abs(result.eigenvalues)
    unstable = int(np.argmin(ratio))
    assert float(cells[unstable][4].replace("−", "-")) == pytest.approx(ratio[unstable], rel=0.01)


def test_shapes_are_those_of_the_modes(page, result):
    """At phase 0 and a quarter later, to the steps that displacements are kept in."""
    scene, modes = page.shapes["scenes"]["run"], page.shapes["modes"]["run"]
    (first,) = result.most_unstable(1)
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    u = {name: result.mode_shapes(name, each.values, [first]) for name, each in cells.items()}
    outside = of_pages._outsides(cells, u)
    data = [surface.point_data for surface in outside.values()]
    exact = np.concatenate([each["real 0"] + 1j * each["imaginary 0"] for each in data])[:, :2]
    real, imaginary = (np.array(modes[str(first + 1)][p]) for p in ("real", "imaginary"))
    kept = (real + 1j * imaginary)[:2].T
    assert np.abs(real[2]).max() == 0
    factor = np.vdot(kept, exact) / np.vdot(kept, kept)
    np.testing.assert_allclose(kept * factor, exact, atol=1.5 * abs(factor))
    assert np.linalg.norm(real, axis=0).max() == pytest.approx(STEPS, abs=2)
    for body, skin in zip(scene["bodies"], outside.values(), strict=True):
        places = np.array(body["points"])[:2].T * scene["step"] + scene["low"][:2]
        np.testing.assert_allclose(places, skin.points[:, :2], atol=scene["step"])
        np.testing.assert_array_equal(np.transpose(body["triangles"]), skin.regular_faces)


def test_a_static_analysis_has_a_report(tmp_path):
    result = run_scene(load_scene("patch_test").on("fe"))
    page = Page(write_run_report(result, save_result(result, tmp_path / "result.json")))
    (plot,) = (figure for name, figure in page.data.items() if name.startswith("figure-stress"))
    for trace in plot["data"]:
        stress = result.stresses["interface"][trace["name"].removeprefix("side ")]
        np.testing.assert_allclose(trace["x"], stress.arc)
    assert not page.modes()


@pytest.mark.usefixtures("files_read_here")
def test_matrices_have_a_report_without_shapes(tmp_path, cea):
    mmwrite("M.mtx", diags_array([1.0, 1.0, 1.0]).tocoo())
    mmwrite("K.mtx", diags_array([1.0, 4.0, 9.0]).tocoo())
    files = ["--mass=M.mtx", "--stiffness=K.mtx", "--max-frequency=0.6"]
    code, _, told = cea("solve", *files, "--report", "--out", "out")
    assert not code, told
    page = Page(tmp_path / "out" / "report.html")
    assert len(page.modes()) == 1 + 3
    (trace,) = (t for t in page.traces if "customdata" in t)
    np.testing.assert_allclose(trace["x"], np.arange(1, 4) / (2 * np.pi))
    assert not hasattr(page, "shapes")


@pytest.mark.slow
@pytest.mark.mpi
def test_two_ranks_write_the_same_page(page, tmp_path):
    """Modes are the same; shapes too, whose sign and phase are those of the largest deflection."""
    command = ["run", "drum", "--backend", "iga", "--report", "--out", tmp_path]
    done = cea_on_ranks(2, *command, "--set", "analysis.max_frequency=0.3")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("The page to open: ") == 1
    other = Page(tmp_path / "report.html")
    for one, two in zip(page.traces, other.traces, strict=True):
        np.testing.assert_allclose(one["x"], two["x"], rtol=1e-9)
    for key in page.shapes["modes"]["run"]:
        sizes = []
        for each in (page, other):
            mode = each.shapes["modes"]["run"][key]
            sizes.append(np.hypot(mode["real"], mode["imaginary"]))
        np.testing.assert_allclose(*sizes, atol=3)
