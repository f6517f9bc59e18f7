"""The engine of studies: cases, resuming, records, processes, pages, the command."""

import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from math import inf
from pathlib import Path

import pandas as pd
import pytest
from mpi import on_ranks
from small_study import APART, HASTY, STUDY, Options

from cea.errors import InputError
from comparisons.cli import study as command
from comparisons.cli.app import RENAMED
from comparisons.study import run as engine
from comparisons.study.page import write_study
from comparisons.study.result import read
from comparisons.study.run import finished, parts, run, selected

HELPERS = Path(__file__).parents[1] / "helpers"
EVERY = ["1", "2", "3"]
"""Cases of the study."""


@pytest.fixture
def clean(monkeypatch):
    """A checkout without changes."""
    monkeypatch.setattr(engine, "commit", lambda: "abc")


@pytest.fixture
def helpers_found(monkeypatch):
    """Other processes find the helpers of the tests."""
    path = os.pathsep.join([str(HELPERS), str(HELPERS.parents[1])])
    monkeypatch.setenv("PYTHONPATH", path)


def noted(out):
    log = Path(out) / "log"
    return log.read_text().split() if log.is_file() else []


def options(tmp_path, **given):
    return Options(log=str(tmp_path / "log"), **given)


def test_a_result_is_read_back_as_it_was_written(tmp_path):
    result = run(STUDY, options(tmp_path, factor=inf), tmp_path)
    result.save(tmp_path)
    again = read("squares", tmp_path)
    pd.testing.assert_frame_equal(again.frame(), result.frame())
    assert list(again.frame()) == ["size", "kind", "square", "ranks"]
    assert list(again.frame(kind="even")["size"]) == [2]
    assert type(result.cases[0]["tables"]["runs"][0]["square"]) is float
    assert list(again.array({"size": 3}, "powers")) == [0, 1, 2]
    assert again.frame("no such table").empty
    with pytest.raises(InputError, match="kept"):
        again.array({"size": 3}, "other")
    with pytest.raises(InputError, match="out"):
        read("other", tmp_path)


def test_failed_cases_are_told_and_a_missing_value_is_kept(tmp_path):
    result = run(STUDY, options(tmp_path, sizes=(5, 13, 404, 2)), tmp_path / "out")
    assert list(result.failed()["size"]) == [13, 404]
    assert result.failed()["reason"][0] == "unlucky"
    assert "square" in result.failed()["reason"][1]
    assert list(result.frame()["square"].isna()) == [True, False]


KILLED = """
import os, signal, sys, small_study as s
from dataclasses import replace
from pathlib import Path
from comparisons.study import run as engine

def evaluate(case, session):
    if case["size"] == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return s.evaluate(case, session)

engine.commit = lambda: "abc"
top = Path(sys.argv[1])
engine.run(replace(s.STUDY, evaluate=evaluate), s.Options(log=str(top / "log")), top / "out")
"""


def test_a_study_that_was_killed_goes_on_where_it_was(tmp_path, clean, helpers_found):
    """The process is killed while it computes its third case."""
    ended = subprocess.run([sys.executable, "-c", KILLED, tmp_path])
    assert ended.returncode == -signal.SIGKILL
    assert noted(tmp_path) == EVERY[:2]
    result = run(STUDY, options(tmp_path), tmp_path / "out")
    assert noted(tmp_path) == EVERY
    assert list(result.frame()["square"]) == [1, 4, 9]
    assert list(result.array({"size": 2}, "powers")) == [0, 1]
    finished(tmp_path / "out")
    assert not parts(tmp_path / "out").exists()


def test_stored_cases_are_taken_where_everything_agrees(tmp_path, clean, monkeypatch):
    out = tmp_path / "out"

    def computed(study=STUDY, anew=False, **given):
        (tmp_path / "log").unlink(missing_ok=True)
        run(study, options(tmp_path, **given), out, anew=anew).save(out)
        finished(out)
        return noted(tmp_path)

    with_scene = replace(STUDY, scene=lambda case, o: None)
    assert computed() == EVERY
    assert computed() == []
    assert computed(anew=True) == EVERY
    assert computed(factor=2.0) == EVERY
    assert computed(with_scene, factor=2.0) == []
    monkeypatch.setattr(engine, "plain_data", lambda scene: {"another": 1})
    assert computed(with_scene, factor=2.0) == EVERY
    monkeypatch.setattr(engine, "commit", lambda: "def")
    assert computed(with_scene, factor=2.0) == EVERY
    monkeypatch.setattr(engine, "commit", lambda: "def-dirty")
    for _ in range(2):
        assert computed(factor=2.0) == EVERY


