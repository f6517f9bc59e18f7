"""What a run prints: at any width of the terminal, no number cut, colour never the only sign."""

import re
from io import StringIO
from math import inf

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from cea.eigen.spectrum import Spectrum, Window
from cea.errors import ResultWarning
from cea.timing import StageTimer
from comparisons.cli.output import print_frame, print_result, working
from comparisons.study.columns import Column
from comparisons.study.numbers import shown
from comparisons.study.sections import Table
from scenes import Result, load_scene

WIDTHS = (40, 120)
WINDOW = Window(12000.0, 1e9, inf, 4, 2, inf, True, False, 1e10, 4, None)
LONG = ResultWarning("short-modes", "a sentence about modes that is longer than a line " * 3)


def terminal(width, *, is_terminal=True):
    return Console(
        width=width,
        file=StringIO(),
        force_terminal=is_terminal,
        color_system=None,
        highlight=False,
        no_color=True,
    )


def lines_of(console):
    return re.sub(r"\x1b\[[\d;]*m", "", console.file.getvalue()).splitlines()


@pytest.fixture
def result():
    """Modes that are rigid, stable, undecided and unstable, with growth of many digits."""
    values = np.array([0.0, 3000j, 123.456 + 40000j, 123456.789 + 70000j])
    modes = Spectrum(
        values,
        residuals=np.full(4, 1.5e-10),
        conditions=np.array([1.0, 12345.6, 2.0, 1.0]),
        growth_uncertainties=np.array([1e-4, 1e-3, 200.0, 2e-3]),
        window=WINDOW,
        bounded=np.array([False, True, False, False]),
        warnings=(LONG,),
    )
    scene, left_out = load_scene("disc_pad"), {"newton": "known stiffness"}
    made, stored = {"command": "run"}, {"dofs": {"free": 1234}}
    return Result(
        scene,
        StageTimer(),
        left_out,
        modes.warnings,
        spectrum=modes,
        provenance=made,
        stored=stored,
    )


@pytest.mark.parametrize("width", WIDTHS)
def test_modes_fit_the_terminal_and_keep_their_digits(width, result):
    console = terminal(width)
    print_result(result, console)
    lines = lines_of(console)
    assert max(map(len, lines)) <= width
    assert not any("…" in line for line in lines)
    words = {word for line in lines for word in line.split()}
    for row in result.table():
        assert {f"{row['frequency']:.3f}", f"{row['growth_rate']:+.3f}"} <= words
    text = " ".join(" ".join(lines).split())
    left_out = text.partition("no room for: ")[2].partition(" (in result.json)")[0]
    assert ("12345.6" in words) == ("condition" not in left_out)
    assert ("1.5e-10" in words) == ("residual" not in left_out)
    assert bool(left_out) == (width < 120)


WIDE = pd.DataFrame(
    [
        ["Gauss-point-to-surface, lumped", *(1.234567e-9 * 10.0**i for i in range(6)), "a b"],
        ["mortar", *(1.234567e8 * 10.0**i for i in range(6)), "some words " * 9],
    ],
    columns=["formulation", *map(str, range(6)), "words"],
)
OWN = {str(i): Column(f"number {i}", "N/m³", shown(7)) for i in range(6)}
CAPTION = "A table whose caption is longer than most terminals are wide, as many of them are."


def test_what_was_left_out_is_named_or_explained(result):
    for explain, told in ((False, "newton"), (True, "newton: known stiffness")):
        console = terminal(100)
        print_result(result, console, explain=explain)
        lines = [line for line in lines_of(console) if "left out" in line]
        assert [told in line for line in lines] == [True]
        assert ("known stiffness" in lines[0]) == explain


@pytest.mark.parametrize("width", WIDTHS)
def test_tables_of_reports_keep_their_digits(width):
    console = terminal(width)
    print_frame(Table("made", CAPTION, lambda _: WIDE, OWN), None, console)
    lines = lines_of(console)
    text = "\n".join(lines)
    assert "…" not in text
    left_out = " ".join(text.split()).partition("no room for: ")[2]
    assert width < 80 or max(map(len, lines)) <= width
    for i in range(6):
        for cell in map(shown(7), WIDE[str(i)]):
            told = any(re.search(rf"(^| ){re.escape(cell)}( |$)", line) for line in lines)
            assert told != (f"number {i}" in left_out), cell
    assert {"Gauss-point-to-surface,", "lumped"} <= set(text.split())


def test_progress_shows_time_left_on_a_terminal_and_nothing_in_a_file():
    quiet, seen = terminal(80, is_terminal=False), terminal(80)
    for console in (quiet, seen):
        with working("sweep", steps=4, to=console) as work:
            for i in range(3):
                work.step(f"mu = {i}")
                work.stage("krylov")
    assert quiet.file.getvalue() == ""
    told = seen.file.getvalue()
    assert "mu = 2: krylov" in told
    assert "2/4" in told
    assert re.search(r"-:--:--|0:00:0\d", told)
