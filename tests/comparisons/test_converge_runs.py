"""``cea converge`` from a scene to its page: runs, budgets, refusals, ranks."""

import json
from dataclasses import replace
from math import inf, pi
from time import perf_counter
from types import SimpleNamespace

import numpy as np
import pytest
from exact_scenes import ExactScene
from mpi import on_ranks
from typer.testing import CliRunner

from cea.eigen.eigenvalue_matching import assign
from cea.errors import InputError
from comparisons.cli.app import app
from comparisons.converge import levels, tables, words
from comparisons.converge.course import Course, left_to_correction
from comparisons.converge.page import read_converge, write_converge
from comparisons.converge.plans import Plans
from comparisons.converge.request import Request
from comparisons.converge.steps import Step
from comparisons.converge.study import run_converge
from comparisons.converge.told import errors_of
from comparisons.kit.progress import Progress
from scenes.memory import estimated_memory
from scenes.read import load_scene
from scenes.refinement import Resolution, mixed, refined

SILENT = Progress(step=lambda _: None, stage=lambda _: None)
MU_CRITICAL = 0.05989842834808168909
"""Exactly known threshold of flutter of the scene ``blocks`` (cea exact blocks --thresholds)."""


def errors_and_bars(data, exact):
    """Errors of lambda and their bars, mode by mode."""
    values = np.array([m["growth"] + 2j * pi * m["frequency"] for m in data["modes"]])
    bars = np.array([np.hypot(2 * pi * m["frequency_bar"], m["growth_bar"]) for m in data["modes"]])
    rows, columns = assign(np.abs(values[:, None] - exact) / np.abs(exact))
    assert len(rows) == len(values)
    return np.abs(values[rows] - exact[columns]), bars[rows]


@pytest.fixture(scope="module")
def result():
    """Blocks to four digits on both backends."""
    return run_converge(Request("blocks", digits=4), SILENT)


def test_both_backends_hold_the_digits_and_agree(result):
    assert {b: of["held"] for b, of in result["backends"].items()} == {"iga": True, "fe": True}
    assert all(mode["agree"] for mode in result["modes"])
    assert result["warnings"] == []
    assert all(m["frequency_bar"] < 0.5e-4 * m["frequency"] for m in result["modes"])


def test_true_errors_lie_within_the_bars(result):
    errors, bars = errors_and_bars(result, ExactScene("blocks").exact())
    assert (errors <= bars).all()


def test_the_mesh_for_sweeps_is_the_cheapest_that_is_good_enough(result, tmp_path):
    runs = [e for e in result["levels"] if not e["corrected"]]
    levels = [e for e in runs if e["bound"] is not None and e["bound"] <= 0.5e-2]
    best = min(levels, key=lambda level: level["seconds"])
    write_converge(result, tmp_path)
    scene = load_scene(tmp_path / "for_sweeps.toml")
    assert {body.backend for body in scene.bodies.values()} == {best["backend"]}
    for name, body in scene.bodies.items():
        mesh = body.mesh.fe or body.mesh.iga
        assert list(mesh.elements) == best["elements"][name]


def test_a_mesh_is_its_own_measure_only_with_its_bars():
    final = np.array([1j, 2j])
    newest, other = (SimpleNamespace(eigenvalues=values) for values in (final, 1.01 * final))
    assert errors_of(newest, final, np.array([0.1, 0.0]))["worst"] == 0.0
    assert errors_of(newest, final, np.array([0.1, 0.0]))["bound"] == pytest.approx(0.1)
    assert errors_of(other, final, np.array([0.1, 0.0]))["bound"] == pytest.approx(0.11)
    assert errors_of(newest, final, np.array([0.1, np.inf]))["bound"] is None
    short = errors_of(SimpleNamespace(eigenvalues=final[:1]), final, np.zeros(2))
    assert (short["worst"], short["bound"], short["missing"]) == (None, None, 1)


def test_the_page_and_its_files_tell_what_was_found(result, tmp_path):
    page = write_converge(result, tmp_path)
    text = page.read_text()
    assert "plotly" in text
    assert "1 unstable" in text
    stored = read_converge(tmp_path)
    assert stored["modes"] == json.loads(json.dumps(result["modes"]))
    for table in tables.TABLES:
        made = table(stored)
        assert (tmp_path / f"{made.name}.csv").is_file()
        assert len(made.rows) >= 1
    assert write_converge(stored, tmp_path).read_text() == text
    assert len(words.held(result)) == 2
    assert "digit more is expected to cost" in words.held(result)[0]