def test_shipped_cases_are_taken_at_any_commit(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "commit", lambda: "old")
    run(STUDY, options(tmp_path), tmp_path / "a").save(tmp_path / "shipped")
    monkeypatch.setattr(engine, "commit", lambda: "new-dirty")
    shipped = replace(STUDY, shipped=tmp_path / "shipped")
    result = run(shipped, options(tmp_path), tmp_path / "b")
    assert noted(tmp_path) == EVERY
    assert {case["commit"] for case in result.cases} == {"old"}


def test_only_computes_the_cases_chosen_and_keeps_stored_ones(tmp_path, clean):
    out = tmp_path / "out"
    run(STUDY, options(tmp_path), out, only={"kind": "even"})
    result = run(STUDY, options(tmp_path), out, only={"size": "3"})
    assert noted(tmp_path) == ["2", "3"]
    assert list(result.frame()["size"]) == [2, 3]
    for only, allowed in (({"age": "1"}, "size, kind"), ({"size": "7"}, "1, 2, 3")):
        with pytest.raises(InputError, match=allowed):
            selected(STUDY, Options(), only)


def test_a_crash_and_an_overlong_case_end_themselves_alone(tmp_path, helpers_found):
    result = run(HASTY, Options(sizes=(999, 2, 666)), tmp_path / "out")
    assert list(result.frame()["square"]) == [4]
    assert list(result.failed()["reason"]) == ["took more than 3 s", "ended with code 7"]


@pytest.mark.mpi
def test_cases_run_on_their_number_of_ranks(tmp_path, helpers_found):
    result = run(APART, Options(sizes=(2,)), tmp_path / "out")
    assert list(result.frame()["together"]) == [2]


def together(folder):
    """A study on all ranks; one that starts processes of its own is refused there."""
    result = run(STUDY, Options(), Path(folder) / "out")
    assert list(result.frame()["ranks"]) == [2, 2, 2]
    with pytest.raises(InputError, match="processes of its own"):
        run(APART, Options(), Path(folder) / "apart")


@pytest.mark.mpi
def test_on_several_ranks_every_rank_has_the_result(tmp_path):
    on_ranks(2, together, str(tmp_path))
    assert len(list(parts(tmp_path / "out").glob("*.json"))) == 3


def test_the_page_needs_no_other_file_escapes_what_it_shows_and_is_drawn_anew_alike(tmp_path):
    out, again = tmp_path / "out", tmp_path / "again"
    page = write_study(STUDY, run(STUDY, options(tmp_path, sizes=(1, 2, 5, 13)), out), out)
    text = page.read_text()
    for shown in ("Squares &lt;of&gt; numbers", "square &amp; more", "is 4.", "unlucky"):
        assert shown in text
    assert "<odd>" not in text
    assert not re.search(r'(src|href)="(?!#|data:)', text)
    assert "No table." not in text, "a section that shows nothing is left out"
    lines = (out / "squares.csv").read_text().splitlines()
    assert lines == ["size,kind,square,ranks", "1,<odd>,1.0,1", "2,even,4.0,1", "5,<odd>,,1"]
    write_study(STUDY, read("squares", out), again)
    for file in sorted(out.iterdir()):
        if file.is_file():
            assert file.read_bytes() == (again / file.name).read_bytes(), file.name


@pytest.fixture
def squares(monkeypatch, cea):
    """The command ``cea study squares``."""
    monkeypatch.setitem(command.STUDIES, "squares", ("x", "Squares."))
    monkeypatch.setattr(command, "study_in", lambda module: STUDY)
    return lambda line: cea("study", "squares", *line.split())


def test_options_of_a_study_are_options_of_its_command(squares, tmp_path):
    _, told, _ = squares("--help")
    assert "Exponent." in told
    assert "What is squared." in told
    code, told, fault = squares("--sizes 4 --sizes 6 --power 3 --out .")
    assert code == 0, fault
    assert list(read("squares", tmp_path).frame()["square"]) == [64, 216]
    assert told.splitlines()[0] == "The largest is 216."
    assert "report.html" in told
    code, told, fault = squares("--sizes 100 --out .")
    assert code == 1, "the check of the study ends the command"
    assert "too large" in told + fault


def test_redraw_runs_nothing(squares, tmp_path):
    assert squares("--quick --log log --out .")[0] == 0
    (tmp_path / "report.html").unlink()
    assert squares("--redraw --out .")[0] == 0
    assert (tmp_path / "report.html").is_file()
    assert noted(tmp_path) == ["2"]
    assert "quick" in squares("--redraw --quick --out .")[2]
    assert "LABEL=VALUE" in squares("--only size --out .")[2]


def test_old_names_tell_the_new_ones(cea):
    for name, new in RENAMED.items():
        assert f"cea {new}" in cea(name)[2]
