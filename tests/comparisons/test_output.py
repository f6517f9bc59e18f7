"""What a run prints: no number is cut, what has no room is named, colour is never the only sign."""

import re
from io import StringIO
from math import inf

import numpy as np
import pytest
from rich.console import Console

from cea.eigen.spectrum import Spectrum, Window
from cea.errors import ResultWarning
from cea.timing import StageTimer
from comparisons.cli.output import print_result
from scenes import Result, load_scene


def terminal(width):
    return Console(
        width=width, file=StringIO(), force_terminal=True, highlight=False, no_color=True
    )


def lines_of(console):
    return re.sub(r"\x1b\[[\d;]*m", "", console.file.getvalue()).splitlines()


@pytest.fixture
def result():
    """Modes that are rigid, stable, undecided and unstable, with growth of many digits."""
    modes = Spectrum(
        np.array([0.0, 3000j, 123.456 + 40000j, 123456.789 + 70000j]),
        residuals=np.full(4, 1.5e-10),
        conditions=np.array([1.0, 12345.6, 2.0, 1.0]),
        growth_uncertainties=np.array([1e-4, 1e-3, 200.0, 2e-3]),
        window=Window(12000.0, 1e9, inf, 4, 2, inf, True, False, 1e10, 4, None),
        bounded=np.array([False, True, False, False]),
        warnings=(ResultWarning("short-modes", "longer than a line of a terminal " * 3),),
    )
    return Result(
        load_scene("disc_pad"),
        StageTimer(),
        {"newton": "known stiffness"},
        modes.warnings,
        spectrum=modes,
        record={"command": "run", "dofs": {"free": 1234}},
    )


@pytest.mark.parametrize("width", [40, 120])
def test_modes_keep_their_digits_on_any_terminal(width, result):
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