def test_the_front_holds_no_mesh_that_another_beats(result):
    front = tables.front_of(result)
    points = [(tables.error_of(result, level), level["seconds"]) for level in result["levels"]]
    for i in front:
        assert not any(e < points[i][0] and t < points[i][1] for e, t in points)
    assert front


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("factor", "verdicts"),
    [(1.0, ["undecided", "undecided"]), (1.001, ["stable", "unstable"]), (0.999, ["stable"] * 2)],
)
def test_at_a_known_threshold_the_sign_of_growth_is_undecided(factor, verdicts):
    overrides = (f'contacts.interface.mu="{MU_CRITICAL * factor!r}*sin(pi*x/2)"',)
    request = Request("blocks", digits=4, backends=("iga",), overrides=overrides)
    data = run_converge(request, SILENT)
    pair = [m for m in data["modes"] if abs(m["frequency"] - 0.46164) < 2e-4]
    assert sorted(mode["verdict"] for mode in pair) == verdicts


@pytest.mark.grid(quick=1)
def test_a_body_without_contacts_converges(backend):
    """A disc alone, clamped: layers at the clamped edge, no contact surfaces to match on."""
    coarse = ("analysis.max_frequency=1500.0", f"bodies.disc.mesh.{backend}.elements=[4, 16, 1]")
    request = Request("disc", digits=1, backends=(backend,), overrides=coarse, budget=60.0)
    data = run_converge(request, SILENT)
    assert len(data["modes"]) >= 3
    assert {mode["verdict"] for mode in data["modes"]} == {"stable"}
    assert data["backends"][backend]["held"]


@pytest.mark.grid(quick=1)
def test_what_a_digit_more_costs_is_told_while_no_bar_is_known(backend, monkeypatch):
    """A mode that one of two meshes does not have has an endless bar."""
    course = Course(backend, load_scene("blocks"), Request("blocks", backends=(backend,)))
    course.follow(course.run(Step(Resolution(3, 0.5), 1.0, 1.0), SILENT))
    course.measure(SILENT)
    monkeypatch.setattr(Course, "need", inf)
    step = course.cost_of(10.0)
    assert step.enough
    assert step.seconds > 0


@pytest.mark.grid(quick=1)
def test_the_newest_mesh_corrected_in_a_richer_space_is_one_more_number(backend):
    """Its bars hold the true errors, which are far below those of the mesh itself."""
    exact = ExactScene("blocks").exact()
    course = Course(backend, load_scene("blocks"), Request("blocks", backends=(backend,)))
    for density in (0.5, 1.0):
        course.follow(course.run(Step(Resolution(3, density), 1.0, 1.0), SILENT))
    before = course.judged.members
    richer = course.correction(100.0, last=True)
    course.correct(richer, SILENT)
    after = course.judged.members
    assert course.holds
    assert course.correction(100.0, last=True) is None  # once is enough
    assert [level.corrected for level in course.levels] == [False, False, True]
    for old, new in zip(before, after, strict=True):
        true = exact[np.abs(exact - new.value).argmin()]
        assert abs(new.value - true) <= np.hypot(new.frequency_bar, new.growth_bar)
        assert abs(new.value - true) < 0.2 * abs(old.value - true)
    course.follow(course.run(Step(Resolution(3, 1.5), 1.0, 1.0), SILENT))
    assert not any(level.corrected for level in course.levels)


@pytest.mark.grid(quick=1)
def test_a_last_correction_is_for_what_is_asked_where_time_is_short(backend):
    """Parts that are owed little need not fall by half too, as they do where there is the time."""
    scene = load_scene("blocks")
    course = Course(backend, scene, Request("blocks", digits=4, backends=(backend,)))
    course.follow(course.run(Step(Resolution(3, 0.5), 1.0, 1.0), SILENT))
    course.measure(SILENT)
    bodies = dict(course.sequence.last.resolution.bodies)
    upper = bodies["upper"]
    bodies["upper"] = replace(upper, densities=tuple(2 * n for n in upper.densities))
    course.follow(course.run(Step(mixed(bodies), 1.0, 1.0), SILENT))
    options = {"spare": 0.0, "share": 0.5}
    whole, asked = (
        course.plans.leanest(course.sequence, course.judged, inf, everywhere=each, **options)
        for each in (True, False)
    )
    assert asked.enough
    assert asked.seconds < whole.seconds
    between = 1.6 * 0.5 * (asked.seconds + whole.seconds)
    found = course.correction(between, last=True)
    assert found.resolution == asked.resolution
    assert course.correction(2 * whole.seconds, last=True).resolution == whole.resolution


def test_no_mesh_that_is_too_coarse_for_orders_is_left_to_a_correction(backend):
    """However few digits are asked for: bars are four times the error, which is 2e-3 at most."""
    left = {digits: left_to_correction(backend, 0.5 * 10.0**-digits) for digits in range(1, 9)}
    assert left[1] == 0.0
    assert np.exp(left[2]) * 0.5e-2 / 4 == pytest.approx(2e-3)
    assert np.exp(left[3]) == pytest.approx({"iga": 15.0, "fe": 6.0}[backend])
    assert len({left[digits] for digits in range(3, 9)}) == 1


@pytest.mark.slow
def test_the_budget_ends_a_run_that_would_take_longer(backend):
    """What the first mesh may take is a part of the budget, and what does not fit is not begun."""
    request = Request("disc_pad", digits=7, backends=(backend,), budget=10.0)
    data = run_converge(request, SILENT)
    assert data["seconds"] < 10.0
    assert not data["backends"][backend]["held"]
    assert "digits-not-held" in [warning["kind"] for warning in data["warnings"]]
    assert "budget" in data["backends"][backend]["ended"]


@pytest.mark.grid(quick=1)
def test_memory_is_told_where_it_ends_a_run(backend, monkeypatch):
    """And only there: what the first mesh takes is free, and no more."""
    scene = load_scene("blocks")
    first = Plans(backend, scene, Request("blocks")).first(45.0)
    need = estimated_memory(refined(scene, backend, first.resolution)).bytes
    monkeypatch.setattr(levels, "available_memory", lambda: 1.0001 * need / 0.9)
    request = Request("blocks", digits=7, backends=(backend,), budget=60.0)
    data = run_converge(request, SILENT)
    assert len(data["levels"]) <= 2  # the first, perhaps in a richer space
    assert "memory" in data["backends"][backend]["ended"]


def test_a_mesh_that_takes_longer_than_the_budget_is_given_up(tmp_path):
    """Stages that begin after the budget end it, on all ranks alike."""
    waited = perf_counter() - 100.0  # the command began long ago
    request = Request("blocks", backends=("iga",), budget=50.0)
    data = run_converge(request, SILENT, waited)
    assert data["modes"] == []
    assert data["levels"] == []
    assert "given up" in data["backends"]["iga"]["ended"]
    assert "No mesh was solved" in write_converge(data, tmp_path).read_text()


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--digits", "0"], "digits = 0"),
        (["--growth-digits", "40"], "growth_digits = 40"),
        (["--budget", "-1"], "budget = -1.0"),
        (["--sweep-digits", "0"], "sweep_digits = 0"),
        (["--redraw", "--unstable"], "unstable = True"),
    ],
)
def test_wrong_options_are_refused_before_work(options, named, tmp_path):
    done = CliRunner().invoke(app, ["converge", "blocks", *options, "--out", str(tmp_path / "x")])
    assert isinstance(done.exception, InputError)
    assert named in str(done.exception)
    assert not (tmp_path / "x").exists()


def test_a_static_scene_is_refused():
    with pytest.raises(InputError, match=r"analysis\.kind"):
        run_converge(Request("patch_test"), SILENT)


def test_the_command_prints_modes_and_names_its_page(tmp_path):
    out = tmp_path / "out"
    command = ["converge", "blocks", "--digits", "2", "--backend", "iga", "--out", str(out)]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    assert "± " in done.output
    assert str(out / "report.html") in done.output.replace("\n", "")
    again = CliRunner().invoke(app, ["converge", "blocks", "--redraw", "--out", str(out)])
    assert again.exit_code == 0, again.output


@pytest.mark.slow
@pytest.mark.mpi
def test_on_several_ranks_modes_are_the_same_within_their_bars():
    one, several = (on_ranks(n, "parallel_converge.blocks_to_three_digits") for n in (1, 3))
    assert one["held"]
    assert several["held"]
    assert several["verdicts"] == one["verdicts"]
    for name in ("frequencies", "growths"):
        a, b = (np.array(found[name]) for found in (one, several))
        # Times choose the meshes, so that bars may differ as values do.
        assert (np.abs(a[:, 0] - b[:, 0]) <= a[:, 1] + b[:, 1] + 1e-10).all()
